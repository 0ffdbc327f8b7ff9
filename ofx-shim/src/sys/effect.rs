//! The image effect suite, and names of properties of effects and of the arguments of actions.

use std::ffi::{CStr, c_char, c_int, c_void};

use super::{Handle, OfxRectD, OfxStatus};

/// Effects, their clips and pictures. The memory functions are not used.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxImageEffectSuiteV1 {
    /// Properties of an effect.
    pub property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Its parameters.
    pub param_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Declares a clip; gives its properties.
    pub clip_define: Option<unsafe extern "C" fn(Handle, *const c_char, *mut Handle) -> OfxStatus>,
    /// A clip of an instance, and its properties.
    pub clip_handle:
        Option<unsafe extern "C" fn(Handle, *const c_char, *mut Handle, *mut Handle) -> OfxStatus>,
    /// Properties of a clip.
    pub clip_property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// A picture of a clip at a time.
    pub clip_image:
        Option<unsafe extern "C" fn(Handle, f64, *const OfxRectD, *mut Handle) -> OfxStatus>,
    /// Gives it back.
    pub release_image: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
    /// How large the pictures of a clip are.
    pub clip_region_of_definition:
        Option<unsafe extern "C" fn(Handle, f64, *mut OfxRectD) -> OfxStatus>,
    /// Whether to stop.
    pub abort: Option<unsafe extern "C" fn(Handle) -> c_int>,
    /// Not used: to get, free, lock and unlock memory.
    pub memory: [*const c_void; 4],
}

/// Name of the suite.
pub const SUITE: &CStr = c"OfxImageEffectSuite";
/// Which API it is of.
pub const API: &CStr = c"OfxImageEffectPluginAPI";

/// The clip that is worked on.
pub const CLIP_SOURCE: &CStr = c"Source";
/// The clip that is made.
pub const CLIP_OUTPUT: &CStr = c"Output";

/// In which way a plugin is used.
pub const CONTEXT: &CStr = c"OfxImageEffectPropContext";
/// One input.
pub const CONTEXT_FILTER: &CStr = c"OfxImageEffectContextFilter";
/// Any number of inputs.
pub const CONTEXT_GENERAL: &CStr = c"OfxImageEffectContextGeneral";

/// In which ways it can be.
pub const SUPPORTED_CONTEXTS: &CStr = c"OfxImageEffectPropSupportedContexts";
/// Which samples it can work on.
pub const SUPPORTED_PIXEL_DEPTHS: &CStr = c"OfxImageEffectPropSupportedPixelDepths";
/// Where it stands in menus.
pub const GROUPING: &CStr = c"OfxImageEffectPluginPropGrouping";
/// Whether clips may have different samples.
pub const MULTIPLE_CLIP_DEPTHS: &CStr = c"OfxImageEffectPropMultipleClipDepths";
/// Whether clips may have different pixel aspects.
pub const MULTIPLE_CLIP_PARS: &CStr = c"OfxImageEffectPropSupportsMultipleClipPARs";
/// Whether clips may have different sizes.
pub const MULTI_RESOLUTION: &CStr = c"OfxImageEffectPropSupportsMultiResolution";
/// Whether parts of pictures can be asked for.
pub const TILES: &CStr = c"OfxImageEffectPropSupportsTiles";
/// Whether pictures of other times are used.
pub const TEMPORAL_CLIP_ACCESS: &CStr = c"OfxImageEffectPropTemporalClipAccess";
/// What renders may go on at once.
pub const THREAD_SAFETY: &CStr = c"OfxImageEffectPluginRenderThreadSafety";
/// Any.
pub const FULLY_SAFE: &CStr = c"OfxImageEffectRenderFullySafe";
/// Whether the host may split a picture among threads.
pub const HOST_FRAME_THREADING: &CStr = c"OfxImageEffectPluginPropHostFrameThreading";
/// Whether there may be only one instance.
pub const SINGLE_INSTANCE: &CStr = c"OfxImageEffectPluginPropSingleInstance";
/// Whether each field is rendered by itself even where nothing changes.
pub const FIELD_RENDER_TWICE: &CStr = c"OfxImageEffectPluginPropFieldRenderTwiceAlways";
/// Whether a pixel depends on its own place alone.
pub const NO_SPATIAL_AWARENESS: &CStr = c"OfxImageEffectPropNoSpatialAwareness";
/// Whether it works without a GPU.
pub const CPU_RENDER: &CStr = c"OfxImageEffectPropCPURenderSupported";
/// Whether it works on one by OpenGL.
pub const OPENGL_RENDER: &CStr = c"OfxImageEffectPropOpenGLRenderSupported";
/// Parameters on which clip preferences depend.
pub const CLIP_PREFERENCES_PARAM: &CStr = c"OfxImageEffectPropClipPreferencesSlaveParam";
/// Which kind of colour management is understood.
pub const COLOUR_STYLE: &CStr = c"OfxImageEffectPropColourManagementStyle";
/// The simplest kind.
pub const COLOUR_BASIC: &CStr = c"OfxImageEffectColourManagementBasic";
/// Which configurations are known.
pub const COLOUR_CONFIGS: &CStr = c"OfxImageEffectPropColourManagementAvailableConfigs";
/// Entry of the overlay, drawn by the draw suite.
pub const OVERLAY_V2: &CStr = c"OfxImageEffectPluginPropOverlayInteractV2";
/// Whether the host has overlays.
pub const SUPPORTS_OVERLAYS: &CStr = c"OfxImageEffectPropSupportsOverlays";

/// Size of the project, canonical.
pub const PROJECT_SIZE: &CStr = c"OfxImageEffectPropProjectSize";
/// Where it begins.
pub const PROJECT_OFFSET: &CStr = c"OfxImageEffectPropProjectOffset";

/// Scale of a render.
pub const RENDER_SCALE: &CStr = c"OfxImageEffectPropRenderScale";
/// Which pixels to render.
pub const RENDER_WINDOW: &CStr = c"OfxImageEffectPropRenderWindow";
/// Which field to render.
pub const FIELD_TO_RENDER: &CStr = c"OfxImageEffectPropFieldToRender";
/// Whether a draft will do.
pub const QUALITY_DRAFT: &CStr = c"OfxImageEffectPropRenderQualityDraft";
/// Whether it is for a thumbnail.
pub const THUMBNAIL: &CStr = c"OfxImageEffectPropThumbnailRender";
/// What is wanted of the result, canonical.
pub const REGION_OF_INTEREST: &CStr = c"OfxImageEffectPropRegionOfInterest";
/// How large the result is, canonical.
pub const REGION_OF_DEFINITION: &CStr = c"OfxImageEffectPropRegionOfDefinition";
/// Whether frames change where nothing else does.
pub const FRAME_VARYING: &CStr = c"OfxImageEffectFrameVarying";
/// Colour space of a clip.
pub const COLOURSPACE: &CStr = c"OfxImageClipPropColourspace";
