//! The image effect suite, and properties of effects and of the arguments of actions: section "OfxImageEffectSuiteV1",
//! `ofxImageEffect.h`.

use std::ffi::{CStr, c_char, c_int, c_void};

use super::{Handle, OfxRectD, OfxStatus};

/// The image effect suite: effects, their clips, and images.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxImageEffectSuiteV1 {
    /// Gets the property set of an effect.
    pub property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Gets the parameter set of an effect.
    pub param_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Defines a clip by name and gets its property set.
    pub clip_define: Option<unsafe extern "C" fn(Handle, *const c_char, *mut Handle) -> OfxStatus>,
    /// Gets a clip of an instance and its property set.
    pub clip_handle:
        Option<unsafe extern "C" fn(Handle, *const c_char, *mut Handle, *mut Handle) -> OfxStatus>,
    /// Gets the property set of a clip.
    pub clip_property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Gets the image of a clip at a time; the region may be NULL.
    pub clip_image:
        Option<unsafe extern "C" fn(Handle, f64, *const OfxRectD, *mut Handle) -> OfxStatus>,
    /// Releases an image.
    pub release_image: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
    /// Gets the region of definition of a clip at a time, in canonical coordinates.
    pub clip_region_of_definition:
        Option<unsafe extern "C" fn(Handle, f64, *mut OfxRectD) -> OfxStatus>,
    /// Returns 1 if the host wants the effect to stop.
    pub abort: Option<unsafe extern "C" fn(Handle) -> c_int>,
    /// `imageMemoryAlloc`, `imageMemoryFree`, `imageMemoryLock`, `imageMemoryUnlock`: not used.
    pub memory: [*const c_void; 4],
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxImageEffectSuite";
/// The name of the image effect API.
pub const API: &CStr = c"OfxImageEffectPluginAPI";

/// The clip to filter.
pub const CLIP_SOURCE: &CStr = c"Source";
/// The clip to render.
pub const CLIP_OUTPUT: &CStr = c"Output";

/// Context: one input, besides masks.
pub const CONTEXT_FILTER: &CStr = c"OfxImageEffectContextFilter";
/// Context: any number of inputs.
pub const CONTEXT_GENERAL: &CStr = c"OfxImageEffectContextGeneral";

/// Contexts that the plugin supports.
pub const SUPPORTED_CONTEXTS: &CStr = c"OfxImageEffectPropSupportedContexts";
/// Sample types that the plugin supports.
pub const SUPPORTED_PIXEL_DEPTHS: &CStr = c"OfxImageEffectPropSupportedPixelDepths";
/// Menu that lists the plugin.
pub const GROUPING: &CStr = c"OfxImageEffectPluginPropGrouping";
/// Flag: clips may differ in sample type.
pub const MULTIPLE_CLIP_DEPTHS: &CStr = c"OfxImageEffectPropMultipleClipDepths";
/// Flag: clips may differ in pixel aspect ratio.
pub const MULTIPLE_CLIP_PARS: &CStr = c"OfxImageEffectPropSupportsMultipleClipPARs";
/// Flag: clips may differ in size.
pub const MULTI_RESOLUTION: &CStr = c"OfxImageEffectPropSupportsMultiResolution";
/// Flag: images may be tiles of a frame.
pub const TILES: &CStr = c"OfxImageEffectPropSupportsTiles";
/// Flag: images of other times are fetched.
pub const TEMPORAL_CLIP_ACCESS: &CStr = c"OfxImageEffectPropTemporalClipAccess";
/// Renders that may run at the same time.
pub const THREAD_SAFETY: &CStr = c"OfxImageEffectPluginRenderThreadSafety";
/// Thread safety: any renders, also of one instance.
pub const FULLY_SAFE: &CStr = c"OfxImageEffectRenderFullySafe";
/// Flag: the host may split a frame between threads.
pub const HOST_FRAME_THREADING: &CStr = c"OfxImageEffectPluginPropHostFrameThreading";
/// Flag: there can be only one instance.
pub const SINGLE_INSTANCE: &CStr = c"OfxImageEffectPluginPropSingleInstance";
/// Flag: both fields are rendered separately even if nothing changes between them.
pub const FIELD_RENDER_TWICE: &CStr = c"OfxImageEffectPluginPropFieldRenderTwiceAlways";
/// Flag: an output pixel depends on the input pixel at its own position only.
pub const NO_SPATIAL_AWARENESS: &CStr = c"OfxImageEffectPropNoSpatialAwareness";
/// Flag: the plugin renders on the CPU.
pub const CPU_RENDER: &CStr = c"OfxImageEffectPropCPURenderSupported";
/// Flag: the plugin renders by OpenGL.
pub const OPENGL_RENDER: &CStr = c"OfxImageEffectPropOpenGLRenderSupported";
/// Colour management style that the plugin supports. Since 1.5, `ofxColour.h`.
pub const COLOUR_STYLE: &CStr = c"OfxImageEffectPropColourManagementStyle";
/// Colour management style: names of basic colour spaces.
pub const COLOUR_BASIC: &CStr = c"OfxImageEffectColourManagementBasic";
/// OpenColorIO configs that the plugin knows.
pub const COLOUR_CONFIGS: &CStr = c"OfxImageEffectPropColourManagementAvailableConfigs";
/// Main entry point of the overlay interact that uses the draw suite.
pub const OVERLAY_V2: &CStr = c"OfxImageEffectPluginPropOverlayInteractV2";

/// Size of the project, in canonical coordinates.
pub const PROJECT_SIZE: &CStr = c"OfxImageEffectPropProjectSize";
/// Bottom left corner of the project, in canonical coordinates.
pub const PROJECT_OFFSET: &CStr = c"OfxImageEffectPropProjectOffset";

/// Argument: pixels per canonical unit, in x and y.
pub const RENDER_SCALE: &CStr = c"OfxImageEffectPropRenderScale";
/// Argument: the pixels to render.
pub const RENDER_WINDOW: &CStr = c"OfxImageEffectPropRenderWindow";
/// Argument: the field to render.
pub const FIELD_TO_RENDER: &CStr = c"OfxImageEffectPropFieldToRender";
/// Argument: whether draft quality is enough.
pub const QUALITY_DRAFT: &CStr = c"OfxImageEffectPropRenderQualityDraft";
/// Argument: whether the render is for a thumbnail.
pub const THUMBNAIL: &CStr = c"OfxImageEffectPropThumbnailRender";
/// Argument: the region of the output that is wanted, in canonical coordinates.
pub const REGION_OF_INTEREST: &CStr = c"OfxImageEffectPropRegionOfInterest";
/// Result: the region of definition of the output, in canonical coordinates.
pub const REGION_OF_DEFINITION: &CStr = c"OfxImageEffectPropRegionOfDefinition";
/// Result: whether frames differ although parameters and inputs do not.
pub const FRAME_VARYING: &CStr = c"OfxImageEffectFrameVarying";
/// Colour space of a clip. Since 1.5, `ofxColour.h`.
pub const COLOURSPACE: &CStr = c"OfxImageClipPropColourspace";
