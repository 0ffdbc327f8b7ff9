//! Names of actions.

use std::ffi::CStr;

/// First of all.
pub const LOAD: &CStr = c"OfxActionLoad";
/// Last of all.
pub const UNLOAD: &CStr = c"OfxActionUnload";
/// Say what the plugin is.
pub const DESCRIBE: &CStr = c"OfxActionDescribe";
/// Say what clips and parameters it has in a context.
pub const DESCRIBE_IN_CONTEXT: &CStr = c"OfxImageEffectActionDescribeInContext";
/// An instance was made.
pub const CREATE_INSTANCE: &CStr = c"OfxActionCreateInstance";
/// An instance goes.
pub const DESTROY_INSTANCE: &CStr = c"OfxActionDestroyInstance";
/// Something was changed.
pub const INSTANCE_CHANGED: &CStr = c"OfxActionInstanceChanged";
/// Let go of what can be had again.
pub const PURGE_CACHES: &CStr = c"OfxActionPurgeCaches";
/// What pictures are to be of.
pub const GET_CLIP_PREFERENCES: &CStr = c"OfxImageEffectActionGetClipPreferences";
/// How large the result is.
pub const GET_REGION_OF_DEFINITION: &CStr = c"OfxImageEffectActionGetRegionOfDefinition";
/// What is needed of inputs.
pub const GET_REGIONS_OF_INTEREST: &CStr = c"OfxImageEffectActionGetRegionsOfInterest";
/// Whether nothing is done.
pub const IS_IDENTITY: &CStr = c"OfxImageEffectActionIsIdentity";
/// Make a picture.
pub const RENDER: &CStr = c"OfxImageEffectActionRender";
/// Pictures will be asked for.
pub const BEGIN_SEQUENCE_RENDER: &CStr = c"OfxImageEffectActionBeginSequenceRender";
/// No more pictures.
pub const END_SEQUENCE_RENDER: &CStr = c"OfxImageEffectActionEndSequenceRender";
/// Which colour space the result is in.
pub const GET_OUTPUT_COLOURSPACE: &CStr = c"OfxImageEffectActionGetOutputColourspace";
