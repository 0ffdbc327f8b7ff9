//! Moments of noisy tiles.
