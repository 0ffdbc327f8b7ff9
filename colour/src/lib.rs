//! Colour spaces: OpenColorIO configs, processors between two of their spaces, and Seidel's own camera curves.
//!
//! Most callers need [`Config`] and [`Processor`] only. An engine behind the traits of [`engine`] evaluates the
//! transforms: by default a Rust port of OpenColorIO, with the feature `ocio-native` its C++ library. Three guarantees
//! hold for either engine:
//!
//! - Alpha is not converted.
//! - Samples that are not finite become zero, and are counted, before a transform mixes channels.
//! - Results do not depend on the number of threads.
//!
//! Without an engine the crate holds [`curves`] and [`tables`] only.
#![cfg_attr(
    any(feature = "ocio", feature = "ocio-native"),
    doc = r#"
```
use seidel_colour::{Alphas, Config, Source};

let config = Config::load(&Source::Embedded)?;
let to_linear = config.processor("ARRI LogC4", "ACEScg")?;
let mut planes = vec![vec![0.278]; 3];
let report = to_linear.convert_planes(&mut planes, Alphas::Straight)?;
assert_eq!(report.non_finite, 0);
assert!((planes[1][0] - 0.18).abs() < 1e-3);
# Ok::<(), seidel_colour::ColourError>(())
```
"#
)]
#![forbid(unsafe_code)]

pub mod curves;
pub mod engine;
mod error;
mod source;
pub mod tables;

#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod batch;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod config;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod conversion_report;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod limits;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod processor;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
mod suggestions;

#[cfg(any(feature = "ocio", feature = "ocio-native"))]
pub use config::Config;
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
pub use conversion_report::{ConversionReport, SamplePlace};
pub use engine::{Display, FileSpace, Space};
pub use error::{ColourError, Result};
#[cfg(any(feature = "ocio", feature = "ocio-native"))]
pub use processor::{Alphas, PixelLayout, Processor};
pub use source::{EMBEDDED_CONFIG, Source};
