//! Tests of colour by its public doors.
#![cfg(any(feature = "ocio", feature = "ocio-native"))]

mod agreement;
mod config;
mod curves;
mod golden;
mod malformed;
mod pixels;
