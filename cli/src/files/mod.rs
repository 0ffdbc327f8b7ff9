//! Files that only the command reads.

pub mod animation;
