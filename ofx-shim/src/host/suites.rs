//! The suites of a host, fetched when the plugin is loaded.

use std::ffi::{CStr, c_int};

use super::Props;
use crate::sys::draw::{self, OfxDrawSuiteV1};
use crate::sys::effect::{self, OfxImageEffectSuiteV1};
use crate::sys::interact::{self, OfxInteractSuiteV1};
use crate::sys::message::{self, Message, OfxMessageSuiteV1, OfxMessageSuiteV2};
use crate::sys::multi_thread::{self, OfxMultiThreadSuiteV1};
use crate::sys::param::{self, OfxParameterSuiteV1};
use crate::sys::property::{self, OfxPropertySuiteV1};
use crate::sys::{Handle, OfxHost, OfxStatus};

/// Where this is set only version 1 of the suites that nothing goes without, and of messages, is asked for: some hosts
/// end the process when they are asked for what they lack.
const MINIMAL: &str = "SEIDEL_OFX_MINIMAL";

/// A host that does so: openfx-runner.
const RUNNER: &str = "openfx-driver";

/// How to say things.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Messages {
    pub(crate) message: Message,
    pub(crate) set_persistent: Message,
    pub(crate) clear_persistent: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
}

/// The suites of a host.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Suites {
    pub(crate) property: OfxPropertySuiteV1,
    pub(crate) effect: OfxImageEffectSuiteV1,
    pub(crate) param: OfxParameterSuiteV1,
    pub(crate) messages: Messages,
    pub(crate) multi_thread: Option<OfxMultiThreadSuiteV1>,
    pub(crate) interact: Option<OfxInteractSuiteV1>,
    pub(crate) draw: Option<OfxDrawSuiteV1>,
}

/// A suite of `host`, nothing where it has none.
///
/// # Safety
/// `T` must be the struct of that suite and version, and `host` a host.
unsafe fn fetched<T: Copy>(host: &OfxHost, name: &CStr, version: c_int) -> Option<T> {
    let fetch = host.fetch_suite?;
    // SAFETY: the host vouches for its function.
    let suite = unsafe { fetch(host.host, name.as_ptr(), version) };
    // SAFETY: a suite that is not NULL is the struct of its name and version.
    (!suite.is_null()).then(|| unsafe { suite.cast::<T>().read() })
}

impl Suites {
    /// Those of `host`; the name of one that nothing can be done without where it is missing.
    ///
    /// # Safety
    /// `host` must be what a host handed in as itself.
    pub(crate) unsafe fn of(host: &OfxHost) -> Result<Self, &'static CStr> {
        // SAFETY: each is asked for by its name and version, here and below.
        unsafe {
            let property = fetched(host, property::SUITE, 1).ok_or(property::SUITE)?;
            let name = Props::of(&property, host.host).string(property::NAME, 0);
            let minimal = std::env::var_os(MINIMAL).is_some() || name.as_deref() == Some(RUNNER);
            let v2: Option<OfxMessageSuiteV2> = match minimal {
                true => None,
                false => fetched(host, message::SUITE, 2),
            };
            let messages = match v2 {
                Some(v2) => Messages {
                    message: v2.message,
                    set_persistent: v2.set_persistent,
                    clear_persistent: v2.clear_persistent,
                },
                None => Messages {
                    message: fetched::<OfxMessageSuiteV1>(host, message::SUITE, 1)
                        .and_then(|v1| v1.message),
                    ..Messages::default()
                },
            };
            Ok(Self {
                property,
                effect: fetched(host, effect::SUITE, 1).ok_or(effect::SUITE)?,
                param: fetched(host, param::SUITE, 1).ok_or(param::SUITE)?,
                messages,
                multi_thread: maybe(!minimal, || fetched(host, multi_thread::SUITE, 1)),
                interact: maybe(!minimal, || fetched(host, interact::SUITE, 1)),
                draw: maybe(!minimal, || fetched(host, draw::SUITE, 1)),
            })
        }
    }
}

fn maybe<T>(wanted: bool, fetch: impl FnOnce() -> Option<T>) -> Option<T> {
    if wanted { fetch() } else { None }
}
