//! The library of a package of tests, and empty. The tests are in the test binary `seidel`.
