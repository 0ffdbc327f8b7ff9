//! The actions under way on each thread. They decide which suite calls are allowed.

use std::cell::RefCell;
use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::images::ActiveRender;

/// An action that the host has called and that has not returned.
#[derive(Clone)]
pub(crate) struct ActiveAction {
    pub(crate) name: String,
    pub(crate) render: Option<Arc<ActiveRender>>,
}

impl ActiveAction {
    /// Creates an action that belongs to no render.
    pub(crate) fn new(name: &CStr) -> Self {
        Self {
            name: name.to_string_lossy().into_owned(),
            render: None,
        }
    }

    /// Returns whether it is this action.
    pub(crate) fn is(&self, action: &CStr) -> bool {
        self.name.as_bytes() == action.to_bytes()
    }

    fn is_any_of(&self, actions: &[&CStr]) -> bool {
        actions.iter().any(|action| self.is(action))
    }

    /// Returns whether hosts may call it on render threads, where parameters are read at a time and never set.
    pub(crate) fn is_render_action(&self) -> bool {
        self.is_any_of(&[
            kOfxImageEffectActionRender,
            kOfxImageEffectActionBeginSequenceRender,
            kOfxImageEffectActionEndSequenceRender,
            kOfxImageEffectActionIsIdentity,
            kOfxImageEffectActionGetFramesNeeded,
            kOfxImageEffectActionGetRegionOfDefinition,
            kOfxImageEffectActionGetRegionsOfInterest,
        ])
    }

    /// Returns whether the plugin may set parameters in it.
    pub(crate) fn allows_edits(&self) -> bool {
        self.is_any_of(&[
            kOfxActionInstanceChanged,
            kOfxActionBeginInstanceChanged,
            kOfxActionEndInstanceChanged,
            kOfxActionSyncPrivateData,
            kOfxActionBeginInstanceEdit,
            kOfxActionEndInstanceEdit,
        ]) || self.name.starts_with("OfxInteractAction")
    }

    /// Returns whether the plugin may fetch images in it.
    pub(crate) fn allows_images(&self) -> bool {
        self.is(kOfxImageEffectActionRender) || self.allows_edits()
    }

    /// Returns whether the plugin may define clips and parameters in it.
    pub(crate) fn allows_definitions(&self) -> bool {
        self.is_any_of(&[kOfxImageEffectActionDescribeInContext, kOfxActionDescribe])
    }
}

thread_local! {
    static STACK: RefCell<Vec<ActiveAction>> = const { RefCell::new(Vec::new()) };
}

/// Returns the innermost action on this thread, or nothing on the plugin's own threads.
pub(crate) fn current_action() -> Option<ActiveAction> {
    STACK.with_borrow(|stack| stack.last().cloned())
}

/// Runs `work` as part of `action`.
pub(crate) fn within_action<T>(action: Option<ActiveAction>, work: impl FnOnce() -> T) -> T {
    let Some(action) = action else {
        return work();
    };
    STACK.with_borrow_mut(|stack| stack.push(action));
    let result = work();
    STACK.with_borrow_mut(|stack| stack.pop());
    result
}
