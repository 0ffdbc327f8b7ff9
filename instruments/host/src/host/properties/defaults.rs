//! Initial values of property sets.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::colour::*;
use openfx::sys::image_effect_v1::draw_suite::*;
use openfx::sys::image_effect_v1::gpu_render::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::interact::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Value, Values, property_name};
use crate::host::profile::Profile;
use crate::host::sample_type::SampleType;

fn ints(list: &[i32]) -> Vec<Value> {
    list.iter().map(|v| Value::Int(*v)).collect()
}

fn doubles(list: &[f64]) -> Vec<Value> {
    list.iter().map(|v| Value::Double(*v)).collect()
}

fn texts(list: &[&CStr]) -> Vec<Value> {
    list.iter().map(|v| Value::Text((*v).to_owned())).collect()
}

fn text(value: &CStr) -> Vec<Value> {
    texts(&[value])
}

fn values(rows: Vec<(&CStr, Vec<Value>)>) -> Values {
    rows.into_iter()
        .map(|(name, values)| (property_name(name), values))
        .collect()
}

/// Returns the properties of the host.
pub(crate) fn host_properties(profile: &Profile) -> Values {
    let flag = |set: bool| ints(&[i32::from(set)]);
    let mut set = values(vec![
        (kOfxPropType, text(kOfxTypeImageEffectHost)),
        (kOfxPropName, text(profile.host_name)),
        (kOfxPropLabel, text(profile.host_name)),
        (kOfxPropVersion, ints(&[1, 2, 3])),
        (kOfxPropVersionLabel, text(c"1.2.3")),
        (kOfxPropAPIVersion, ints(&[profile.api.0, profile.api.1])),
        (kOfxImageEffectHostPropIsBackground, ints(&[1])),
        (
            kOfxImageEffectPropSupportsOverlays,
            flag(profile.supports_overlays),
        ),
        (
            kOfxImageEffectPropSupportsMultiResolution,
            flag(profile.supports_multi_resolution),
        ),
        (
            kOfxImageEffectPropSupportsTiles,
            flag(profile.supports_tiles),
        ),
        (kOfxImageEffectPropTemporalClipAccess, ints(&[1])),
        (
            kOfxImageEffectPropSupportedComponents,
            texts(&profile.components),
        ),
        (
            kOfxImageEffectPropSupportedContexts,
            texts(&profile.contexts),
        ),
        (
            kOfxImageEffectPropSupportedPixelDepths,
            texts(&SampleType::ALL.map(SampleType::bit_depth)),
        ),
        (
            kOfxImageEffectPropSupportsMultipleClipDepths,
            flag(profile.supports_multiple_depths),
        ),
        (kOfxImageEffectPropSupportsMultipleClipPARs, ints(&[0])),
        (kOfxImageEffectPropSetableFrameRate, ints(&[0])),
        (kOfxImageEffectPropSetableFielding, ints(&[0])),
        (kOfxImageEffectInstancePropSequentialRender, ints(&[0])),
        (kOfxParamHostPropSupportsCustomAnimation, ints(&[0])),
        (kOfxParamHostPropSupportsStringAnimation, ints(&[0])),
        (kOfxParamHostPropSupportsBooleanAnimation, ints(&[1])),
        (kOfxParamHostPropSupportsChoiceAnimation, ints(&[1])),
        (kOfxParamHostPropSupportsCustomInteract, ints(&[0])),
        (kOfxParamHostPropMaxParameters, ints(&[-1])),
        (kOfxParamHostPropMaxPages, ints(&[0])),
        (kOfxParamHostPropPageRowColumnCount, ints(&[0, 0])),
        (kOfxPropHostOSHandle, vec![Value::Pointer(0)]),
        (
            kOfxImageEffectHostPropNativeOrigin,
            text(profile.native_origin),
        ),
    ]);
    if profile.api >= (1, 5) {
        set.extend(values(vec![
            (kOfxParamHostPropSupportsStrChoice, ints(&[1])),
            (kOfxParamHostPropSupportsStrChoiceAnimation, ints(&[0])),
            (kOfxImageEffectPropOpenGLRenderSupported, text(c"false")),
            (kOfxImageEffectPropCudaRenderSupported, text(c"false")),
            (kOfxImageEffectPropMetalRenderSupported, text(c"false")),
            (kOfxImageEffectPropOpenCLRenderSupported, text(c"false")),
            (
                kOfxImageEffectPropColourManagementStyle,
                text(kOfxImageEffectColourManagementNone),
            ),
        ]));
    }
    set
}

/// Returns the initial properties of an effect descriptor.
pub(crate) fn effect_descriptor(profile: &Profile, path: &CStr) -> Values {
    if !profile.has_default_properties {
        return Values::new();
    }
    let mut set = values(vec![
        (kOfxPropType, text(kOfxTypeImageEffect)),
        (kOfxPropLabel, text(c"")),
        (kOfxPropShortLabel, text(c"")),
        (kOfxPropLongLabel, text(c"")),
        (kOfxPropVersion, ints(&[])),
        (kOfxPropVersionLabel, text(c"")),
        (kOfxPropPluginDescription, text(c"")),
        (kOfxPropIcon, texts(&[c"", c""])),
        (kOfxPluginPropFilePath, text(path)),
        (kOfxImageEffectPropSupportedContexts, ints(&[])),
        (kOfxImageEffectPluginPropGrouping, text(c"")),
        (kOfxImageEffectPluginPropSingleInstance, ints(&[0])),
        (
            kOfxImageEffectPluginRenderThreadSafety,
            text(kOfxImageEffectRenderInstanceSafe),
        ),
        (kOfxImageEffectPluginPropHostFrameThreading, ints(&[1])),
        (
            kOfxImageEffectPluginPropOverlayInteractV1,
            vec![Value::Pointer(0)],
        ),
        (kOfxImageEffectPropSupportsMultiResolution, ints(&[1])),
        (kOfxImageEffectPropSupportsTiles, ints(&[1])),
        (kOfxImageEffectPropTemporalClipAccess, ints(&[0])),
        (kOfxImageEffectPropSupportedPixelDepths, ints(&[])),
        (kOfxImageEffectPluginPropFieldRenderTwiceAlways, ints(&[1])),
        (kOfxImageEffectPropSupportsMultipleClipDepths, ints(&[0])),
        (kOfxImageEffectPropSupportsMultipleClipPARs, ints(&[0])),
        (kOfxImageEffectPropClipPreferencesSlaveParam, ints(&[])),
        (kOfxImageEffectInstancePropSequentialRender, ints(&[0])),
    ]);
    if profile.api >= (1, 5) {
        set.extend(values(vec![
            (
                kOfxImageEffectPluginPropOverlayInteractV2,
                vec![Value::Pointer(0)],
            ),
            (kOfxImageEffectPropNoSpatialAwareness, text(c"false")),
            (kOfxImageEffectPropCPURenderSupported, text(c"true")),
            (kOfxImageEffectPropOpenGLRenderSupported, text(c"false")),
            (kOfxImageEffectPropCudaRenderSupported, text(c"false")),
            (kOfxImageEffectPropCudaStreamSupported, text(c"false")),
            (kOfxImageEffectPropMetalRenderSupported, text(c"false")),
            (kOfxImageEffectPropOpenCLRenderSupported, text(c"false")),
            (kOfxImageEffectPropOpenCLSupported, text(c"false")),
            (
                kOfxImageEffectPropColourManagementStyle,
                text(kOfxImageEffectColourManagementNone),
            ),
            (
                kOfxImageEffectPropColourManagementAvailableConfigs,
                ints(&[]),
            ),
        ]));
    }
    set
}

/// Returns the initial properties of a clip descriptor.
pub(crate) fn clip_descriptor(profile: &Profile, name: &CStr) -> Values {
    if !profile.has_default_properties {
        return Values::new();
    }
    values(vec![
        (kOfxPropType, text(kOfxTypeClip)),
        (kOfxPropName, text(name)),
        (kOfxPropLabel, text(name)),
        (kOfxPropShortLabel, text(name)),
        (kOfxPropLongLabel, text(name)),
        (kOfxPropPluginDescription, text(c"")),
        (kOfxImageEffectPropSupportedComponents, ints(&[])),
        (kOfxImageEffectPropTemporalClipAccess, ints(&[0])),
        (kOfxImageClipPropOptional, ints(&[0])),
        (
            kOfxImageClipPropFieldExtraction,
            text(kOfxImageFieldDoubled),
        ),
        (kOfxImageClipPropIsMask, ints(&[0])),
        (kOfxImageEffectPropSupportsTiles, ints(&[1])),
    ])
}

/// Returns the initial properties of a parameter descriptor of type `kind`.
pub(crate) fn parameter_descriptor(profile: &Profile, kind: &CStr, name: &CStr) -> Values {
    if !profile.has_default_properties {
        return Values::new();
    }
    let mut set = values(vec![
        (kOfxPropType, text(kOfxTypeParameter)),
        (kOfxPropName, text(name)),
        (kOfxPropLabel, text(name)),
        (kOfxPropShortLabel, text(name)),
        (kOfxPropLongLabel, text(name)),
        (kOfxPropIcon, texts(&[c"", c""])),
        (kOfxParamPropType, text(kind)),
        (kOfxParamPropSecret, ints(&[0])),
        (kOfxParamPropCanUndo, ints(&[1])),
        (kOfxParamPropHint, text(c"")),
        (kOfxParamPropScriptName, text(name)),
        (kOfxParamPropParent, text(c"")),
        (kOfxParamPropEnabled, ints(&[1])),
        (kOfxParamPropDataPtr, vec![Value::Pointer(0)]),
    ]);
    let group = kind == kOfxParamTypeGroup;
    let page = kind == kOfxParamTypePage;
    if group {
        set.extend(values(vec![(kOfxParamPropGroupOpen, ints(&[1]))]));
    }
    if page {
        set.extend(values(vec![(kOfxParamPropPageChild, ints(&[]))]));
    }
    if group || page || kind == kOfxParamTypePushButton {
        return set;
    }
    set.extend(values(vec![
        (kOfxParamPropAnimates, ints(&[1])),
        (kOfxParamPropIsAnimating, ints(&[0])),
        (kOfxParamPropIsAutoKeying, ints(&[0])),
        (kOfxParamPropPersistant, ints(&[1])),
        (kOfxParamPropEvaluateOnChange, ints(&[1])),
        (kOfxParamPropPluginMayWrite, ints(&[0])),
        (
            kOfxParamPropCacheInvalidation,
            text(kOfxParamInvalidateValueChange),
        ),
    ]));
    set.extend(value_properties(kind));
    set
}

/// The type of a numeric parameter.
#[derive(Clone, Copy)]
pub(crate) struct NumericType {
    pub(crate) components: usize,
    pub(crate) is_integer: bool,
}

/// Returns the numeric type of parameters of type `kind`, or nothing if their values are not numbers.
pub(crate) fn numeric_type(kind: &CStr) -> Option<NumericType> {
    let rows = [
        (kOfxParamTypeInteger, 1, true),
        (kOfxParamTypeInteger2D, 2, true),
        (kOfxParamTypeInteger3D, 3, true),
        (kOfxParamTypeBoolean, 1, true),
        (kOfxParamTypeChoice, 1, true),
        (kOfxParamTypeDouble, 1, false),
        (kOfxParamTypeDouble2D, 2, false),
        (kOfxParamTypeDouble3D, 3, false),
        (kOfxParamTypeRGB, 3, false),
        (kOfxParamTypeRGBA, 4, false),
    ];
    let (_, components, is_integer) = rows.into_iter().find(|(name, ..)| *name == kind)?;
    Some(NumericType {
        components,
        is_integer,
    })
}

/// Returns the properties that depend on the type of the value.
fn value_properties(kind: &CStr) -> Values {
    let mut rows = Vec::new();
    match numeric_type(kind) {
        Some(NumericType {
            components: count,
            is_integer: true,
        }) => {
            rows.push((kOfxParamPropDefault, ints(&vec![0; count])));
            if kind != kOfxParamTypeBoolean && kind != kOfxParamTypeChoice {
                for name in [kOfxParamPropMin, kOfxParamPropDisplayMin] {
                    rows.push((name, ints(&vec![i32::MIN; count])));
                }
                for name in [kOfxParamPropMax, kOfxParamPropDisplayMax] {
                    rows.push((name, ints(&vec![i32::MAX; count])));
                }
                rows.push((kOfxParamPropDimensionLabel, texts(&[c"x", c"y"])));
            }
            if kind == kOfxParamTypeChoice {
                rows.push((kOfxParamPropChoiceOption, ints(&[])));
                rows.push((kOfxParamPropChoiceOrder, ints(&[])));
            }
        }
        Some(NumericType {
            components: count,
            is_integer: false,
        }) => {
            rows.push((kOfxParamPropDefault, doubles(&vec![0.0; count])));
            for name in [kOfxParamPropMin, kOfxParamPropDisplayMin] {
                rows.push((name, doubles(&vec![-f64::MAX; count])));
            }
            for name in [kOfxParamPropMax, kOfxParamPropDisplayMax] {
                rows.push((name, doubles(&vec![f64::MAX; count])));
            }
            rows.push((kOfxParamPropIncrement, doubles(&[1.0])));
            rows.push((kOfxParamPropDigits, ints(&[2])));
            rows.push((kOfxParamPropDimensionLabel, texts(&[c"x", c"y"])));
            rows.push((kOfxParamPropDoubleType, text(kOfxParamDoubleTypePlain)));
            rows.push((
                kOfxParamPropDefaultCoordinateSystem,
                text(kOfxParamCoordinatesCanonical),
            ));
            rows.push((kOfxParamPropShowTimeMarker, ints(&[0])));
            if kind == kOfxParamTypeDouble2D {
                rows.push((kOfxParamPropHasHostOverlayHandle, ints(&[0])));
                rows.push((kOfxParamPropUseHostOverlayHandle, ints(&[0])));
            }
        }
        None => {
            rows.push((kOfxParamPropDefault, text(c"")));
            rows.push((kOfxParamPropStringMode, text(kOfxParamStringIsSingleLine)));
            rows.push((kOfxParamPropStringFilePathExists, ints(&[1])));
            if kind == kOfxParamTypeStrChoice {
                rows.push((kOfxParamPropChoiceOption, ints(&[])));
                rows.push((kOfxParamPropChoiceEnum, ints(&[])));
                rows.push((kOfxParamPropChoiceOrder, ints(&[])));
            }
        }
    }
    values(rows)
}

/// Returns the initial properties of an overlay of the effect with this handle.
pub(crate) fn interact(effect: usize) -> Values {
    values(vec![
        (kOfxPropEffectInstance, vec![Value::Pointer(effect)]),
        (kOfxPropInstanceData, vec![Value::Pointer(0)]),
        (kOfxInteractPropPixelScale, doubles(&[1.0, 1.0])),
        (kOfxInteractPropBackgroundColour, doubles(&[0.0, 0.0, 0.0])),
        (kOfxInteractPropSuggestedColour, doubles(&[1.0, 1.0, 1.0])),
        (kOfxInteractPropBitDepth, ints(&[8])),
        (kOfxInteractPropHasAlpha, ints(&[0])),
        (kOfxInteractPropSlaveToParam, ints(&[])),
        (kOfxInteractPropDrawContext, vec![Value::Pointer(0)]),
    ])
}
