//! The interact suite, and overlays.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::draw_suite::kOfxInteractPropDrawContext;
use openfx::sys::image_effect_v1::interact::*;

use super::pointers::{found, put};
use crate::host::Host;
use crate::host::Object;
use crate::host::properties::{PropertySet, Value, interact};

/// An overlay: its descriptor or an instance.
pub(crate) struct Overlay {
    handle: OnceLock<usize>,
    pub(crate) properties: Arc<PropertySet>,
    pub(crate) redraws: AtomicUsize,
}

impl Overlay {
    /// Of an effect, 0 for a descriptor.
    pub(crate) fn new(host: &Host, effect: usize) -> Arc<Self> {
        let values = interact(effect);
        let overlay = Arc::new(Self {
            handle: OnceLock::new(),
            properties: host.property_set("overlay", "an overlay", values, false),
            redraws: AtomicUsize::new(0),
        });
        let handle = host.keep("an overlay", Object::Overlay(Arc::clone(&overlay)));
        let _ = overlay.handle.set(handle);
        // In this host it is what it draws in, too.
        (overlay.properties).put(kOfxInteractPropDrawContext, vec![Value::Pointer(handle)]);
        overlay
    }

    pub(crate) fn handle(&self) -> usize {
        self.handle.get().copied().unwrap_or(0)
    }

    /// Its handles are valid no longer.
    pub(crate) fn end(&self, host: &Host) {
        host.end(self.properties.handle());
        host.end(self.handle());
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
    found::<Overlay>(overlay as usize, "interactSwapBuffers")
        .err()
        .unwrap_or(kOfxStatOK)
}

unsafe extern "C" fn redraw(overlay: OfxInteractHandle) -> OfxStatus {
    match found::<Overlay>(overlay as usize, "interactRedraw") {
        Ok((_, overlay)) => {
            overlay.redraws.fetch_add(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn get_property_set(
    overlay: OfxInteractHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    match found::<Overlay>(overlay as usize, "interactGetPropertySet") {
        // SAFETY: the plugin gives room for a handle.
        Ok((_, overlay)) => unsafe {
            put(
                set,
                overlay.properties.handle() as *mut _,
                "interactGetPropertySet",
            )
        },
        Err(status) => status,
    }
}
