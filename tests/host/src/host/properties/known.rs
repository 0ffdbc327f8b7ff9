//! Every property of OpenFX that a plugin may meet, with its type: a name that is not here is misspelt.

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

/// The type of a property's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Int,
    Double,
    Text,
    Pointer,
    /// Ranges and defaults of a parameter, which have its type.
    OfParameter,
}

/// The type of the property, nothing if OpenFX has none of that name.
pub(crate) fn type_of(name: &str) -> Option<Type> {
    static ALL: OnceLock<BTreeMap<String, Type>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let of = |names: &'static [&'static CStr], kind: Type| {
            (names.iter()).map(move |name| (name.to_string_lossy().into_owned(), kind))
        };
        of(INTS, Type::Int)
            .chain(of(DOUBLES, Type::Double))
            .chain(of(TEXTS, Type::Text))
            .chain(of(POINTERS, Type::Pointer))
            .chain(of(OF_PARAMETER, Type::OfParameter))
            .collect()
    });
    all.get(name).copied().or_else(|| {
        // Those of a clip carry its name at the end.
        OF_CLIPS
            .iter()
            .find(|(start, _)| name.len() > start.len() && name.starts_with(start))
            .map(|(_, kind)| *kind)
    })
}

/// Properties of actions that are named after a clip, by how they begin.
const OF_CLIPS: [(&str, Type); 6] = [
    ("OfxImageClipPropComponents_", Type::Text),
    ("OfxImageClipPropDepth_", Type::Text),
    ("OfxImageClipPropPreferredColourspaces_", Type::Text),
    ("OfxImageClipPropPAR_", Type::Double),
    ("OfxImageClipPropRoI_", Type::Double),
    ("OfxImageClipPropFrameRange_", Type::Double),
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
];

const OF_PARAMETER: &[&CStr] = &[
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
    fn misspelt_names_are_not_known() {
        assert_eq!(type_of("OfxPropTime"), Some(Type::Double));
        assert_eq!(type_of("OfxImageClipPropRoI_Source"), Some(Type::Double));
        assert_eq!(type_of("OfxImageClipPropRoI_"), None);
        assert_eq!(type_of("kOfxPropTime"), None);
        // Its name is not what its constant is called.
        assert_eq!(
            type_of("OfxImageEffectPropMultipleClipDepths"),
            Some(Type::Int)
        );
    }

    #[test]
    fn no_property_has_two_types() {
        let all = [INTS, DOUBLES, TEXTS, POINTERS, OF_PARAMETER].concat();
        let mut names: Vec<_> = all.iter().collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all.len());
    }
}
