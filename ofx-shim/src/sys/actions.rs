//! Actions: section "Actions Passed to an Image Effect", `ofxCore.h` and `ofxImageEffect.h`.

use std::ffi::CStr;

/// The first action, once the suites can be fetched.
pub const LOAD: &CStr = c"OfxActionLoad";
/// The last action.
pub const UNLOAD: &CStr = c"OfxActionUnload";
/// Asks for the properties of the plugin's descriptor.
pub const DESCRIBE: &CStr = c"OfxActionDescribe";
/// Asks for the clips and parameters in a context.
pub const DESCRIBE_IN_CONTEXT: &CStr = c"OfxImageEffectActionDescribeInContext";
/// An instance was created.
pub const CREATE_INSTANCE: &CStr = c"OfxActionCreateInstance";
/// An instance is about to be destroyed.
pub const DESTROY_INSTANCE: &CStr = c"OfxActionDestroyInstance";
/// A parameter, a clip or the time changed.
pub const INSTANCE_CHANGED: &CStr = c"OfxActionInstanceChanged";
/// Asks to free cached memory.
pub const PURGE_CACHES: &CStr = c"OfxActionPurgeCaches";
/// Asks for the components, depth, premultiplication and colour space of clips.
pub const GET_CLIP_PREFERENCES: &CStr = c"OfxImageEffectActionGetClipPreferences";
/// Asks for the region of definition of the output.
pub const GET_REGION_OF_DEFINITION: &CStr = c"OfxImageEffectActionGetRegionOfDefinition";
/// Asks for the region of each input that a render needs.
pub const GET_REGIONS_OF_INTEREST: &CStr = c"OfxImageEffectActionGetRegionsOfInterest";
/// Asks whether the output equals an input.
pub const IS_IDENTITY: &CStr = c"OfxImageEffectActionIsIdentity";
/// Renders an image.
pub const RENDER: &CStr = c"OfxImageEffectActionRender";
/// Precedes the renders of a sequence.
pub const BEGIN_SEQUENCE_RENDER: &CStr = c"OfxImageEffectActionBeginSequenceRender";
/// Follows the renders of a sequence.
pub const END_SEQUENCE_RENDER: &CStr = c"OfxImageEffectActionEndSequenceRender";
/// Asks for the colour space of the output. Since 1.5, `ofxColour.h`.
pub const GET_OUTPUT_COLOURSPACE: &CStr = c"OfxImageEffectActionGetOutputColourspace";
