//! The pictures against closed forms, the cases against what they promise.
