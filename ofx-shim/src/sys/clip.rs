//! Properties of clips and images: section "Images and Clips", `ofxImageEffect.h`.

use std::ffi::CStr;

/// Flag: the clip is connected.
pub const CONNECTED: &CStr = c"OfxImageClipPropConnected";
/// Flag: the clip may be unconnected.
pub const OPTIONAL: &CStr = c"OfxImageClipPropOptional";
/// Flag: the clip is a mask.
pub const IS_MASK: &CStr = c"OfxImageClipPropIsMask";
/// The rows that images of the clip contain: section "Field Rendering".
pub const FIELD_EXTRACTION: &CStr = c"OfxImageClipPropFieldExtraction";
/// Field: both, interleaved.
pub const FIELD_BOTH: &CStr = c"OfxFieldBoth";
/// Field: even rows, counted from the bottom.
pub const FIELD_LOWER: &CStr = c"OfxFieldLower";
/// Field: odd rows, counted from the bottom.
pub const FIELD_UPPER: &CStr = c"OfxFieldUpper";

/// Address of the bottom left pixel of the bounds.
pub const IMAGE_DATA: &CStr = c"OfxImagePropData";
/// Rectangle of the pixels in memory, in pixel coordinates.
pub const IMAGE_BOUNDS: &CStr = c"OfxImagePropBounds";
/// Bytes from a row to the row above it; negative where rows lie from the top down.
pub const IMAGE_ROW_BYTES: &CStr = c"OfxImagePropRowBytes";
/// Width of a pixel over its height.
pub const PIXEL_ASPECT: &CStr = c"OfxImagePropPixelAspectRatio";

/// Components of a clip or image.
pub const COMPONENTS: &CStr = c"OfxImageEffectPropComponents";
/// Components that a clip accepts.
pub const SUPPORTED_COMPONENTS: &CStr = c"OfxImageEffectPropSupportedComponents";
/// Components: one channel.
pub const ALPHA: &CStr = c"OfxImageComponentAlpha";
/// Components: red, green, blue.
pub const RGB: &CStr = c"OfxImageComponentRGB";
/// Components: red, green, blue, alpha.
pub const RGBA: &CStr = c"OfxImageComponentRGBA";

/// Sample type of a clip or image.
pub const PIXEL_DEPTH: &CStr = c"OfxImageEffectPropPixelDepth";
/// Sample type: 32-bit float.
pub const DEPTH_FLOAT: &CStr = c"OfxBitDepthFloat";
/// Sample type: 16-bit float.
pub const DEPTH_HALF: &CStr = c"OfxBitDepthHalf";

/// Premultiplication of a clip or image: section "Premultiplication And Alpha".
pub const PREMULTIPLICATION: &CStr = c"OfxImageEffectPropPreMultiplication";
/// Premultiplication: colour is not multiplied by alpha.
pub const UNPREMULTIPLIED: &CStr = c"OfxImageAlphaUnPremultiplied";
