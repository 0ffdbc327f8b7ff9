//! Effects and their clips.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use super::{Failure, Host, Image, ParameterSet, PropertySet, Result};
use crate::sys::clip::{CONNECTED, PIXEL_ASPECT};
use crate::sys::plugin::{STATUS_ERR_MEMORY, STATUS_OK};
use crate::sys::{Handle, OfxRectD};

/// An effect: a descriptor or an instance.
#[derive(Clone, Copy)]
pub(crate) struct Effect<'h> {
    pub(crate) host: &'h Host,
    pub(crate) handle: Handle,
}

/// A clip of an instance.
#[derive(Clone, Copy)]
pub(crate) struct Clip<'h> {
    host: &'h Host,
    handle: Handle,
    pub(crate) properties: PropertySet<'h>,
}

impl<'h> Effect<'h> {
    /// Returns its properties.
    pub(crate) fn properties(&self) -> PropertySet<'h> {
        let mut set = null_mut();
        if let Some(get) = self.host.suites.effect.property_set {
            // SAFETY: a function and a handle of the host, and memory for a handle; so in all calls of this file.
            if unsafe { get(self.handle, &raw mut set) } != STATUS_OK {
                set = null_mut();
            }
        }
        self.host.property_set(set)
    }

    /// Returns its parameters.
    pub(crate) fn parameters(&self) -> ParameterSet<'h> {
        let mut set = null_mut();
        if let Some(get) = self.host.suites.effect.param_set {
            // SAFETY: as above.
            if unsafe { get(self.handle, &raw mut set) } != STATUS_OK {
                set = null_mut();
            }
        }
        ParameterSet::new(self.host, set)
    }

    /// Defines a clip of a descriptor and returns its properties.
    pub(crate) fn define_clip(&self, name: &CStr) -> Option<PropertySet<'h>> {
        let mut set = null_mut();
        let define = self.host.suites.effect.clip_define?;
        // SAFETY: as above.
        let status = unsafe { define(self.handle, name.as_ptr(), &raw mut set) };
        (status == STATUS_OK).then(|| self.host.property_set(set))
    }

    /// Returns a clip of an instance, or `None` if its context has no clip of that name.
    pub(crate) fn clip(&self, name: &CStr) -> Option<Clip<'h>> {
        let (mut clip, mut set) = (null_mut(), null_mut());
        let get = self.host.suites.effect.clip_handle?;
        // SAFETY: as above.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut clip, &raw mut set) };
        if status != STATUS_OK || clip.is_null() {
            return None;
        }
        Some(Clip {
            host: self.host,
            handle: clip,
            properties: self.host.property_set(set),
        })
    }

    /// Returns whether the host wants the action to stop.
    pub(crate) fn is_aborted(&self) -> bool {
        let abort = self.host.suites.effect.abort;
        // SAFETY: as above.
        abort.is_some_and(|abort| unsafe { abort(self.handle) } != 0)
    }
}

impl<'h> Clip<'h> {
    /// Returns whether the host reports the clip as connected.
    pub(crate) fn is_connected(&self) -> bool {
        self.properties.int(CONNECTED, 0).unwrap_or(0) != 0
    }

    /// Returns the width of its pixels over their height.
    pub(crate) fn pixel_aspect(&self) -> Option<f64> {
        let aspect = self.properties.double(PIXEL_ASPECT, 0)?;
        (aspect.is_finite() && aspect > 0.0).then_some(aspect)
    }

    /// Returns its region of definition in canonical coordinates.
    pub(crate) fn region_of_definition(&self, time: f64) -> Option<OfxRectD> {
        let get = self.host.suites.effect.clip_region_of_definition?;
        let mut region = OfxRectD::default();
        // SAFETY: as above, with memory for a rectangle.
        let status = unsafe { get(self.handle, time, &raw mut region) };
        (status == STATUS_OK).then_some(region)
    }

    /// Returns its image at a time, or `None` if it has none, which counts as transparent black.
    ///
    /// # Errors
    /// An image with a sample type or components that the plugin does not support; a host out of memory.
    pub(crate) fn image(&self, time: f64) -> Result<Option<Image<'h>>> {
        let Some(get) = self.host.suites.effect.clip_image else {
            return Ok(None);
        };
        let mut image = null_mut();
        // SAFETY: as above; a NULL region requests what the render needs.
        let status = unsafe { get(self.handle, time, null(), &raw mut image) };
        if status == STATUS_ERR_MEMORY {
            let text = "The host has no memory for an image; render at a lower resolution.";
            return Err(Failure::memory(text));
        }
        if status != STATUS_OK || image.is_null() {
            return Ok(None);
        }
        Image::new(self.host, image)
    }
}
