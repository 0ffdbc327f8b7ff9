//! The call of an action.

use super::{Effect, Host, PropertySet};
use crate::sys::Handle;
use crate::sys::property::TIME;

/// The call of an action by the host.
pub(crate) struct Call<'h> {
    pub(crate) host: &'h Host,
    pub(crate) effect: Effect<'h>,
    /// Input arguments of the action.
    pub(crate) arguments: PropertySet<'h>,
    /// Output arguments of the action.
    pub(crate) answers: PropertySet<'h>,
}

impl<'h> Call<'h> {
    /// Creates the call for the `effect` with the handles of its arguments, which may be NULL.
    pub(crate) fn new(host: &'h Host, effect: Handle, inputs: Handle, outputs: Handle) -> Self {
        Self {
            host,
            effect: Effect {
                host,
                handle: effect,
            },
            arguments: host.property_set(inputs),
            answers: host.property_set(outputs),
        }
    }

    /// Returns the time of the frame, 0 if the host does not give it.
    pub(crate) fn time(&self) -> f64 {
        self.arguments.double(TIME, 0).unwrap_or(0.0)
    }
}
