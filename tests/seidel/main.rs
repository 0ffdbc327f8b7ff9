//! Seidel's tests by public doors.

mod alpha_per_channel;
mod animate;
mod apply;
mod bad_input;
mod choice;
mod controls;
mod demo;
mod depth;
mod depth_check;
mod depth_scenes;
mod diagnose;
mod eval;
mod fit;
mod fit_pupil;
mod focus;
mod gap;
mod golden;
mod lens_command;
mod occlusion;
mod pinholes;
mod psf_command;
mod reference_tables;
mod self_test;
mod sequences;
mod support;
mod windows;
