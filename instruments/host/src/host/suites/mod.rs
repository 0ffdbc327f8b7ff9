//! The suites, one per file, and `fetchSuite`.
//!
//! Pointers from plugins are trusted; handles are numbers that are looked up, never dereferenced.

mod draw;
mod image_effect;
mod interact;
mod memory;
mod message;
mod multi_thread;
mod parameter;
mod pointers;
mod progress;
mod property;
mod time_line;
mod variadic;

use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Mutex;

use openfx::sys::generic::core::*;
use openfx::sys::generic::property::*;
use openfx::sys::image_effect_v1::draw_suite::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::interact::*;
use openfx::sys::image_effect_v1::memory::*;
use openfx::sys::image_effect_v1::message::*;
use openfx::sys::image_effect_v1::multi_thread::*;
use openfx::sys::image_effect_v1::param::*;
use openfx::sys::image_effect_v1::progress::*;
use openfx::sys::image_effect_v1::time_line::*;

pub use draw::{Drawing, Shape};
pub(crate) use interact::Overlay;
pub(crate) use memory::MemoryBlock;
pub(crate) use multi_thread::RecursiveMutex;

use super::profile::Profile;
use super::{current, locked};

/// All suites of a host.
pub(crate) struct Suites {
    property: OfxPropertySuiteV1,
    image_effect: OfxImageEffectSuiteV1,
    parameter: OfxParameterSuiteV1,
    memory: OfxMemorySuiteV1,
    multi_thread: OfxMultiThreadSuiteV1,
    message1: OfxMessageSuiteV1,
    message2: OfxMessageSuiteV2,
    progress1: OfxProgressSuiteV1,
    progress2: OfxProgressSuiteV2,
    time_line: OfxTimeLineSuiteV1,
    interact: OfxInteractSuiteV1,
    draw: OfxDrawSuiteV1,
}

macro_rules! functions {
    ($($suite:ident: $($function:ident)*;)*) => {
        /// Returns the names of all functions of all suites, as `suite.function`.
        #[must_use]
        pub(crate) fn all_functions() -> Vec<String> {
            [$($(concat!(stringify!($suite), ".", stringify!($function))),*),*].map(str::to_owned).to_vec()
        }

        impl Suites {
            fn remove_function(&mut self, name: &str) {
                match name {
                    $($(concat!(stringify!($suite), ".", stringify!($function)) => {
                        self.$suite.$function = None;
                    })*)*
                    _ => {}
                }
            }
        }
    };
}

functions! {
    property: propSetPointer propSetString propSetDouble propSetInt propSetPointerN propSetStringN propSetDoubleN
        propSetIntN propGetPointer propGetString propGetDouble propGetInt propGetPointerN propGetStringN
        propGetDoubleN propGetIntN propReset propGetDimension;
    image_effect: getPropertySet getParamSet clipDefine clipGetHandle clipGetPropertySet clipGetImage
        clipReleaseImage clipGetRegionOfDefinition abort imageMemoryAlloc imageMemoryFree imageMemoryLock
        imageMemoryUnlock;
    parameter: paramDefine paramGetHandle paramSetGetPropertySet paramGetPropertySet paramGetValue
        paramGetValueAtTime paramGetDerivative paramGetIntegral paramSetValue paramSetValueAtTime paramGetNumKeys
        paramGetKeyTime paramGetKeyIndex paramDeleteKey paramDeleteAllKeys paramCopy paramEditBegin paramEditEnd;
    memory: memoryAlloc memoryFree;
    multi_thread: multiThread multiThreadNumCPUs multiThreadIndex multiThreadIsSpawnedThread mutexCreate mutexDestroy
        mutexLock mutexUnLock mutexTryLock;
    message1: message;
    message2: message setPersistentMessage clearPersistentMessage;
    progress1: progressStart progressUpdate progressEnd;
    progress2: progressStart progressUpdate progressEnd;
    time_line: getTime gotoTime getTimeBounds;
    interact: interactSwapBuffers interactRedraw interactGetPropertySet;
    draw: getColour setColour setLineWidth setLineStipple draw drawText;
}

/// Suites that every plugin needs.
pub(crate) const REQUIRED: [&CStr; 3] =
    [kOfxImageEffectSuite, kOfxPropertySuite, kOfxParameterSuite];

/// Suites that plugins can do without, by name and version.
pub(crate) const OPTIONAL: [(&CStr, i32); 9] = [
    (kOfxMemorySuite, 1),
    (kOfxMultiThreadSuite, 1),
    (kOfxMessageSuite, 1),
    (kOfxMessageSuite, 2),
    (kOfxProgressSuite, 1),
    (kOfxProgressSuite, 2),
    (kOfxTimeLineSuite, 1),
    (kOfxInteractSuite, 1),
    (kOfxDrawSuite, 1),
];

impl Suites {
    /// Creates the suites of a kind of host. They are never freed, because plugins may keep pointers to them.
    pub(crate) fn new(profile: &Profile) -> &'static Self {
        let mut suites = Self {
            property: property::suite(),
            image_effect: image_effect::suite(),
            parameter: parameter::suite(),
            memory: memory::suite(),
            multi_thread: multi_thread::suite(),
            message1: message::suite_v1(),
            message2: message::suite_v2(if profile.invalid_clear_message {
                message::invalid_clear
            } else {
                message::clear
            }),
            progress1: progress::suite_v1(),
            progress2: progress::suite_v2(),
            time_line: time_line::suite(),
            interact: interact::suite(),
            draw: draw::suite(),
        };
        for name in &profile.null_functions {
            suites.remove_function(name);
        }
        // SAFETY: `leak` returns a valid pointer that is never freed.
        unsafe { &*leak(suites) }
    }

    /// Returns a suite, or NULL if the host does not provide it.
    pub(super) fn get(&self, profile: &Profile, name: &CStr, version: i32) -> *const c_void {
        if profile.missing_suites.contains(&(name, version)) {
            return std::ptr::null();
        }
        let rows: [(&CStr, i32, *const c_void); 12] = [
            (kOfxPropertySuite, 1, (&raw const self.property).cast()),
            (
                kOfxImageEffectSuite,
                1,
                (&raw const self.image_effect).cast(),
            ),
            (kOfxParameterSuite, 1, (&raw const self.parameter).cast()),
            (kOfxMemorySuite, 1, (&raw const self.memory).cast()),
            (
                kOfxMultiThreadSuite,
                1,
                (&raw const self.multi_thread).cast(),
            ),
            (kOfxMessageSuite, 1, (&raw const self.message1).cast()),
            (kOfxMessageSuite, 2, (&raw const self.message2).cast()),
            (kOfxProgressSuite, 1, (&raw const self.progress1).cast()),
            (kOfxProgressSuite, 2, (&raw const self.progress2).cast()),
            (kOfxTimeLineSuite, 1, (&raw const self.time_line).cast()),
            (kOfxInteractSuite, 1, (&raw const self.interact).cast()),
            (kOfxDrawSuite, 1, (&raw const self.draw).cast()),
        ];
        (rows.iter())
            .find(|row| row.0 == name && row.1 == version)
            .map_or(std::ptr::null(), |row| row.2)
    }
}

/// Keeps a value until the process ends. It stays reachable, so memory checkers report no leak.
pub(crate) fn leak<T: 'static>(value: T) -> *mut T {
    static LEAKED: Mutex<Vec<usize>> = Mutex::new(Vec::new());
    let pointer = Box::into_raw(Box::new(value));
    locked(&LEAKED).push(pointer as usize);
    pointer
}

/// Implements `OfxHost::fetchSuite`.
pub(crate) unsafe extern "C" fn fetch(
    host: OfxPropertySetHandle,
    name: *const c_char,
    version: c_int,
) -> *const c_void {
    let Some(active) = current() else {
        return std::ptr::null();
    };
    if host as usize != active.properties.handle() {
        active.record_misuse("fetchSuite was given a handle that is not the host's");
        return std::ptr::null();
    }
    // SAFETY: the plugin passes the name as a string.
    match unsafe { pointers::c_str(name) } {
        Some(name) => active.suite(name, version),
        None => {
            active.record_misuse("fetchSuite was given a NULL name");
            std::ptr::null()
        }
    }
}
