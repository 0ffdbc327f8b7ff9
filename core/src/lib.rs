//! Real lens blur: a lens learned from measured point-spread functions (PSFs), its blur applied to a plate, removed from
//! it, and diagnosed.
//!
//! # The model in one screen
//! A real lens blurs each point differently: by its position in the field, its colour channel and its distance.
//! Third-order (Seidel) aberrations of a thick lens give the central moments of the PSF as polynomials of image position
//! with ten coefficients S1..S10 per channel and distance (Simpkins and Stevenson 2014). [`fit()`] estimates such a lens
//! from PSF tiles, either from their moments or ray by ray with further effects; [`Lens`] predicts the PSF anywhere;
//! [`apply()`] scatters each source pixel x' of a plate I with its own PSF,
//!
//! > O(x) = sum over x' of I(x') P_x'(x - x'),
//!
//! guided by a depth pass, near surfaces occluding far ones. [`remove()`] solves for the I of a given O, [`relens()`]
//! replaces one lens by another, and [`diagnose()`] names the effects that a lens lacks against measured PSFs.
//!
//! ```
//! # fn main() -> seidel_core::Result<()> {
//! # let profile = include_str!("../tests/data/lens.json");
//! # let (width, height, samples, metres) = (60, 40, [0.5; 60 * 40 * 4], vec![2.0; 60 * 40]);
//! use seidel_core::{Depth, DepthPass, Image, Lens, Plate, Settings, apply, no_progress};
//!
//! let lens = Lens::from_json(profile)?;
//! let image = Image::from_interleaved(width, height, 4, &samples)?;
//! let plate = Plate::new(image).with_depth(Depth::Pass(DepthPass::metres(metres)));
//! let blurred = apply(&lens, &plate, &Settings::default(), &no_progress)?;
//! assert_eq!((blurred.width(), blurred.height()), (width, height));
//! # Ok(())
//! # }
//! ```
//!
//! An [`Image`] holds scene-linear `f32` samples: a plane of each colour in `colours`, coverage in `alpha`. The result has the size of the plate.
//! Lens channels are found by their names. `no_progress` stands for a callback that shows progress and can end the work.
//!
//! The crate is used from a checkout of Seidel, in the `Cargo.toml` of another program:
//!
//! ```toml
//! [dependencies]
//! seidel-core = { path = "../seidel/core" }
//! ```
//!
//! # Blur an image, and remove the blur
//! Without a profile of one's own, a [`LibraryLens`] will do. A picture whose width over height is that of the lens's frame
//! is scaled to it; [`Settings`] has focus, f-number, amount and quality. [`relens()`] replaces one lens by another.
//!
//! ```
//! # fn main() -> seidel_core::Result<()> {
//! use seidel_core::{
//!     Depth, Image, Lens, LibraryLens, ObjectDistance, Plate, Settings, apply, no_progress, remove,
//! };
//!
//! let lens = Lens::new(LibraryLens::by_name("modern-50")?.profile()?)?;
//! let (width, height) = (96, 54);
//! let checks = (0..width * height).flat_map(|i| [0.2 + 0.6 * ((i % width / 8 + i / width / 8) % 2) as f32; 3]);
//! let image = Image::from_interleaved(width, height, 3, &checks.collect::<Vec<f32>>())?;
//! let depth = Depth::Distance(ObjectDistance::metres(1.5)?); // the lens is focused on 3 m
//! let sharp = Plate::new(image).with_depth(depth.clone());
//!
//! let blurred = apply(&lens, &sharp, &Settings::default(), &no_progress)?;
//! let blurred = Plate::new(blurred).with_depth(depth);
//! let restored = remove(&lens, &blurred, &Settings::default(), &no_progress)?;
//! let error = |image: &Image| -> f32 {
//!     let pairs = image.colours[1].iter().zip(&sharp.image.colours[1]);
//!     pairs.map(|(a, b)| (a - b).powi(2)).sum()
//! };
//! assert!(error(&restored) < 0.1 * error(&blurred.image));
//! # Ok(())
//! # }
//! ```
//!
//! # From PSFs to a lens
//! An [`ObservationSet`] holds the PSFs of one camera: a [`Tile`] a channel for each [`Observation`], at known
//! positions of the [`Frame`]. They are photographed
//! points of light, or kernels of an optical design. [`Model::Moments`] is fitted in moments. The other models take seconds
//! to minutes, follow the light ray by ray, and are needed by [`diagnose()`] and by new focus distances and apertures.
//!
//! ```
//! # fn main() -> seidel_core::Result<()> {
//! use seidel_core::{
//!     FitSettings, Frame, ImagePoint, Lens, Model, ObjectDistance, Observation, ObservationSet, Tile, fit, no_progress,
//! };
//!
//! // Gaussian PSFs at 9 x 5 positions, wider towards the corners.
//! let frame = Frame::new(640, 360, None)?;
//! let mut observations = Vec::new();
//! for k in 0..45 {
//!     let centre = ImagePoint::new(32.0 + 72.0 * f64::from(k % 9), 36.0 + 72.0 * f64::from(k / 9));
//!     let variance = 2.0 + frame.field_point(centre).radius().powi(2);
//!     let light = (0..21 * 21).map(|i| {
//!         let (x, y) = (f64::from(i % 21 - 10), f64::from(i / 21 - 10));
//!         (-(x * x + y * y) / (2.0 * variance)).exp() as f32
//!     });
//!     let tile = Tile::new(21, 21, light.collect())?;
//!     let distance = ObjectDistance::metres(3.0)?;
//!     observations.push(Observation::new(format!("PSF {k}"), centre, distance, vec![tile]));
//! }
//! let set = ObservationSet::new(frame, vec!["Y".to_string()], observations);
//! assert!(set.faults().is_empty());
//!
//! let settings = FitSettings { model: Model::Moments, ..FitSettings::default() };
//! let lens = Lens::new(fit(&[set], &settings, &no_progress)?.into_lens())?;
//! let centre = lens.blur_at("Y", ImagePoint::new(320.0, 180.0), ObjectDistance::metres(3.0)?)?;
//! assert!((centre.moments.mu20 - 2.0).abs() < 0.2); // px², less the area of a pixel
//! # Ok(())
//! # }
//! ```
//!
//! # Diagnose a gap
//! A lens that was measured months ago may have changed. [`diagnose()`] compares it with new PSFs, tries one cause after the
//! other, and returns those that explain the gap, each with its probability and size, and a lens with them added.
//!
//! ```
//! # fn main() -> seidel_core::Result<()> {
//! use seidel_core::{
//!     Controls, DiagnosisSettings, ImagePoint, Lens, LibraryLens, ObjectDistance, Observation, ObservationSet,
//!     diagnose, no_progress,
//! };
//!
//! // New PSFs at 6 x 4 positions; here those of the lens with its sensor shifted by 30 µm.
//! let lens = Lens::new(LibraryLens::by_name("modern-50")?.profile()?)?;
//! let shift = Controls { sensor_shift_um: Some(30.0), ..Controls::default() };
//! let moved = lens.with_controls(&shift)?;
//! let (frame, channels) = (lens.profile().frame, lens.predictor().channel_names());
//! let mut set = ObservationSet::new(frame, channels.to_vec(), Vec::new());
//! for k in 0..24 {
//!     let x = f64::from(frame.width_px()) * (f64::from(k % 6) + 0.5) / 6.0;
//!     let y = f64::from(frame.height_px()) * (f64::from(k / 6) + 0.5) / 4.0;
//!     let (centre, distance) = (ImagePoint::new(x, y), ObjectDistance::metres(3.0)?);
//!     let tiles = moved.psf_at(centre, distance, 33, None)?; // one of each channel
//!     set.observations.push(Observation::new(format!("PSF {k}"), centre, distance, tiles));
//! }
//!
//! let diagnosis = diagnose(&lens, &set, &DiagnosisSettings::default(), &no_progress)?;
//! assert!(!diagnosis.added.is_empty(), "{:?}", diagnosis.verdict);
//! assert!(diagnosis.gap.after < 0.1 * diagnosis.gap.before);
//! # Ok(())
//! # }
//! ```
//!
//! # Files
//! The crate opens no file. [`Lens::from_json`] and [`Lens::to_json`] take and return the text of the files that `seidel fit`
//! writes. The crate `seidel-image-io`, in `cli/image-io`, reads observation sets, and plates of every format of the command.
//! `core/examples` has complete programs: `blur_image`, `fit_lens`, `diagnose_gap`.
//!
//! # Frames and units
//! Samples are scene-linear, in separate row-major planes. Frame pixels have x right, y down and (0, 0) at the outer corner
//! of the top-left pixel. Distances are metres along the optical axis from the entrance pupil, vergence is 1 / distance.
//!
//! # Packages
//! The crate stands on packages that can be used by themselves: `seidel-optics` (lens model, effects, PSF models, profiles),
//! `seidel-render` (renderers, occlusion, deconvolution), `seidel-calibrate` (fit, evaluation, diagnosis). `seidel-measure`
//! measures PSFs in photographs.
#![forbid(unsafe_code)]

mod apply;
mod blur_map;
mod channel_weights;
mod coc_scale;
mod coverage;
mod depth_findings;
mod diagnose;
mod expansion;
mod fingerprint;
mod finite;
mod image;
mod knobs;
mod lens;
mod light_scale;
mod margins;
mod match_colours;
mod memory;
mod picture_diagnosis;
mod placement;
mod plane_removal;
mod planes;
mod plate;
mod plate_gap;
mod prepared;
mod prepared_background;
mod prepared_depth;
mod prepared_mask;
mod relens;
mod remove;
mod removed;
mod rendering;
mod result_store;
mod session;
mod settings;
mod undershoot;

pub use apply::apply;
pub use coc_scale::{COC_SCALE, CocColours, CocStop};
pub use diagnose::diagnose;
pub use image::{AlphaKind, Image};
pub use knobs::{
    Choice, ChoiceOption, HostGroup, HostKnob, Knob, KnobKind, KnobScope, KnobUse, LookPreset,
    Mode, Number, Relation, Switch, Unit,
};
pub use lens::Lens;
pub use margins::Margins;
pub use match_colours::match_colours;
pub use memory::{apply_bytes, layered_apply_bytes, remove_bytes};
pub use picture_diagnosis::{PictureDiagnosis, PicturePair, diagnose_pictures};
pub use placement::{LensFrame, PlatePlacement};
pub use plane_removal::NoiseGain;
pub use plate::{
    Background, Depth, DepthMeaning, DepthPass, HoldoutMatte, LensScale, Plate, PlateGeometry,
};
pub use plate_gap::{ChannelPlateGap, PLATE_GAP_BLOCK_PX, PlateGap, picture_gap, plate_gap};
pub use prepared::PreparedPlate;
pub use prepared_background::PreparedBackground;
pub use prepared_depth::{PreparedDepth, PreparedHoldout};
pub use relens::relens;
pub use remove::remove;
pub use removed::RemovedPlate;
pub use rendering::Rendering;
pub use result_store::ResultStore;
pub use seidel_calibrate::diagnose::{Diagnosis, DiagnosisSettings, Verdict};
pub use seidel_calibrate::eval::{EvalSettings, Evaluation, evaluate};
pub use seidel_calibrate::fit::{AxisChoice, Fit, FitSettings, Model, fit};
pub use seidel_optics::camera::Camera;
pub use seidel_optics::distance::ObjectDistance;
pub use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
pub use seidel_optics::lens::AperturePicture;
pub use seidel_optics::library::LibraryLens;
pub use seidel_optics::moments::CentralMoments;
pub use seidel_optics::mosaic::Mosaic;
pub use seidel_optics::observations::{Measurement, Observation, ObservationSet};
pub use seidel_optics::predict::Predictor;
pub use seidel_optics::profile::{Blades, Controls, LensProfile, Look, LookRange};
pub use seidel_optics::psf::LocalBlur;
pub use seidel_optics::tile::Tile;
pub use seidel_optics::{
    BlurField, Error, ErrorKind, Fault, Progress, Rectangle, Result, no_progress,
};
pub use seidel_render::remove::{Canvas, KeptBlurReason, Saturation, SharpPlane};
pub use seidel_render::{
    Bloom, BlurMap, DepthConvention, DepthFinding, DepthPlace, DepthProblem, DepthReading,
    DepthSlice, Displacement, FocusControls, FocusSide, LocalKernel, RenderWindow, Severity,
};
pub use session::LensSession;
pub use settings::{
    ChannelScale, Edges, Expand, Grain, MaskScales, OcclusionSettings, Quality, RelensSide,
    RemovalSettings, Settings,
};

/// The parts of a [`Diagnosis`], and pairs of pictures that it is made from.
pub mod diagnosis {
    pub use seidel_calibrate::diagnose::{
        Bookkeeping, Capture, Cause, Example, Gap, ModelShare, Order, OwnGapSource, Pair,
        PairEstimate, PairGeometry, PairImage, PairSettings, Place, PlacedPictures, Quantisation,
        Shape, Shares, StoredCurve, TileGap, TileResponse, Zone,
    };
}

/// The parts of an [`Evaluation`].
pub mod evaluation {
    pub use seidel_calibrate::eval::{
        GroupEvaluation, ShapePrediction, ShapeRow, SparseSettings, SplitMean,
    };
}

/// The parts of a [`Fit`].
pub mod fitting {
    pub use seidel_calibrate::fit::{
        MomentsFit, PartTrial, PupilFit, PupilModel, PupilSettings, Weighting,
    };
}

/// The parts of a [`LensProfile`].
pub mod profile {
    pub use seidel_optics::profile::{
        Adequacy, HeldOut, LensDescription, MomentsChannel, MomentsPlane, ProfileEffect,
        Provenance, PupilChannel, Verdict,
    };
}

/// The Rust code of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
