//! The plugin's overlay, driven by draw and pen actions.

use std::ffi::{CStr, c_char, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::draw_suite::kOfxInteractPropDrawContext;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::interact::*;

use super::arguments::{Arguments, at_time};
use super::{Instance, check_status};
use crate::host::action::{ActiveAction, within_action};
use crate::host::locked;
use crate::host::properties::{PropertySet, Value};
use crate::host::suites::{Drawing, Overlay};

/// The main entry point of an overlay.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct EntryPoint(
    unsafe extern "C" fn(
        *const c_char,
        *const c_void,
        OfxPropertySetHandle,
        OfxPropertySetHandle,
    ) -> OfxStatus,
);

impl EntryPoint {
    fn act(
        self,
        action: &CStr,
        overlay: &Overlay,
        in_args: Option<&PropertySet>,
    ) -> Result<(), String> {
        let in_args = in_args.map_or(0, PropertySet::handle);
        // SAFETY: handles are numbers that plugins only pass back.
        let status = within_action(Some(ActiveAction::new(action)), || unsafe {
            self.0(
                action.as_ptr(),
                overlay.handle() as *const c_void,
                in_args as *mut _,
                std::ptr::null_mut(),
            )
        });
        check_status(
            &format!("{} of the overlay", action.to_string_lossy()),
            status,
        )
    }
}

impl Instance<'_> {
    /// Draws the overlay and presses, moves and releases a pen at a position. Returns what was drawn, or nothing if
    /// the plugin has no overlay that uses the draw suite.
    ///
    /// # Errors
    /// If an action fails.
    pub fn use_overlay(&self, pen: (f64, f64)) -> Result<Option<Drawing>, String> {
        self.act_on_overlay(
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

    /// Draws the overlay only; otherwise like [`Self::use_overlay`].
    ///
    /// # Errors
    /// If an action fails.
    pub fn draw_overlay(&self) -> Result<Option<Drawing>, String> {
        self.act_on_overlay((0.0, 0.0), &[kOfxInteractActionDraw])
    }

    fn act_on_overlay(
        &self,
        pen: (f64, f64),
        actions: &[&CStr],
    ) -> Result<Option<Drawing>, String> {
        let host = self.loaded.host;
        let entry = (self.loaded.descriptor.properties)
            .pointer(kOfxImageEffectPluginPropOverlayInteractV2)
            .unwrap_or(0);
        if entry == 0 {
            return Ok(None);
        }
        // SAFETY: the property holds the address of such a function.
        let entry = unsafe { std::mem::transmute::<usize, EntryPoint>(entry) };
        let descriptor = Overlay::new(host, 0);
        entry.act(kOfxActionDescribe, &descriptor, None)?;
        let overlay = Overlay::new(host, self.effect.handle());
        entry.act(kOfxActionCreateInstance, &overlay, None)?;
        for action in actions {
            let in_args = self.overlay_arguments(&overlay, pen).in_args(host, action);
            let result = entry.act(action, &overlay, Some(&in_args));
            host.invalidate(in_args.handle());
            result?;
        }
        entry.act(kOfxActionDestroyInstance, &overlay, None)?;
        overlay.invalidate(host);
        descriptor.invalidate(host);
        Ok(Some(locked(&host.drawing).clone()))
    }

    fn overlay_arguments(&self, overlay: &Overlay, pen: (f64, f64)) -> Arguments {
        let pen = [pen.0, pen.1];
        at_time(0.0, (1.0, 1.0))
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
            .doubles(kOfxInteractPropPenPosition, &pen)
            .ints(kOfxInteractPropPenViewportPosition, &pen.map(|v| v as i32))
            .doubles(kOfxInteractPropPenPressure, &[1.0])
    }
}
