//! Seidel's tests by public doors.

mod apply;
mod bad_input;
mod choice;
mod controls;
mod demo;
mod diagnose;
mod eval;
mod fit;
mod fit_pupil;
mod gap;
mod golden;
mod lens_command;
mod psf_command;
mod reference_tables;
mod self_test;
mod sequences;
mod support;
