//! Tests of colour by its public doors.
#![cfg(any(feature = "ocio", feature = "ocio-native"))]
// A failure to set a test up is a failure of the test.
#![allow(clippy::unwrap_used)]

mod agreement;
mod config;
mod curves;
mod golden;
mod malformed;
mod pixels;
