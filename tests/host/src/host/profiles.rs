//! Kinds of hosts, as far as what they do is public: reference is beside each.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::colour::*;
use openfx::sys::image_effect_v1::draw_suite::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::interact::*;
use openfx::sys::image_effect_v1::memory::*;
use openfx::sys::image_effect_v1::message::*;
use openfx::sys::image_effect_v1::multi_thread::*;
use openfx::sys::image_effect_v1::param::*;
use openfx::sys::image_effect_v1::progress::*;
use openfx::sys::image_effect_v1::time_line::*;

use super::profile::{Profile, Rows};

/// Every kind, the complete one first.
#[must_use]
pub fn all() -> Vec<Profile> {
    vec![
        Profile::complete(),
        nuke(),
        resolve(),
        natron(),
        fusion(),
        runner(),
        mlt(),
        bare(),
    ]
}

/// Suites of version 1.5 that older hosts have not.
const NEWER: [(&std::ffi::CStr, i32); 3] = [
    (kOfxDrawSuite, 1),
    (kOfxMessageSuite, 2),
    (kOfxProgressSuite, 2),
];

/// API 1.2, tiles, Filter and General alone; openfx-misc README-hosts.txt.
fn nuke() -> Profile {
    Profile {
        name: "nuke",
        host_name: c"uk.co.thefoundry.nuke",
        api: (1, 2),
        lacks: vec![kOfxImageEffectInstancePropSequentialRender],
        absent: vec![(kOfxDrawSuite, 1)],
        components: vec![kOfxImageComponentRGBA, kOfxImageComponentAlpha],
        multiple_depths: false,
        ..Profile::complete()
    }
}

/// No tiles, one size for all inputs, every clip connected, messages half there; openfx-misc README-hosts.txt, issues
/// 54, 56 and 74.
fn resolve() -> Profile {
    Profile {
        name: "resolve",
        host_name: c"DaVinciResolve",
        api: (1, 4),
        lacks: vec![
            kOfxParamPropDefaultCoordinateSystem,
            kOfxPropHostOSHandle,
            kOfxImageEffectPropPluginHandle,
            kOfxImageEffectInstancePropSequentialRender,
        ],
        absent: vec![(kOfxDrawSuite, 1), (kOfxProgressSuite, 2)],
        null_members: vec!["message2.setPersistentMessage".to_owned()],
        clear_is_garbage: true,
        tiles: false,
        multi_resolution: false,
        multiple_depths: false,
        all_connected: true,
        components: vec![kOfxImageComponentRGBA, kOfxImageComponentAlpha],
        serial: true,
        image_scale_factor: 0.0,
        ..Profile::complete()
    }
}

/// API 1.4 with everything on; NatronGitHub/openfx, openfx-misc README-hosts.txt.
fn natron() -> Profile {
    Profile {
        name: "natron",
        host_name: c"fr.inria.Natron",
        api: (1, 4),
        absent: vec![(kOfxDrawSuite, 1)],
        ..Profile::complete()
    }
}

/// API 1.0: few properties, images of the inverse scale, origin at the top; openfx-misc README-hosts.txt.
fn fusion() -> Profile {
    Profile {
        name: "fusion",
        host_name: c"com.blackmagicdesign.Fusion",
        api: (1, 0),
        native_origin: kOfxHostNativeOriginTopLeft,
        lacks: vec![
            kOfxPropAPIVersion,
            kOfxPropVersion,
            kOfxPropVersionLabel,
            kOfxPropPluginDescription,
            kOfxPropIcon,
            kOfxImageEffectInstancePropSequentialRender,
            kOfxImageEffectPropSequentialRenderStatus,
            kOfxImageEffectPropInteractiveRenderStatus,
            kOfxImageEffectHostPropNativeOrigin,
            kOfxImagePropPixelAspectRatio,
            kOfxPropHostOSHandle,
            kOfxParamPropDefaultCoordinateSystem,
            kOfxParamPropUseHostOverlayHandle,
            kOfxParamPropHasHostOverlayHandle,
            kOfxPluginPropFilePath,
        ],
        absent: NEWER.to_vec(),
        components: vec![kOfxImageComponentRGBA],
        tiles: false,
        multiple_depths: false,
        image_scale_factor: 3.0,
        ..Profile::complete()
    }
}

/// Descriptors without a single property, no optional action, clips without a region until a render; the sources of
/// openfx-runner.
fn runner() -> Profile {
    Profile {
        name: "runner",
        host_name: c"openfx-driver",
        api: (1, 4),
        describes: false,
        absent: [
            &NEWER[..],
            &[
                (kOfxProgressSuite, 1),
                (kOfxTimeLineSuite, 1),
                (kOfxInteractSuite, 1),
            ],
        ]
        .concat(),
        tiles: false,
        multi_resolution: false,
        rows: Rows::Odd,
        late_regions: true,
        asks: false,
        sequences: false,
        overlays: false,
        components: vec![kOfxImageComponentRGBA, kOfxImageComponentAlpha],
        ..Profile::complete()
    }
}

/// Images from the top down, loaded anew for every instance, regions in pixels at any scale; MLT's src/modules/openfx.
fn mlt() -> Profile {
    Profile {
        name: "mlt",
        host_name: c"org.mltframework.mlt",
        api: (1, 4),
        contexts: vec![kOfxImageEffectContextFilter],
        rows: Rows::Negative,
        pixel_regions: true,
        reloads: true,
        overlays: false,
        multiple_depths: false,
        all_connected: true,
        components: vec![kOfxImageComponentRGBA],
        ..Profile::complete()
    }
}

/// The three suites without which nothing can be done, and no property newer than 1.0.
fn bare() -> Profile {
    Profile {
        name: "bare",
        host_name: c"bare",
        api: (1, 0),
        describes: false,
        lacks: vec![
            kOfxPropAPIVersion,
            kOfxPropVersion,
            kOfxPropVersionLabel,
            kOfxPropLabel,
            kOfxImageEffectPropSupportsTiles,
            kOfxImageEffectPropSupportsMultiResolution,
            kOfxImageEffectPropSupportsMultipleClipDepths,
            kOfxImageEffectPropSupportsMultipleClipPARs,
            kOfxImageEffectPropTemporalClipAccess,
            kOfxImageEffectInstancePropSequentialRender,
            kOfxImageEffectPropSequentialRenderStatus,
            kOfxImageEffectPropInteractiveRenderStatus,
            kOfxImageEffectPropRenderQualityDraft,
            kOfxImageEffectPropProjectSize,
            kOfxImageEffectPropProjectOffset,
            kOfxImageEffectPropProjectExtent,
            kOfxImageEffectPropProjectPixelAspectRatio,
            kOfxImageEffectPropColourManagementStyle,
            kOfxImageClipPropColourspace,
            kOfxImagePropUniqueIdentifier,
            kOfxImagePropField,
            kOfxImagePropPixelAspectRatio,
            kOfxImageEffectPropPreMultiplication,
            kOfxImageEffectPropRenderScale,
            kOfxImageEffectPropFieldToRender,
            kOfxPluginPropFilePath,
        ],
        absent: [
            &NEWER[..],
            &[
                (kOfxMemorySuite, 1),
                (kOfxMultiThreadSuite, 1),
                (kOfxMessageSuite, 1),
                (kOfxProgressSuite, 1),
                (kOfxTimeLineSuite, 1),
                (kOfxInteractSuite, 1),
            ],
        ]
        .concat(),
        tiles: false,
        overlays: false,
        asks: false,
        sequences: false,
        ..Profile::complete()
    }
}
