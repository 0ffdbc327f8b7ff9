//! The OpenFX properties that a plugin may use, with their types. A name that is not listed here is misspelt.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::OnceLock;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::colour::*;
use openfx::sys::image_effect_v1::draw_suite::*;
use openfx::sys::image_effect_v1::gpu_render::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::interact::*;
use openfx::sys::image_effect_v1::key_syms::*;
use openfx::sys::image_effect_v1::param::*;
use openfx::sys::image_effect_v1::parametric_param::*;

/// The type of the values of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PropertyType {
    Int,
    Double,
    Text,
    Pointer,
    /// The type of the parameter, as of its default and range.
    Parameter,
}

/// Returns the type of a property, or nothing if OpenFX has no property of that name.
pub(crate) fn type_of(name: &str) -> Option<PropertyType> {
    static ALL: OnceLock<BTreeMap<String, PropertyType>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let typed = |names: &'static [&'static CStr], kind: PropertyType| {
            (names.iter()).map(move |name| (name.to_string_lossy().into_owned(), kind))
        };
        typed(INTS, PropertyType::Int)
            .chain(typed(DOUBLES, PropertyType::Double))
            .chain(typed(TEXTS, PropertyType::Text))
            .chain(typed(POINTERS, PropertyType::Pointer))
            .chain(typed(PARAMETER_TYPED, PropertyType::Parameter))
            .collect()
    });
    all.get(name).copied().or_else(|| {
        CLIP_PREFIXES
            .iter()
            .find(|(prefix, _)| name.len() > prefix.len() && name.starts_with(prefix))
            .map(|(_, kind)| *kind)
    })
}

/// Prefixes of action properties that end with the name of a clip.
const CLIP_PREFIXES: [(&str, PropertyType); 6] = [
    ("OfxImageClipPropComponents_", PropertyType::Text),
    ("OfxImageClipPropDepth_", PropertyType::Text),
    ("OfxImageClipPropPreferredColourspaces_", PropertyType::Text),
    ("OfxImageClipPropPAR_", PropertyType::Double),
    ("OfxImageClipPropRoI_", PropertyType::Double),
    ("OfxImageClipPropFrameRange_", PropertyType::Double),
];

const INTS: &[&CStr] = &[
    kOfxPropAPIVersion,
    kOfxPropIsInteractive,
    kOfxPropVersion,
    kOfxPropParamSetNeedsSyncing,
    kOfxImageEffectHostPropIsBackground,
    kOfxImageEffectPluginPropSingleInstance,
    kOfxImageEffectPluginPropHostFrameThreading,
    kOfxImageEffectPluginPropFieldRenderTwiceAlways,
    kOfxImageEffectPluginPropObsolete,
    kOfxImageEffectPropSupportsMultipleClipDepths,
    kOfxImageEffectPropSupportsMultipleClipPARs,
    kOfxImageEffectPropSetableFrameRate,
    kOfxImageEffectPropSetableFielding,
    kOfxImageEffectInstancePropSequentialRender,
    kOfxImageEffectPropSequentialRenderStatus,
    kOfxImageEffectPropInteractiveRenderStatus,
    kOfxImageEffectPropRenderQualityDraft,
    kOfxImageEffectPropSupportsOverlays,
    kOfxImageEffectPropSupportsMultiResolution,
    kOfxImageEffectPropSupportsTiles,
    kOfxImageEffectPropTemporalClipAccess,
    kOfxImageEffectFrameVarying,
    kOfxImageClipPropContinuousSamples,
    kOfxImageClipPropOptional,
    kOfxImageClipPropIsMask,
    kOfxImageClipPropConnected,
    kOfxImagePropBounds,
    kOfxImagePropRegionOfDefinition,
    kOfxImagePropRowBytes,
    kOfxImageEffectPropRenderWindow,
    kOfxParamHostPropSupportsCustomAnimation,
    kOfxParamHostPropSupportsStringAnimation,
    kOfxParamHostPropSupportsBooleanAnimation,
    kOfxParamHostPropSupportsChoiceAnimation,
    kOfxParamHostPropSupportsCustomInteract,
    kOfxParamHostPropSupportsParametricAnimation,
    kOfxParamHostPropSupportsStrChoiceAnimation,
    kOfxParamHostPropSupportsStrChoice,
    kOfxParamHostPropMaxParameters,
    kOfxParamHostPropMaxPages,
    kOfxParamHostPropPageRowColumnCount,
    kOfxParamPropAnimates,
    kOfxParamPropCanUndo,
    kOfxParamPropIsAnimating,
    kOfxParamPropPluginMayWrite,
    kOfxParamPropPersistant,
    kOfxParamPropEvaluateOnChange,
    kOfxParamPropSecret,
    kOfxParamPropEnabled,
    kOfxParamPropIsAutoKeying,
    kOfxParamPropDigits,
    kOfxParamPropGroupOpen,
    kOfxParamPropChoiceOrder,
    kOfxParamPropStringFilePathExists,
    kOfxParamPropShowTimeMarker,
    kOfxParamPropHasHostOverlayHandle,
    kOfxParamPropUseHostOverlayHandle,
    kOfxParamPropInteractPreferedSize,
    kOfxInteractPropPenViewportPosition,
    kOfxInteractPropBitDepth,
    kOfxInteractPropHasAlpha,
    kOfxPropKeySym,
    kOfxParamPropParametricDimension,
    kOfxImageEffectPropOpenGLEnabled,
    kOfxImageEffectPropCudaEnabled,
    kOfxImageEffectPropMetalEnabled,
    kOfxImageEffectPropOpenCLEnabled,
];

const DOUBLES: &[&CStr] = &[
    kOfxPropTime,
    kOfxImagePropPixelAspectRatio,
    kOfxImageEffectPropProjectPixelAspectRatio,
    kOfxImageEffectPropFrameRate,
    kOfxImageEffectPropUnmappedFrameRate,
    kOfxImageEffectPropFrameStep,
    kOfxImageEffectPropFrameRange,
    kOfxImageEffectPropUnmappedFrameRange,
    kOfxImageEffectPropRenderScale,
    kOfxImageEffectPropProjectExtent,
    kOfxImageEffectPropProjectSize,
    kOfxImageEffectPropProjectOffset,
    kOfxImageEffectInstancePropEffectDuration,
    kOfxImageEffectPropRegionOfDefinition,
    kOfxImageEffectPropRegionOfInterest,
    kOfxInteractPropPixelScale,
    kOfxInteractPropBackgroundColour,
    kOfxInteractPropSuggestedColour,
    kOfxInteractPropPenPosition,
    kOfxInteractPropPenPressure,
    kOfxParamPropIncrement,
    kOfxParamPropInteractSizeAspect,
    kOfxParamPropInteractMinimumSize,
    kOfxParamPropInterpolationTime,
    kOfxParamPropInterpolationAmount,
    kOfxParamPropParametricRange,
    kOfxParamPropParametricUIColour,
    kOfxParamPropParametricInteractBackground,
];

const TEXTS: &[&CStr] = &[
    kOfxPropType,
    kOfxPropName,
    kOfxPropVersionLabel,
    kOfxPropPluginDescription,
    kOfxPropLabel,
    kOfxPropIcon,
    kOfxPropShortLabel,
    kOfxPropLongLabel,
    kOfxPropChangeReason,
    kOfxPluginPropFilePath,
    kOfxPluginPropParamPageOrder,
    kOfxPropKeyString,
    kOfxImageEffectPropSupportedContexts,
    kOfxImageEffectPropContext,
    kOfxImageEffectPluginRenderThreadSafety,
    kOfxImageEffectPluginPropGrouping,
    kOfxImageEffectPropClipPreferencesSlaveParam,
    kOfxImageEffectHostPropNativeOrigin,
    kOfxImageEffectPropPixelDepth,
    kOfxImageEffectPropComponents,
    kOfxImageEffectPropSupportedPixelDepths,
    kOfxImageEffectPropSupportedComponents,
    kOfxImageEffectPropPreMultiplication,
    kOfxImageEffectPropFieldToRender,
    kOfxImageEffectPropNoSpatialAwareness,
    kOfxImageEffectPropThumbnailRender,
    kOfxImageEffectPropBehaviourWhenUnlicensed,
    kOfxImagePropUniqueIdentifier,
    kOfxImagePropField,
    kOfxImageClipPropUnmappedPixelDepth,
    kOfxImageClipPropUnmappedComponents,
    kOfxImageClipPropFieldOrder,
    kOfxImageClipPropFieldExtraction,
    kOfxImageClipPropColourspace,
    kOfxImageClipPropPreferredColourspaces,
    kOfxImageEffectPropColourManagementStyle,
    kOfxImageEffectPropColourManagementAvailableConfigs,
    kOfxImageEffectPropColourManagementConfig,
    kOfxImageEffectPropOCIOConfig,
    kOfxImageEffectPropOCIODisplay,
    kOfxImageEffectPropOCIOView,
    kOfxImageEffectPropDisplayColourspace,
    kOfxImageEffectPropCPURenderSupported,
    kOfxImageEffectPropOpenGLRenderSupported,
    kOfxImageEffectPropCudaRenderSupported,
    kOfxImageEffectPropCudaStreamSupported,
    kOfxImageEffectPropMetalRenderSupported,
    kOfxImageEffectPropOpenCLRenderSupported,
    kOfxImageEffectPropOpenCLSupported,
    kOfxOpenGLPropPixelDepth,
    kOfxInteractPropSlaveToParam,
    kOfxParamPropType,
    kOfxParamPropScriptName,
    kOfxParamPropCacheInvalidation,
    kOfxParamPropHint,
    kOfxParamPropDoubleType,
    kOfxParamPropDefaultCoordinateSystem,
    kOfxParamPropPageChild,
    kOfxParamPropParent,
    kOfxParamPropChoiceOption,
    kOfxParamPropChoiceEnum,
    kOfxParamPropDimensionLabel,
    kOfxParamPropStringMode,
];

const POINTERS: &[&CStr] = &[
    kOfxPropInstanceData,
    kOfxPropEffectInstance,
    kOfxPropHostOSHandle,
    kOfxImageEffectPropPluginHandle,
    kOfxImageEffectPluginPropOverlayInteractV1,
    kOfxImageEffectPluginPropOverlayInteractV2,
    kOfxImagePropData,
    kOfxInteractPropDrawContext,
    kOfxParamPropInteractV1,
    kOfxParamPropCustomInterpCallbackV1,
    kOfxImageEffectPropCudaStream,
    kOfxImageEffectPropMetalCommandQueue,
    kOfxImageEffectPropOpenCLCommandQueue,
    kOfxImageEffectPropOpenCLImage,
];

const PARAMETER_TYPED: &[&CStr] = &[
    kOfxParamPropDefault,
    kOfxParamPropMin,
    kOfxParamPropMax,
    kOfxParamPropDisplayMin,
    kOfxParamPropDisplayMax,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_are_rejected() {
        assert_eq!(type_of("OfxPropTime"), Some(PropertyType::Double));
        assert_eq!(
            type_of("OfxImageClipPropRoI_Source"),
            Some(PropertyType::Double)
        );
        assert_eq!(type_of("OfxImageClipPropRoI_"), None);
        assert_eq!(type_of("kOfxPropTime"), None);
        // This property's value differs from the name of its constant.
        assert_eq!(
            type_of("OfxImageEffectPropMultipleClipDepths"),
            Some(PropertyType::Int)
        );
    }

    #[test]
    fn no_property_has_two_types() {
        let all = [INTS, DOUBLES, TEXTS, POINTERS, PARAMETER_TYPED].concat();
        let mut names: Vec<_> = all.iter().collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all.len());
    }
}
