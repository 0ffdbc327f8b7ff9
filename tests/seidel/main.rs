//! Seidel's tests by public doors.

mod apply;
mod bad_input;
mod fit;
mod golden;
mod psf_command;
mod support;
