//! What the checks know of plugins, one kind a file.

pub mod any;
pub mod box_blur;
pub mod seidel;
