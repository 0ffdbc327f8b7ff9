//! The plugin's overlay, if it has one, driven by a draw and a pen.

use std::ffi::{CStr, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::draw_suite::kOfxInteractPropDrawContext;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::interact::*;

use super::arguments::Arguments;
use super::{Instance, status_name};
use crate::host::locked;
use crate::host::properties::{PropertySet, Value};
use crate::host::suites::{Overlay, Strokes};
use crate::host::under::{Under, doing};

type Entry = unsafe extern "C" fn(
    *const std::ffi::c_char,
    *const c_void,
    OfxPropertySetHandle,
    OfxPropertySetHandle,
) -> OfxStatus;

impl Instance<'_> {
    /// Describes, creates, draws, moves and presses a pen at a place, and destroys; nothing if there is no overlay
    /// that draws through the draw suite.
    ///
    /// # Errors
    /// If an action fails.
    pub fn overlay(&self, pen: (f64, f64)) -> Result<Option<Strokes>, String> {
        self.overlaid(
            pen,
            &[
                kOfxInteractActionGainFocus,
                kOfxInteractActionDraw,
                kOfxInteractActionPenMotion,
                kOfxInteractActionPenDown,
                kOfxInteractActionPenMotion,
                kOfxInteractActionPenUp,
                kOfxInteractActionDraw,
                kOfxInteractActionLoseFocus,
            ],
        )
    }

    /// As `overlay`, but draws alone.
    ///
    /// # Errors
    /// If an action fails.
    pub fn overlay_alone(&self) -> Result<Option<Strokes>, String> {
        self.overlaid((0.0, 0.0), &[kOfxInteractActionDraw])
    }

    fn overlaid(&self, pen: (f64, f64), actions: &[&CStr]) -> Result<Option<Strokes>, String> {
        let host = self.loaded.host;
        let descriptor = &self.loaded.descriptor.properties;
        let entry = descriptor
            .pointer(kOfxImageEffectPluginPropOverlayInteractV2)
            .unwrap_or(0);
        if entry == 0 {
            return Ok(None);
        }
        // SAFETY: the property holds an entry point.
        let entry = unsafe { std::mem::transmute::<usize, Entry>(entry) };
        let call = |action: &CStr, overlay: &Overlay, given: Option<&PropertySet>| {
            let under = Under {
                action: action.to_string_lossy().into_owned(),
                rendering: None,
            };
            let given = given.map_or(0, PropertySet::handle);
            // SAFETY: handles are never followed, only handed back.
            let status = doing(Some(under), || unsafe {
                entry(
                    action.as_ptr(),
                    overlay.handle() as *const c_void,
                    given as *mut _,
                    std::ptr::null_mut(),
                )
            });
            if status == kOfxStatOK || status == kOfxStatReplyDefault {
                Ok(())
            } else {
                let action = action.to_string_lossy();
                Err(format!(
                    "{action} of the overlay gave {}",
                    status_name(status)
                ))
            }
        };
        let described = Overlay::new(host, 0);
        call(kOfxActionDescribe, &described, None)?;
        let overlay = Overlay::new(host, self.effect.handle());
        call(kOfxActionCreateInstance, &overlay, None)?;
        let arguments = |action: &CStr| {
            let pen = [pen.0, pen.1];
            Arguments::default()
                .with(
                    kOfxPropEffectInstance,
                    vec![Value::Pointer(self.effect.handle())],
                )
                .with(
                    kOfxInteractPropDrawContext,
                    vec![Value::Pointer(overlay.handle())],
                )
                .doubles(kOfxInteractPropPixelScale, &[1.0, 1.0])
                .doubles(kOfxInteractPropBackgroundColour, &[0.0, 0.0, 0.0])
                .doubles(kOfxPropTime, &[0.0])
                .doubles(kOfxImageEffectPropRenderScale, &[1.0, 1.0])
                .doubles(kOfxInteractPropPenPosition, &pen)
                .ints(kOfxInteractPropPenViewportPosition, &pen.map(|v| v as i32))
                .doubles(kOfxInteractPropPenPressure, &[1.0])
                .known(host, false, action)
        };
        for action in actions {
            let given = arguments(action);
            let done = call(action, &overlay, Some(&given));
            host.end(given.handle());
            done?;
        }
        call(kOfxActionDestroyInstance, &overlay, None)?;
        overlay.end(host);
        described.end(host);
        Ok(Some(locked(&host.strokes).clone()))
    }
}
