//! Tests of the public API of `seidel-colour`.
#![cfg(any(feature = "ocio", feature = "ocio-native"))]
// A failure to set up a test is a failure of the test.
#![allow(clippy::unwrap_used)]

mod agreement;
mod config;
mod conversion;
mod curves;
mod golden;
mod malformed;
