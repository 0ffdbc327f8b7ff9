//! One frame rendered, whole or in tiles, and everything looked at afterwards.

use std::ffi::CStr;
use std::sync::{Arc, Mutex};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::arguments::{of_render, of_sequence};
use super::{Instance, act, status_name};
use crate::host::images::{Buffer, Rendering, left_out};
use crate::host::locked;
use crate::host::profile::Rows;
use crate::host::properties::Value;
use crate::picture::{Picture, Rect};

/// What is to be rendered, and how images lie.
#[derive(Clone, Debug)]
pub struct Request {
    /// The time.
    pub time: f64,
    /// The render scale.
    pub scale: (f64, f64),
    /// The pixels; nothing: all that Output has.
    pub window: Option<Rect>,
    /// Rendered one by one in this order, instead of the window at once.
    pub tiles: Vec<Rect>,
    /// How rows lie; nothing: as the kind of host has it.
    pub rows: Option<Rows>,
    /// Whether inputs are cut to what was asked for.
    pub crop: bool,
    /// Whether the image of Output is the window alone.
    pub tight: bool,
    /// The field.
    pub field: &'static CStr,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            time: 0.0,
            scale: (1.0, 1.0),
            window: None,
            tiles: Vec::new(),
            rows: None,
            crop: false,
            tight: false,
            field: kOfxImageFieldNone,
        }
    }
}

/// What came of it.
#[derive(Debug)]
pub struct Frame {
    /// The worst status of all renders.
    pub status: OfxStatus,
    /// Output, with NaN where nothing was to be rendered.
    pub picture: Picture,
    /// Where Output has pixels.
    pub rod: Rect,
    /// What was rendered.
    pub window: Rect,
    /// What was written wrongly, and images that were not released.
    pub faults: Vec<String>,
    /// Clips whose images were fetched.
    pub fetched: Vec<String>,
    /// The plugin's last message, if it failed.
    pub said: Option<String>,
}

impl Frame {
    /// The frame, if it was rendered without a fault.
    ///
    /// # Errors
    /// Its faults.
    pub fn good(self) -> Result<Self, String> {
        if self.status != kOfxStatOK {
            let said = self
                .said
                .map_or_else(String::new, |said| format!(" and said {said:?}"));
            return Err(format!("Render gave {}{said}", status_name(self.status)));
        }
        match self.faults.first() {
            Some(_) => Err(self.faults.join("; ")),
            None => Ok(self),
        }
    }
}

impl Instance<'_> {
    /// Renders a frame as hosts do: regions asked for first, begin and end of a sequence around it.
    ///
    /// # Errors
    /// If an action before the render fails. That a render fails is in the frame.
    pub fn render(&self, request: &Request) -> Result<Frame, String> {
        let host = self.loaded.host;
        let scene = locked(&self.effect.scene).clone();
        let rod = (self.region_of_definition(request.time, request.scale)?)
            .pixels(request.scale, scene.par);
        let window = request.window.unwrap_or(rod);
        if host.profile.asks {
            self.frames_needed(request)?;
            self.identity(request.time, request.scale, window)?;
        }
        let around = |action: &CStr| {
            if !host.profile.sequences {
                return Ok(());
            }
            let given = of_sequence(request).known(host, false, action);
            let status = self.asked(action, &given, None);
            host.end(given.handle());
            if status == kOfxStatOK || status == kOfxStatReplyDefault {
                Ok(())
            } else {
                Err(format!(
                    "{} gave {}",
                    action.to_string_lossy(),
                    status_name(status)
                ))
            }
        };
        around(kOfxImageEffectActionBeginSequenceRender)?;
        let tiles = if request.tiles.is_empty() {
            vec![window]
        } else {
            request.tiles.clone()
        };
        let mut frame = Frame {
            status: kOfxStatOK,
            picture: Picture::flat(window, self.output_channels(), f32::NAN),
            rod,
            window,
            faults: Vec::new(),
            fetched: Vec::new(),
            said: None,
        };
        for tile in tiles {
            self.tile(request, tile, &mut frame)?;
        }
        around(kOfxImageEffectActionEndSequenceRender)?;
        Ok(frame)
    }

    /// Renders one window and puts it into the frame.
    fn tile(&self, request: &Request, window: Rect, frame: &mut Frame) -> Result<(), String> {
        let host = self.loaded.host;
        let channels = frame.picture.channels;
        let crops = if host.profile.asks || request.crop {
            let regions = self.regions_of_interest(request.time, request.scale, window)?;
            request.crop.then_some(regions)
        } else {
            None
        };
        let bounds = if request.tight {
            window
        } else {
            around(frame.rod, window)
        };
        let rows = request.rows.unwrap_or(host.profile.rows);
        let output = Arc::new(Buffer::new(bounds, channels, rows, None));
        let rendering = Arc::new(Rendering {
            time: request.time,
            scale: request.scale,
            rows,
            crops,
            output: Arc::clone(&output),
            rod: frame.rod,
            field: request.field,
            fetched: Mutex::default(),
        });
        locked(&self.effect.renderings).push(Arc::clone(&rendering));
        let pixels = host.profile.pixel_regions;
        self.tell_project(if pixels { request.scale } else { (1.0, 1.0) });
        let action = kOfxImageEffectActionRender;
        let given = of_render(host, request, window).known(host, false, action);
        let status = act(
            &self.loaded.plugin,
            action,
            self.effect.handle(),
            Some(&given),
            None,
            Some(Arc::clone(&rendering)),
        );
        host.end(given.handle());
        locked(&self.effect.renderings).retain(|r| !Arc::ptr_eq(r, &rendering));
        for clip in left_out(host, Some(&rendering)) {
            frame
                .faults
                .push(format!("an image of {clip} was not released"));
        }
        frame.fetched.extend(locked(&rendering.fetched).drain(..));
        frame.status = frame.status.max(status);
        if status != kOfxStatOK {
            frame.said = locked(&host.messages)
                .last()
                .map(|message| message.text.clone());
        }
        let written = output.picture();
        let wanted = |x: i32, y: i32| window.contains(x, y) && in_field(request.field, y);
        if status == kOfxStatOK {
            frame.faults.extend(output.faults(wanted));
        } else {
            // What is in the window then is nobody's business, what lies outside still is.
            let all = output.faults(wanted);
            let outside = |text: &&String| text.contains("outside") || text.contains("belong");
            frame.faults.extend(all.iter().filter(outside).cloned());
        }
        for (x, y) in window.pixels().filter(|(x, y)| wanted(*x, *y)) {
            if let Some(at) = frame.picture.at(x, y) {
                frame.picture.samples[at..at + channels].copy_from_slice(written.pixel(x, y));
            }
        }
        Ok(())
    }

    /// Says how large the project is, reduced by `scale`.
    fn tell_project(&self, scale: (f64, f64)) {
        let project = locked(&self.effect.scene).project;
        let corner = |x: f64, y: f64| vec![Value::Double(x * scale.0), Value::Double(y * scale.1)];
        let size = (project.x2 - project.x1, project.y2 - project.y1);
        let rows = [
            (kOfxImageEffectPropProjectSize, size),
            (kOfxImageEffectPropProjectOffset, (project.x1, project.y1)),
            (kOfxImageEffectPropProjectExtent, (project.x2, project.y2)),
        ];
        for (name, (x, y)) in rows {
            self.effect.properties.put(name, corner(x, y));
        }
    }

    /// Calls GetFramesNeeded; this host has every frame.
    fn frames_needed(&self, request: &Request) -> Result<(), String> {
        let host = self.loaded.host;
        let action = kOfxImageEffectActionGetFramesNeeded;
        let given = super::arguments::at(request.time, request.scale).known(host, false, action);
        let mut wanted = super::arguments::Arguments::default();
        for clip in self.effect.clips() {
            // Some hosts leave out what is not connected: openfx-misc README-hosts.txt.
            let connected = clip.properties.int(kOfxImageClipPropConnected) == Some(1);
            if connected && clip.name != "Output" {
                let range = [request.time, request.time].map(Value::Double);
                wanted = wanted.of_clip("OfxImageClipPropFrameRange_", &clip.name, range.to_vec());
            }
        }
        let wanted = wanted.known(host, true, action);
        let status = self.asked(action, &given, Some(&wanted));
        host.end(given.handle());
        host.end(wanted.handle());
        if status == kOfxStatOK || status == kOfxStatReplyDefault {
            Ok(())
        } else {
            Err(format!("GetFramesNeeded gave {}", status_name(status)))
        }
    }
}

/// Whether a row belongs to the field: even rows are the lower one.
fn in_field(field: &CStr, y: i32) -> bool {
    match field {
        f if f == kOfxImageFieldLower => y.rem_euclid(2) == 0,
        f if f == kOfxImageFieldUpper => y.rem_euclid(2) == 1,
        _ => true,
    }
}

/// The smallest rectangle that holds both.
fn around(a: Rect, b: Rect) -> Rect {
    if a.is_empty() {
        return b;
    }
    if b.is_empty() {
        return a;
    }
    Rect::new(
        a.x1.min(b.x1),
        a.y1.min(b.y1),
        a.x2.max(b.x2),
        a.y2.max(b.y2),
    )
}
