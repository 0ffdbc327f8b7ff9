//! Seidel's tests by public doors.

mod golden;
