//! The kind of host to imitate: its properties, what it lacks, and how it deviates from other hosts.

use std::ffi::CStr;

use openfx::sys::image_effect_v1::image_effect::*;

use super::properties::Schema;
use super::sample_type::SampleType;

/// The layout of image rows in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowLayout {
    /// Without gaps.
    Tight,
    /// With unused samples between rows.
    Padded,
    /// With row bytes that are an odd number of samples.
    Odd,
    /// From the top down, with negative row bytes.
    Negative,
    /// From the top down, with row bytes that are an odd number of samples.
    NegativeOdd,
    /// With row bytes that are not a multiple of the sample size.
    Unaligned,
}

impl RowLayout {
    /// Layouts with aligned samples, which every plugin must support.
    pub const ALIGNED: [Self; 5] = [
        Self::Tight,
        Self::Padded,
        Self::Odd,
        Self::Negative,
        Self::NegativeOdd,
    ];
}

/// A kind of host to imitate.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Its name on the command line and in reports.
    pub name: &'static str,
    /// Its name for plugins (`kOfxPropName`).
    pub host_name: &'static CStr,
    /// Major and minor version of the OpenFX API that it reports.
    pub api: (i32, i32),
    /// The origin of its native coordinates.
    pub native_origin: &'static CStr,
    /// Whether descriptors start with all properties of OpenFX and accept no others. Without, they start empty.
    pub has_default_properties: bool,
    /// Properties that no property set of it has.
    pub missing_properties: Vec<&'static CStr>,
    /// Suites that it does not provide, by name and version.
    pub missing_suites: Vec<(&'static CStr, i32)>,
    /// Suite functions that are NULL, as `suite.function`.
    pub null_functions: Vec<String>,
    /// Whether it renders tiles.
    pub supports_tiles: bool,
    /// Whether inputs may differ in size.
    pub supports_multi_resolution: bool,
    /// Whether clips may differ in bit depth.
    pub supports_multiple_depths: bool,
    /// Whether it shows overlays.
    pub supports_overlays: bool,
    /// Contexts that it supports.
    pub contexts: Vec<&'static CStr>,
    /// Pixel components that it supports.
    pub components: Vec<&'static CStr>,
    /// Whether clips report that they are connected when they are not; their images then have no data.
    pub all_connected: bool,
    /// Whether the region of definition of clips is unavailable during GetRegionsOfInterest.
    pub late_regions: bool,
    /// Whether regions of clips and the project are in pixels of the render scale during a render.
    pub pixel_regions: bool,
    /// Sample type of all images; `None` for the first of [`SampleType::ALL`] that the plugin supports.
    pub samples: Option<SampleType>,
    /// Bit depth that images report in place of their own, whatever plugins support.
    pub false_bit_depth: Option<&'static CStr>,
    /// Whether calls of `clearPersistentMessage` are misuse, because the function pointer is invalid in such hosts.
    pub invalid_clear_message: bool,
    /// Whether arguments of messages print nothing, because it passes a `va_list` on as an argument.
    pub blank_message_arguments: bool,
    /// Whether a group that no page lists goes to the end of the panel.
    pub appends_unlisted_groups: bool,
    /// Whether Output has the most channels of any input, where the plugin does not say what it has.
    pub widest_output: bool,
    /// Whether a saved project has absolute paths in all parameters of files.
    pub absolute_paths: bool,
    /// Whether a clip has no components and no images while the plugin is notified of its connection.
    pub late_components: bool,
    /// The row layout of images, unless a request sets another.
    pub rows: RowLayout,
    /// Factor of the render scale that images report; 0 leaves the property out.
    pub image_scale_factor: f64,
    /// Whether it unloads the plugin after Describe and loads it again.
    pub reloads: bool,
    /// Whether it calls the optional actions before a render: GetClipPreferences, GetRegionOfDefinition,
    /// GetFramesNeeded, IsIdentity and GetRegionsOfInterest.
    pub calls_optional_actions: bool,
    /// Whether it calls BeginSequenceRender and EndSequenceRender.
    pub calls_sequence_actions: bool,
    /// Number of processors that it reports.
    pub processors: u32,
    /// Whether its multi-thread suite runs everything on the calling thread.
    pub serial_threads: bool,
}

impl Profile {
    /// Returns a host that supports everything in OpenFX 1.5.
    #[must_use]
    pub fn complete() -> Self {
        Self {
            name: "complete",
            host_name: c"org.seidel.host",
            api: (1, 5),
            native_origin: kOfxHostNativeOriginBottomLeft,
            has_default_properties: true,
            missing_properties: Vec::new(),
            missing_suites: Vec::new(),
            null_functions: Vec::new(),
            supports_tiles: true,
            supports_multi_resolution: true,
            supports_multiple_depths: true,
            supports_overlays: true,
            contexts: vec![kOfxImageEffectContextFilter, kOfxImageEffectContextGeneral],
            components: vec![
                kOfxImageComponentRGBA,
                kOfxImageComponentRGB,
                kOfxImageComponentAlpha,
            ],
            all_connected: false,
            late_regions: false,
            pixel_regions: false,
            samples: None,
            false_bit_depth: None,
            invalid_clear_message: false,
            blank_message_arguments: false,
            appends_unlisted_groups: false,
            widest_output: false,
            absolute_paths: false,
            late_components: false,
            rows: RowLayout::Padded,
            image_scale_factor: 1.0,
            reloads: false,
            calls_optional_actions: true,
            calls_sequence_actions: true,
            processors: 3,
            serial_threads: false,
        }
    }

    /// Returns whether plugins may add properties to its descriptors.
    pub(crate) fn descriptor_schema(&self) -> Schema {
        if self.has_default_properties {
            Schema::Fixed
        } else {
            Schema::Open
        }
    }
}
