//! The state of each variant between actions: its host and the host's suites.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use openfx::sys::generic::core::*;
use openfx::sys::generic::property::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::message::*;
use openfx::sys::image_effect_v1::multi_thread::*;
use openfx::sys::image_effect_v1::param::*;

use crate::faults::{COUNT, Fault};

/// Copies of the host's suites.
#[derive(Clone, Copy)]
pub(crate) struct Suites {
    pub(crate) host: OfxPropertySetHandle,
    pub(crate) property: OfxPropertySuiteV1,
    pub(crate) effect: OfxImageEffectSuiteV1,
    pub(crate) parameter: OfxParameterSuiteV1,
    pub(crate) threads: Option<OfxMultiThreadSuiteV1>,
    pub(crate) message1: Option<OfxMessageSuiteV1>,
    pub(crate) message2: Option<OfxMessageSuiteV2>,
}

// SAFETY: the host's handles and functions may be used on any thread.
unsafe impl Send for Suites {}
// SAFETY: as above.
unsafe impl Sync for Suites {}

struct State {
    host: usize,
    loads: usize,
    suites: Option<Suites>,
}

#[expect(
    clippy::declare_interior_mutable_const,
    reason = "initialises an array"
)]
const EMPTY: Mutex<State> = Mutex::new(State {
    host: 0,
    loads: 0,
    suites: None,
});

static STATES: [Mutex<State>; COUNT] = [EMPTY; COUNT];

/// The number of loads of [`Fault::StaleState`], which is never reset.
pub(crate) static LOADS: AtomicUsize = AtomicUsize::new(0);
/// The number of renders of [`Fault::Accumulates`], which is never reset.
pub(crate) static RENDERS: AtomicUsize = AtomicUsize::new(0);
/// The render that started last, by time, for [`Fault::SharedState`].
pub(crate) static LAST_RENDER: AtomicUsize = AtomicUsize::new(0);

fn state(fault: Fault) -> MutexGuard<'static, State> {
    STATES[fault as usize]
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
}

/// Sets the host of a variant.
pub(crate) fn set_host(fault: Fault, host: *mut OfxHost) {
    state(fault).host = host as usize;
}

/// Returns the suites, if the variant is loaded.
pub(crate) fn suites(fault: Fault) -> Option<Suites> {
    state(fault).suites
}

/// Fetches the suites for Load.
pub(crate) fn load(fault: Fault) -> OfxStatus {
    let mut state = state(fault);
    let host = state.host as *const OfxHost;
    if host.is_null() {
        return kOfxStatErrMissingHostFeature;
    }
    // SAFETY: the structure is valid as long as the plugin is loaded.
    let host = unsafe { *host };
    let (Some(property), Some(effect), Some(parameter)) = (
        fetch::<OfxPropertySuiteV1>(&host, kOfxPropertySuite, 1),
        fetch::<OfxImageEffectSuiteV1>(&host, kOfxImageEffectSuite, 1),
        fetch::<OfxParameterSuiteV1>(&host, kOfxParameterSuite, 1),
    ) else {
        return kOfxStatErrMissingHostFeature;
    };
    state.suites = Some(Suites {
        host: host.host,
        property,
        effect,
        parameter,
        threads: fetch(&host, kOfxMultiThreadSuite, 1),
        message1: fetch(&host, kOfxMessageSuite, 1),
        message2: fetch(&host, kOfxMessageSuite, 2),
    });
    state.loads += 1;
    if fault == Fault::StaleState {
        LOADS.fetch_add(1, Ordering::SeqCst);
    }
    kOfxStatOK
}

/// Drops the suites with the last Unload.
pub(crate) fn unload(fault: Fault) {
    let mut state = state(fault);
    state.loads = state.loads.saturating_sub(1);
    if state.loads == 0 {
        state.suites = None;
    }
}

fn fetch<T: Copy>(host: &OfxHost, name: &std::ffi::CStr, version: i32) -> Option<T> {
    // SAFETY: the name is a string.
    let suite = unsafe { (host.fetchSuite?)(host.host, name.as_ptr(), version) };
    // SAFETY: a suite of that name and version is of that type.
    (!suite.is_null()).then(|| unsafe { suite.cast::<T>().read() })
}
