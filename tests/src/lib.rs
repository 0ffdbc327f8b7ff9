//! Seidel's tests by public doors live in this package's one test binary, `seidel`; the library
//! part is empty.
