//! What kind of host is played: what it says of itself, what it lacks, and what it does otherwise than others.

use std::ffi::CStr;

use openfx::sys::generic::core::kOfxBitDepthFloat;
use openfx::sys::image_effect_v1::image_effect::*;

/// How rows of an image lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// One after the other.
    Tight,
    /// With samples between them that are nobody's.
    Padded,
    /// With an odd number of samples between them.
    Odd,
    /// From the top down: row bytes are negative.
    Negative,
    /// From the top down, with an odd number of samples between them.
    NegativeOdd,
    /// With bytes between them that are no whole number of samples.
    Unaligned,
}

impl Rows {
    /// Those that every plugin must take.
    pub const ALL: [Self; 5] = [
        Self::Tight,
        Self::Padded,
        Self::Odd,
        Self::Negative,
        Self::NegativeOdd,
    ];
}

/// A kind of host.
#[derive(Clone, Debug)]
pub struct Profile {
    /// What it is called here.
    pub name: &'static str,
    /// What it calls itself.
    pub host_name: &'static CStr,
    /// The version of the API it says it has.
    pub api: (i32, i32),
    /// Where its own coordinates begin.
    pub native_origin: &'static CStr,
    /// Whether descriptors begin with their default properties and take no others.
    pub describes: bool,
    /// Properties that it has not heard of, on any set.
    pub lacks: Vec<&'static CStr>,
    /// Suites that it does not serve, by name and version.
    pub absent: Vec<(&'static CStr, i32)>,
    /// Members of suites that are NULL, as `suite.member`.
    pub null_members: Vec<String>,
    /// Whether it asks for parts of pictures.
    pub tiles: bool,
    /// Whether inputs may be of different sizes.
    pub multi_resolution: bool,
    /// Whether inputs may be of different depths.
    pub multiple_depths: bool,
    /// Whether it shows overlays.
    pub overlays: bool,
    /// Contexts that it has.
    pub contexts: Vec<&'static CStr>,
    /// Components that it has.
    pub components: Vec<&'static CStr>,
    /// Whether every clip says that it is connected, and gives nothing where it is not.
    pub all_connected: bool,
    /// Whether clips have no region while regions of interest are asked for.
    pub late_regions: bool,
    /// Whether regions of clips and the project count pixels of the render while it goes on.
    pub pixel_regions: bool,
    /// Samples of images, whatever plugins say they take: where they are not floats, plugins can only refuse.
    pub samples: &'static CStr,
    /// Whether `clearPersistentMessage` points to nowhere.
    pub clear_is_garbage: bool,
    /// How rows lie if a frame does not say otherwise.
    pub rows: Rows,
    /// What images say of their render scale, as a factor on the true one.
    pub image_scale_factor: f64,
    /// Whether the plugin is unloaded after it has described itself, and loaded again.
    pub reloads: bool,
    /// Whether the optional actions before a render are called.
    pub asks: bool,
    /// Whether renders lie between begin and end of a sequence.
    pub sequences: bool,
    /// Processors that it says it has.
    pub processors: u32,
    /// Whether its threads are only one.
    pub serial: bool,
}

impl Profile {
    /// A host that has everything, of the newest version.
    #[must_use]
    pub fn complete() -> Self {
        Self {
            name: "complete",
            host_name: c"org.seidel.host",
            api: (1, 5),
            native_origin: kOfxHostNativeOriginBottomLeft,
            describes: true,
            lacks: Vec::new(),
            absent: Vec::new(),
            null_members: Vec::new(),
            tiles: true,
            multi_resolution: true,
            multiple_depths: true,
            overlays: true,
            contexts: vec![kOfxImageEffectContextFilter, kOfxImageEffectContextGeneral],
            components: vec![
                kOfxImageComponentRGBA,
                kOfxImageComponentRGB,
                kOfxImageComponentAlpha,
            ],
            all_connected: false,
            late_regions: false,
            pixel_regions: false,
            samples: kOfxBitDepthFloat,
            clear_is_garbage: false,
            rows: Rows::Padded,
            image_scale_factor: 1.0,
            reloads: false,
            asks: true,
            sequences: true,
            processors: 3,
            serial: false,
        }
    }

    /// The same with other rows.
    #[must_use]
    pub fn with_rows(self, rows: Rows) -> Self {
        Self { rows, ..self }
    }
}
