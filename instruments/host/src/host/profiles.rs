//! Profiles of real hosts, from public sources named at each.

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

use super::profile::{Profile, RowLayout};

/// Returns all profiles, the complete one first.
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

/// Suites that hosts of the first OpenFX versions lack.
const NEWER_SUITES: [(&std::ffi::CStr, i32); 3] = [
    (kOfxDrawSuite, 1),
    (kOfxMessageSuite, 2),
    (kOfxProgressSuite, 2),
];

/// Nuke: API 1.2, no RGB clips. Source: openfx-misc README-hosts.txt.
fn nuke() -> Profile {
    Profile {
        name: "nuke",
        host_name: c"uk.co.thefoundry.nuke",
        api: (1, 2),
        missing_properties: vec![kOfxImageEffectInstancePropSequentialRender],
        missing_suites: vec![(kOfxDrawSuite, 1)],
        components: vec![kOfxImageComponentRGBA, kOfxImageComponentAlpha],
        supports_multiple_depths: false,
        ..Profile::complete()
    }
}

/// DaVinci Resolve: no tiles, inputs of one size, all clips connected, incomplete message suite. Source: openfx-misc
/// README-hosts.txt; openfx issues 54, 56 and 74.
fn resolve() -> Profile {
    Profile {
        name: "resolve",
        host_name: c"DaVinciResolve",
        api: (1, 4),
        missing_properties: vec![
            kOfxParamPropDefaultCoordinateSystem,
            kOfxPropHostOSHandle,
            kOfxImageEffectPropPluginHandle,
            kOfxImageEffectInstancePropSequentialRender,
        ],
        missing_suites: vec![(kOfxDrawSuite, 1), (kOfxProgressSuite, 2)],
        null_functions: vec!["message2.setPersistentMessage".to_owned()],
        invalid_clear_message: true,
        supports_tiles: false,
        supports_multi_resolution: false,
        supports_multiple_depths: false,
        all_connected: true,
        components: vec![kOfxImageComponentRGBA, kOfxImageComponentAlpha],
        serial_threads: true,
        image_scale_factor: 0.0,
        ..Profile::complete()
    }
}

/// Natron: API 1.4, complete but for the draw suite, with ways of its own with messages, panels, components, paths and connections.
/// Sources: NatronGitHub/openfx, openfx-misc README-hosts.txt, and Natron 2.5 as it behaves.
pub(crate) fn natron() -> Profile {
    Profile {
        name: "natron",
        host_name: c"fr.inria.Natron",
        api: (1, 4),
        missing_suites: vec![(kOfxDrawSuite, 1)],
        blank_message_arguments: true,
        appends_unlisted_groups: true,
        widest_output: true,
        absolute_paths: true,
        late_components: true,
        ..Profile::complete()
    }
}

/// Fusion: API 1.0, few properties, wrong render scale of images, origin at the top. Source: openfx-misc
/// README-hosts.txt.
fn fusion() -> Profile {
    Profile {
        name: "fusion",
        host_name: c"com.blackmagicdesign.Fusion",
        api: (1, 0),
        native_origin: kOfxHostNativeOriginTopLeft,
        missing_properties: vec![
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
        missing_suites: NEWER_SUITES.to_vec(),
        components: vec![kOfxImageComponentRGBA],
        supports_tiles: false,
        supports_multiple_depths: false,
        image_scale_factor: 3.0,
        ..Profile::complete()
    }
}

/// openfx-runner: empty descriptors, no optional actions, no regions of clips before a render. Source: its code.
fn runner() -> Profile {
    Profile {
        name: "runner",
        host_name: c"openfx-driver",
        api: (1, 4),
        has_default_properties: false,
        missing_suites: [
            &NEWER_SUITES[..],
            &[
                (kOfxProgressSuite, 1),
                (kOfxTimeLineSuite, 1),
                (kOfxInteractSuite, 1),
            ],
        ]
        .concat(),
        supports_tiles: false,
        supports_multi_resolution: false,
        rows: RowLayout::Odd,
        late_regions: true,
        calls_optional_actions: false,
        calls_sequence_actions: false,
        supports_overlays: false,
        components: vec![kOfxImageComponentRGBA, kOfxImageComponentAlpha],
        ..Profile::complete()
    }
}

/// MLT: images from the top down, a reload for every instance, regions in pixels of the render scale. Source:
/// src/modules/openfx.
fn mlt() -> Profile {
    Profile {
        name: "mlt",
        host_name: c"MLT",
        api: (1, 4),
        contexts: vec![kOfxImageEffectContextFilter],
        rows: RowLayout::Negative,
        pixel_regions: true,
        reloads: true,
        supports_overlays: false,
        supports_multiple_depths: false,
        all_connected: true,
        components: vec![kOfxImageComponentRGBA],
        ..Profile::complete()
    }
}

/// A minimal host: the three required suites, and few optional properties.
fn bare() -> Profile {
    Profile {
        name: "bare",
        host_name: c"bare",
        api: (1, 0),
        has_default_properties: false,
        missing_properties: vec![
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
        missing_suites: [
            &NEWER_SUITES[..],
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
        supports_tiles: false,
        supports_overlays: false,
        calls_optional_actions: false,
        calls_sequence_actions: false,
        ..Profile::complete()
    }
}
