//! A safe interface to the host: its suites and the objects that they return.
//!
//! Hosts of every age leave out properties and functions. A getter whose property or function is missing returns `None`,
//! and a setter does nothing.

mod call;
mod effect;
mod image;
mod loaded_host;
mod message;
mod panic_guard;
mod parameter_set;
mod property_set;
mod samples;
mod suites;

pub(crate) use call::Call;
pub(crate) use effect::{Clip, Effect};
pub(crate) use image::Image;
pub(crate) use loaded_host::{Host, current, load, set_host, unload};
pub(crate) use message::{
    clear_message, log, show_error, show_information, show_note, show_warning,
};
pub(crate) use panic_guard::catch_panic;
pub(crate) use parameter_set::{Change, ParameterSet, ParameterValue};
pub(crate) use property_set::PropertySet;
pub(crate) use samples::Samples;
pub(crate) use suites::Suites;

use crate::sys::OfxStatus;
use crate::sys::plugin::{STATUS_ERR_MEMORY, STATUS_FAILED};

/// A failed action: the status for the host and the message for the user.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Failure {
    pub(crate) status: OfxStatus,
    pub(crate) text: String,
}

pub(crate) type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    pub(crate) fn new(status: OfxStatus, text: impl Into<String>) -> Self {
        Self {
            status,
            text: text.into(),
        }
    }

    pub(crate) fn failed(text: impl Into<String>) -> Self {
        Self::new(STATUS_FAILED, text)
    }

    pub(crate) fn memory(text: impl Into<String>) -> Self {
        Self::new(STATUS_ERR_MEMORY, text)
    }
}
