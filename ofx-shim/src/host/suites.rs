//! The suites of a host, fetched when the plugin is loaded.

use std::ffi::{CStr, c_int};

use super::PropertySet;
use crate::sys::draw::{self, OfxDrawSuiteV1};
use crate::sys::effect::{self, OfxImageEffectSuiteV1};
use crate::sys::interact::{self, OfxInteractSuiteV1};
use crate::sys::message::{self, Message, OfxMessageSuiteV1, OfxMessageSuiteV2};
use crate::sys::multi_thread::{self, OfxMultiThreadSuiteV1};
use crate::sys::param::{self, OfxParameterSuiteV1};
use crate::sys::property::{self, OfxPropertySuiteV1};
use crate::sys::{Handle, OfxHost, OfxStatus};

/// The environment variable that limits the plugin to version 1 of the required suites and of the message suite. Some
/// hosts end the process when a plugin requests a suite that they lack.
const MINIMAL_VARIABLE: &str = "SEIDEL_OFX_MINIMAL";

/// Name of openfx-runner, which is such a host.
const RUNNER: &str = "openfx-driver";

/// The functions of the message suite, of either version.
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

/// Fetches a suite, or returns `None` if `host` does not have it.
///
/// # Safety
/// `T` must be the struct of that suite and version.
unsafe fn fetch<T: Copy>(host: &OfxHost, name: &CStr, version: c_int) -> Option<T> {
    let fetch = host.fetch_suite?;
    // SAFETY: a function and a handle of the host.
    let suite = unsafe { fetch(host.host, name.as_ptr(), version) };
    // SAFETY: a suite that is not NULL points to the struct of its name and version.
    (!suite.is_null()).then(|| unsafe { suite.cast::<T>().read() })
}

impl Suites {
    /// Fetches all suites of `host`.
    ///
    /// # Errors
    /// The name of a required suite that the host does not have.
    ///
    /// # Safety
    /// `host` must be what a host passed to `OfxSetHost` or `setHost`.
    pub(crate) unsafe fn fetch_all(host: &OfxHost) -> Result<Self, &'static CStr> {
        // SAFETY: each struct is fetched by its name and version, here and below.
        unsafe {
            let property = fetch(host, property::SUITE, 1).ok_or(property::SUITE)?;
            let name = PropertySet::new(&property, host.host).string(property::NAME, 0);
            let is_minimal =
                std::env::var_os(MINIMAL_VARIABLE).is_some() || name.as_deref() == Some(RUNNER);
            let mut suites = Self {
                property,
                effect: fetch(host, effect::SUITE, 1).ok_or(effect::SUITE)?,
                param: fetch(host, param::SUITE, 1).ok_or(param::SUITE)?,
                messages: Messages::default(),
                multi_thread: None,
                interact: None,
                draw: None,
            };
            let mut messages: Option<OfxMessageSuiteV2> = None;
            if !is_minimal {
                messages = fetch(host, message::SUITE, 2);
                suites.multi_thread = fetch(host, multi_thread::SUITE, 1);
                suites.interact = fetch(host, interact::SUITE, 1);
                suites.draw = fetch(host, draw::SUITE, 1);
            }
            suites.messages = match messages {
                Some(suite) => Messages {
                    message: suite.message,
                    set_persistent: suite.set_persistent,
                    clear_persistent: suite.clear_persistent,
                },
                None => Messages {
                    message: fetch::<OfxMessageSuiteV1>(host, message::SUITE, 1)
                        .and_then(|suite| suite.message),
                    ..Messages::default()
                },
            };
            Ok(suites)
        }
    }
}
