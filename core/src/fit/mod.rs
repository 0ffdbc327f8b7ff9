//! From observations to a lens profile.
