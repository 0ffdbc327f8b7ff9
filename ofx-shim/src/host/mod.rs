//! The host behind safe names: its suites as far as it has them, and what they give.
//!
//! Whatever a host lacks is nothing, never an error: hosts of every age leave out properties and functions.

mod caught;
mod effect;
mod image;
mod message;
mod params;
mod props;
mod suites;
mod this;
mod threads;

pub(crate) use caught::{caught, last_panic};
pub(crate) use effect::{Clip, Effect};
pub(crate) use image::Image;
pub(crate) use message::{clear, inform, log, tell};
pub(crate) use params::{Params, Value};
pub(crate) use props::Props;
pub(crate) use suites::Suites;
pub(crate) use this::{Host, current, loaded, set, unloaded};

use crate::sys::OfxStatus;
use crate::sys::plugin::{STATUS_ERR_MEMORY, STATUS_FAILED};

/// Why an action is not done: what the host is answered, and what the user is told.
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
