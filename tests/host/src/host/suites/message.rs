//! The message suite, both versions.

use std::ffi::{CStr, c_char, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::message::*;

use super::pointers::text;
use super::variadic;
use crate::host::{Host, Message, current, locked, under};

pub(super) fn first() -> OfxMessageSuiteV1 {
    OfxMessageSuiteV1 {
        message: variadic::message(),
    }
}

pub(super) fn second(clear_is_garbage: bool) -> OfxMessageSuiteV2 {
    OfxMessageSuiteV2 {
        message: variadic::message(),
        setPersistentMessage: variadic::persistent_message(),
        clearPersistentMessage: Some(if clear_is_garbage { garbage } else { clear }),
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

/// What `message` and `setPersistentMessage` do; `argument` is the first one after the format.
///
/// # Safety
/// The pointers must be NULL or strings, and so must the argument if the format is `%s`.
pub(super) unsafe fn said(
    kind: *const c_char,
    format: *const c_char,
    argument: usize,
    persistent: bool,
) -> OfxStatus {
    let Some(host) = current() else {
        return kOfxStatFailed;
    };
    at_the_end(&host, "a message was given");
    // SAFETY: by the caller's word.
    let (kind, format) = unsafe { (text(kind), text(format)) };
    if !KINDS
        .iter()
        .any(|known| known.to_bytes() == kind.as_bytes())
    {
        host.misused(format!(
            "a message of type {kind:?}, which OpenFX does not have"
        ));
    }
    let mut message = Message {
        kind,
        text: String::new(),
        persistent,
        format,
    };
    if message.format == "%s" {
        if argument == 0 {
            host.misused("a message with %s and NULL".to_owned());
        } else {
            // SAFETY: by the caller's word.
            message.text = unsafe { text(argument as *const c_char) };
        }
    } else {
        host.misused(format!(
            "a message with the format {:?}: what it says must go through \"%s\"",
            message.format
        ));
    }
    let question = message.kind.as_bytes() == kOfxMessageQuestion.to_bytes();
    if persistent {
        *locked(&host.persistent) = Some(message.clone());
    }
    locked(&host.messages).push(message);
    if question {
        kOfxStatReplyNo
    } else {
        kOfxStatOK
    }
}

/// Messages of an instance that is being destroyed end the process in hosts on HostSupport: the part of it that would
/// take them is gone (`OFX::Host::ImageEffect::Instance::~Instance` calls the action).
fn at_the_end(host: &Host, what: &str) {
    if under::now().is_some_and(|under| under.destroys()) {
        host.misused(format!("{what} in DestroyInstance"));
    }
}

unsafe extern "C" fn clear(_effect: *mut c_void) -> OfxStatus {
    let Some(host) = current() else {
        return kOfxStatFailed;
    };
    at_the_end(&host, "clearPersistentMessage was called");
    *locked(&host.persistent) = None;
    kOfxStatOK
}

unsafe extern "C" fn garbage(_effect: *mut c_void) -> OfxStatus {
    if let Some(host) = current() {
        host.misused(
            "clearPersistentMessage was called, which points to nowhere in this kind of host"
                .to_owned(),
        );
    }
    kOfxStatFailed
}
