//! Both versions of the message suite.

use std::ffi::{CStr, c_char, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::message::*;

use super::pointers::{string, with_host};
use super::variadic;
use crate::host::action::current_action;
use crate::host::{Host, Message, locked};

pub(super) fn suite_v1() -> OfxMessageSuiteV1 {
    OfxMessageSuiteV1 {
        message: variadic::message(),
    }
}

/// Returns version 2, in which `clear` is `clearPersistentMessage`.
pub(super) fn suite_v2(clear: unsafe extern "C" fn(*mut c_void) -> OfxStatus) -> OfxMessageSuiteV2 {
    OfxMessageSuiteV2 {
        message: variadic::message(),
        setPersistentMessage: variadic::persistent_message(),
        clearPersistentMessage: Some(clear),
    }
}

const KINDS: [&CStr; 6] = [
    kOfxMessageFatal,
    kOfxMessageError,
    kOfxMessageWarning,
    kOfxMessageMessage,
    kOfxMessageLog,
    kOfxMessageQuestion,
];

/// The time for which a message is shown.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Duration {
    /// Once: `message`.
    Transient,
    /// Until it is cleared: `setPersistentMessage`.
    Persistent,
}

/// Records a message. `argument` is the first variadic argument.
///
/// # Safety
/// The pointers must be NULL or strings, and so must the argument if the format is `%s`.
pub(super) unsafe fn post(
    kind: *const c_char,
    format: *const c_char,
    argument: usize,
    duration: Duration,
) -> OfxStatus {
    with_host(|host| {
        check_not_in_destroy(host, "a message was posted");
        // SAFETY: guaranteed by the caller.
        let (kind, format) = unsafe { (string(kind), string(format)) };
        if !KINDS
            .iter()
            .any(|known| known.to_bytes() == kind.as_bytes())
        {
            host.record_misuse(format!(
                "a message has the type {kind:?}, which OpenFX does not define"
            ));
        }
        let mut text = String::new();
        if format == "%s" && argument == 0 {
            host.record_misuse("a message has the format \"%s\" and a NULL argument");
        } else if format == "%s" && host.profile.blank_message_arguments {
            text.push(' ');
        } else if format == "%s" {
            // SAFETY: guaranteed by the caller.
            text = unsafe { string(argument as *const c_char) };
        } else if format.replace("%%", "").contains('%') {
            host.record_misuse(format!(
                "a message has the format {format:?}; double each % of its text"
            ));
        } else {
            text = format.replace("%%", "%");
        }
        let is_question = kind.as_bytes() == kOfxMessageQuestion.to_bytes();
        let message = Message {
            kind,
            format,
            text,
            persistent: duration == Duration::Persistent,
        };
        if message.persistent {
            *locked(&host.persistent) = Some(message.clone());
        }
        locked(&host.messages).push(message);
        if is_question {
            kOfxStatReplyNo
        } else {
            kOfxStatOK
        }
    })
}

/// Records misuse during DestroyInstance. Hosts on HostSupport crash there, because
/// `OFX::Host::ImageEffect::Instance::~Instance` calls the action after the message handler is gone.
fn check_not_in_destroy(host: &Host, call: &str) {
    if current_action().is_some_and(|action| action.is(kOfxActionDestroyInstance)) {
        host.record_misuse(format!("{call} in DestroyInstance"));
    }
}

/// Implements `clearPersistentMessage`.
pub(super) unsafe extern "C" fn clear(_effect: *mut c_void) -> OfxStatus {
    with_host(|host| {
        check_not_in_destroy(host, "clearPersistentMessage was called");
        *locked(&host.persistent) = None;
        kOfxStatOK
    })
}

/// Stands in for an invalid function pointer: every call is misuse.
pub(super) unsafe extern "C" fn invalid_clear(_effect: *mut c_void) -> OfxStatus {
    with_host(|host| {
        host.record_misuse(
            "clearPersistentMessage was called, which is an invalid pointer in this kind of host",
        );
        kOfxStatFailed
    })
}
