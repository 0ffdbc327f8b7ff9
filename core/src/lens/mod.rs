//! The lens model.
