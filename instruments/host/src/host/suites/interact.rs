//! The interact suite, and overlays.

use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::draw_suite::kOfxInteractPropDrawContext;
use openfx::sys::image_effect_v1::interact::*;

use super::pointers::{with_object, write_result};
use crate::host::properties::{PropertySet, Schema, Value, interact};
use crate::host::{Host, Object, OwnHandle};

/// An overlay: a descriptor or an instance.
pub(crate) struct Overlay {
    handle: OwnHandle,
    pub(crate) properties: Arc<PropertySet>,
}

impl Overlay {
    /// Creates an overlay of the effect with this handle, 0 for a descriptor.
    pub(crate) fn new(host: &Host, effect: usize) -> Arc<Self> {
        let overlay = Arc::new(Self {
            handle: OwnHandle::default(),
            properties: host.property_set("overlay", "an overlay", interact(effect), Schema::Fixed),
        });
        let handle = host.register("an overlay", Object::Overlay(Arc::clone(&overlay)));
        overlay.handle.set(handle);
        // This host uses one handle for an overlay and its draw context.
        (overlay.properties).put(kOfxInteractPropDrawContext, vec![Value::Pointer(handle)]);
        overlay
    }

    pub(crate) fn handle(&self) -> usize {
        self.handle.get()
    }

    /// Invalidates its handles.
    pub(crate) fn invalidate(&self, host: &Host) {
        host.invalidate(self.properties.handle());
        host.invalidate(self.handle());
    }
}

pub(super) fn suite() -> OfxInteractSuiteV1 {
    OfxInteractSuiteV1 {
        interactSwapBuffers: Some(swap_buffers),
        interactRedraw: Some(redraw),
        interactGetPropertySet: Some(get_property_set),
    }
}

unsafe extern "C" fn swap_buffers(overlay: OfxInteractHandle) -> OfxStatus {
    with_object::<Overlay>(overlay as usize, "interactSwapBuffers", |_, _| kOfxStatOK)
}

unsafe extern "C" fn redraw(overlay: OfxInteractHandle) -> OfxStatus {
    with_object::<Overlay>(overlay as usize, "interactRedraw", |_, _| kOfxStatOK)
}

unsafe extern "C" fn get_property_set(
    overlay: OfxInteractHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let call = "interactGetPropertySet";
    with_object::<Overlay>(overlay as usize, call, |_, overlay| {
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(set, overlay.properties.handle() as *mut _, call) }
    })
}
