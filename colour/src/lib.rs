//! Colour spaces: OpenColorIO configs, processors between two of their spaces, and the project's own curves.
//!
//! [`Config`] and [`Processor`] are what others use. Behind them an engine does OpenColorIO's work, by the traits of
//! [`engine`]: by default one in Rust, with the feature `ocio-native` the C++ library. Whatever the engine, alpha stays
//! aside, samples that are not finite are zeroed and counted before a transform mixes channels, and results do not
//! depend on the number of threads. Without an engine there are [`curves`] only.
#![forbid(unsafe_code)]

pub mod curves;
pub mod engine;
mod error;
pub mod tables;

#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod config;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod pixels;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod processor;
mod source;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod spelling;

#[cfg(any(feature = "ocio", feature = "ocio-native"))]
pub use config::Config;
pub use engine::{Display, FileSpace, Space};
pub use error::{ColourError, Result};
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
pub use processor::{Alphas, Processor, Report};
pub use source::{OWN_CONFIG, Source};
