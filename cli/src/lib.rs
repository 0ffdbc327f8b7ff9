//! The `seidel` command as a library: files, pictures and one module a command.

pub mod demo;
pub mod files;
pub mod pictures;
