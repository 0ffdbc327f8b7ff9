//! Effects and their clips.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use super::{Failure, Host, Image, Params, Props, Result};
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
    pub(crate) props: Props<'h>,
}

impl<'h> Effect<'h> {
    /// Properties.
    pub(crate) fn props(&self) -> Props<'h> {
        let mut props = null_mut();
        if let Some(get) = self.host.suites.effect.property_set {
            // SAFETY: the host vouches for its function and its handle.
            if unsafe { get(self.handle, &raw mut props) } != STATUS_OK {
                props = null_mut();
            }
        }
        Props::of(&self.host.suites.property, props)
    }

    /// Parameters.
    pub(crate) fn params(&self) -> Params<'h> {
        let mut params = null_mut();
        if let Some(get) = self.host.suites.effect.param_set {
            // SAFETY: as above.
            if unsafe { get(self.handle, &raw mut params) } != STATUS_OK {
                params = null_mut();
            }
        }
        Params::of(self.host, params)
    }

    /// Declares a clip and gives its properties.
    pub(crate) fn define_clip(&self, name: &CStr) -> Option<Props<'h>> {
        let mut props = null_mut();
        let define = self.host.suites.effect.clip_define?;
        // SAFETY: as above.
        let status = unsafe { define(self.handle, name.as_ptr(), &raw mut props) };
        (status == STATUS_OK).then(|| Props::of(&self.host.suites.property, props))
    }

    /// A clip of the instance; nothing where its context has none of that name.
    pub(crate) fn clip(&self, name: &CStr) -> Option<Clip<'h>> {
        let (mut clip, mut props) = (null_mut(), null_mut());
        let get = self.host.suites.effect.clip_handle?;
        // SAFETY: as above.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut clip, &raw mut props) };
        if status != STATUS_OK || clip.is_null() {
            return None;
        }
        Some(Clip {
            host: self.host,
            handle: clip,
            props: Props::of(&self.host.suites.property, props),
        })
    }

    /// Whether the host wants no result any more.
    pub(crate) fn is_aborted(&self) -> bool {
        let abort = self.host.suites.effect.abort;
        // SAFETY: as above.
        abort.is_some_and(|abort| unsafe { abort(self.handle) } != 0)
    }
}

impl<'h> Clip<'h> {
    /// Whether the host says that something is connected.
    pub(crate) fn is_connected(&self) -> bool {
        self.props.int(CONNECTED, 0).unwrap_or(0) != 0
    }

    /// Width of its pixels over their height.
    pub(crate) fn pixel_aspect(&self) -> Option<f64> {
        let aspect = self.props.double(PIXEL_ASPECT, 0)?;
        (aspect.is_finite() && aspect > 0.0).then_some(aspect)
    }

    /// How large its pictures are, canonical.
    pub(crate) fn region_of_definition(&self, time: f64) -> Option<OfxRectD> {
        let get = self.host.suites.effect.clip_region_of_definition?;
        let mut rod = OfxRectD::default();
        // SAFETY: as above.
        let status = unsafe { get(self.handle, time, &raw mut rod) };
        (status == STATUS_OK).then_some(rod)
    }

    /// Its picture at a time; nothing where there is none, which counts as transparent black.
    ///
    /// # Errors
    /// A picture of samples or channels that were not agreed upon; memory that ran out.
    pub(crate) fn image(&self, time: f64) -> Result<Option<Image<'h>>> {
        let Some(get) = self.host.suites.effect.clip_image else {
            return Ok(None);
        };
        let mut image = null_mut();
        // SAFETY: as above; a NULL region asks for what the render needs.
        let status = unsafe { get(self.handle, time, null(), &raw mut image) };
        if status == STATUS_ERR_MEMORY {
            let text = "The host has no memory for a picture; render at a lower resolution.";
            return Err(Failure::memory(text));
        }
        if status != STATUS_OK || image.is_null() {
            return Ok(None);
        }
        Image::of(self.host, image)
    }
}
