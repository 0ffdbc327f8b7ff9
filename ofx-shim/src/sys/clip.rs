//! Names of properties of clips and pictures.

use std::ffi::CStr;

/// Whether something is connected.
pub const CONNECTED: &CStr = c"OfxImageClipPropConnected";
/// Whether it may stay unconnected.
pub const OPTIONAL: &CStr = c"OfxImageClipPropOptional";
/// Whether it is a mask.
pub const IS_MASK: &CStr = c"OfxImageClipPropIsMask";
/// Which field samples belong to.
pub const FIELD_EXTRACTION: &CStr = c"OfxImageClipPropFieldExtraction";
/// A field alone, as a picture of half the height.
pub const FIELD_SINGLE: &CStr = c"OfxFieldSingle";
/// A field, each of its rows twice.
pub const FIELD_DOUBLED: &CStr = c"OfxFieldDoubled";
/// No fields.
pub const FIELD_NONE: &CStr = c"OfxFieldNone";
/// Both fields.
pub const FIELD_BOTH: &CStr = c"OfxFieldBoth";
/// Even rows, counted from the bottom.
pub const FIELD_LOWER: &CStr = c"OfxFieldLower";
/// Odd rows.
pub const FIELD_UPPER: &CStr = c"OfxFieldUpper";
/// Colour spaces that are wished for, best first.
pub const PREFERRED_COLOURSPACES: &CStr = c"OfxImageClipPropPreferredColourspaces";

/// First sample of the pixel at the bottom left.
pub const IMAGE_DATA: &CStr = c"OfxImagePropData";
/// Rectangle of its pixels.
pub const IMAGE_BOUNDS: &CStr = c"OfxImagePropBounds";
/// Bytes between rows, upwards.
pub const IMAGE_ROW_BYTES: &CStr = c"OfxImagePropRowBytes";
/// Width of a pixel over its height.
pub const PIXEL_ASPECT: &CStr = c"OfxImagePropPixelAspectRatio";

/// Which channels a picture has.
pub const COMPONENTS: &CStr = c"OfxImageEffectPropComponents";
/// Which it may have.
pub const SUPPORTED_COMPONENTS: &CStr = c"OfxImageEffectPropSupportedComponents";
/// One channel.
pub const ALPHA: &CStr = c"OfxImageComponentAlpha";
/// Three.
pub const RGB: &CStr = c"OfxImageComponentRGB";
/// Four.
pub const RGBA: &CStr = c"OfxImageComponentRGBA";

/// What samples are.
pub const PIXEL_DEPTH: &CStr = c"OfxImageEffectPropPixelDepth";
/// Single precision.
pub const DEPTH_FLOAT: &CStr = c"OfxBitDepthFloat";
/// Half precision.
pub const DEPTH_HALF: &CStr = c"OfxBitDepthHalf";

/// Whether colour is multiplied by alpha.
pub const PREMULTIPLICATION: &CStr = c"OfxImageEffectPropPreMultiplication";
/// There is no alpha that counts.
pub const OPAQUE: &CStr = c"OfxImageOpaque";
/// It is.
pub const PREMULTIPLIED: &CStr = c"OfxImageAlphaPremultiplied";
/// It is not.
pub const UNPREMULTIPLIED: &CStr = c"OfxImageAlphaUnPremultiplied";
