//! Lens profiles.
