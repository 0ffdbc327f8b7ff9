//! OpenEXR files.

pub mod choice;
pub(crate) mod facts;
pub(crate) mod file;
mod header;
pub(crate) mod key_code;
pub mod new;
pub mod packing;
pub mod plate;
pub(crate) mod texts;
