//! What the host is doing on each thread: which action it called, for which render.

use std::cell::RefCell;
use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::images::Rendering;

/// An action under way.
#[derive(Clone)]
pub(crate) struct Under {
    pub(crate) action: String,
    pub(crate) rendering: Option<Arc<Rendering>>,
}

impl Under {
    fn is(&self, actions: &[&CStr]) -> bool {
        (actions.iter()).any(|action| action.to_bytes() == self.action.as_bytes())
    }

    /// Whether it may be called on threads that render.
    pub(crate) fn renders(&self) -> bool {
        self.is(&[
            kOfxImageEffectActionRender,
            kOfxImageEffectActionBeginSequenceRender,
            kOfxImageEffectActionEndSequenceRender,
            kOfxImageEffectActionIsIdentity,
            kOfxImageEffectActionGetFramesNeeded,
            kOfxImageEffectActionGetRegionOfDefinition,
            kOfxImageEffectActionGetRegionsOfInterest,
        ])
    }

    /// Whether parameters may be set in it; those of overlays are not here.
    pub(crate) fn edits(&self) -> bool {
        self.is(&[
            kOfxActionInstanceChanged,
            kOfxActionBeginInstanceChanged,
            kOfxActionEndInstanceChanged,
            kOfxActionSyncPrivateData,
            kOfxActionBeginInstanceEdit,
            kOfxActionEndInstanceEdit,
        ]) || self.action.starts_with("OfxInteractAction")
    }

    /// Whether images may be fetched in it.
    pub(crate) fn fetches(&self) -> bool {
        self.is(&[kOfxImageEffectActionRender]) || self.edits()
    }

    /// Whether it asks what is needed of inputs.
    pub(crate) fn needs(&self) -> bool {
        self.is(&[kOfxImageEffectActionGetRegionsOfInterest])
    }

    /// Whether the host is done with the instance: in hosts on HostSupport what would answer for it is gone already.
    pub(crate) fn destroys(&self) -> bool {
        self.is(&[kOfxActionDestroyInstance])
    }

    /// Whether clips and parameters may be defined in it.
    pub(crate) fn defines(&self) -> bool {
        self.is(&[kOfxImageEffectActionDescribeInContext, kOfxActionDescribe])
    }
}

thread_local! {
    static STACK: RefCell<Vec<Under>> = const { RefCell::new(Vec::new()) };
}

/// The action under way on this thread, nothing on threads of the plugin's own.
pub(crate) fn now() -> Option<Under> {
    STACK.with_borrow(|stack| stack.last().cloned())
}

/// Does `work` as part of an action.
pub(crate) fn doing<T>(under: Option<Under>, work: impl FnOnce() -> T) -> T {
    let Some(under) = under else {
        return work();
    };
    STACK.with_borrow_mut(|stack| stack.push(under));
    let done = work();
    STACK.with_borrow_mut(|stack| stack.pop());
    done
}
