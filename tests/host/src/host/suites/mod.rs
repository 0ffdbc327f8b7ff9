//! The suites, one a file, and how plugins get them.
//!
//! What plugins hand over by pointer is theirs to keep right; handles are numbers that are looked up, never followed.

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

pub use draw::{Stroke, Strokes};
pub(crate) use interact::Overlay;
pub(crate) use memory::Block;
pub(crate) use multi_thread::Lock;

use super::profile::Profile;
use super::{current, locked};

/// Every suite of a host.
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

macro_rules! members {
    ($($suite:ident: $($member:ident)*;)*) => {
        /// Every member of every suite, as `suite.member`.
        #[must_use]
        pub(crate) fn all_members() -> Vec<String> {
            [$($(concat!(stringify!($suite), ".", stringify!($member))),*),*].map(str::to_owned).to_vec()
        }

        impl Suites {
            fn without(&mut self, name: &str) {
                match name {
                    $($(concat!(stringify!($suite), ".", stringify!($member)) => {
                        self.$suite.$member = None;
                    })*)*
                    _ => {}
                }
            }
        }
    };
}

members! {
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

/// Suites that a plugin cannot do without.
pub(crate) const NEEDED: [&CStr; 3] = [kOfxImageEffectSuite, kOfxPropertySuite, kOfxParameterSuite];

/// Suites that it can, by version.
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
    /// Those of a kind of host. Plugins may keep them for good, and so they are.
    pub(crate) fn made(profile: &Profile) -> &'static Self {
        let mut made = Self {
            property: property::suite(),
            image_effect: image_effect::suite(),
            parameter: parameter::suite(),
            memory: memory::suite(),
            multi_thread: multi_thread::suite(),
            message1: message::first(),
            message2: message::second(profile.clear_is_garbage),
            progress1: progress::first(),
            progress2: progress::second(),
            time_line: time_line::suite(),
            interact: interact::suite(),
            draw: draw::suite(),
        };
        for name in &profile.null_members {
            made.without(name);
        }
        // SAFETY: `for_good` never frees what it is given.
        unsafe { &*for_good(made) }
    }

    pub(super) fn get(&self, profile: &Profile, name: &CStr, version: i32) -> *const c_void {
        if profile.absent.contains(&(name, version)) {
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

/// Keeps a value where it is until the process ends, and reachable, so that memory checkers do not call it lost.
pub(crate) fn for_good<T: 'static>(value: T) -> *mut T {
    struct Kept(#[expect(dead_code, reason = "kept, never read")] usize);
    static ALL: Mutex<Vec<Kept>> = Mutex::new(Vec::new());
    let at = Box::into_raw(Box::new(value));
    locked(&ALL).push(Kept(at as usize));
    at
}

/// `OfxHost::fetchSuite`.
pub(crate) unsafe extern "C" fn fetch(
    host: OfxPropertySetHandle,
    name: *const c_char,
    version: c_int,
) -> *const c_void {
    let Some(now) = current() else {
        return std::ptr::null();
    };
    if host as usize != now.properties.handle() {
        now.misused("fetchSuite was given a handle that is not the host's".to_owned());
        return std::ptr::null();
    }
    // SAFETY: the plugin names the suite by a string.
    match unsafe { pointers::name(name) } {
        Some(name) => now.suite(name, version),
        None => {
            now.misused("fetchSuite was given a NULL name".to_owned());
            std::ptr::null()
        }
    }
}
