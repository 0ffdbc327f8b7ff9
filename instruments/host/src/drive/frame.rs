//! Renders of one frame, whole or in tiles, and what they wrote.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::arguments::{for_render, for_sequence};
use super::{ActionArguments, Instance, act_with, check_status, status_name};
use crate::host::images::{ActiveRender, GuardedBuffer, reclaim};
use crate::host::locked;
use crate::host::profile::RowLayout;
use crate::host::properties::Value;
use crate::host::render_time::{ImageWork, RenderTime, Stopwatch};
use crate::picture::{Picture, Rect};

/// A render request, and the memory layout of its images.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// The time.
    pub time: f64,
    /// The render scale.
    pub scale: (f64, f64),
    /// The render window; by default the region of definition.
    pub window: Option<Rect>,
    /// Windows that are rendered in this order instead of the whole window.
    pub tiles: Vec<Rect>,
    /// The row layout; by default that of the host.
    pub rows: Option<RowLayout>,
    /// Whether input images are cropped to the regions of interest.
    pub crop_inputs: bool,
    /// Whether the output image covers the render window only.
    pub crop_output: bool,
    /// The field.
    pub field: &'static CStr,
    /// Time in the Render action after which `abort` returns yes.
    pub abort_after: Option<Duration>,
}

impl Default for RenderRequest {
    fn default() -> Self {
        Self {
            time: 0.0,
            scale: (1.0, 1.0),
            window: None,
            tiles: Vec::new(),
            rows: None,
            crop_inputs: false,
            crop_output: false,
            field: kOfxImageFieldNone,
            abort_after: None,
        }
    }
}

impl RenderRequest {
    /// Returns a request for one window at time 0.
    #[must_use]
    pub fn of_window(window: Rect) -> Self {
        Self {
            window: Some(window),
            ..Self::default()
        }
    }
}

/// The result of rendering a frame.
#[derive(Debug)]
pub struct Frame {
    /// The worst status of all renders.
    pub status: OfxStatus,
    /// The picture, NaN where nothing was to be rendered.
    pub picture: Picture,
    /// The region of definition, in pixels.
    pub rod: Rect,
    /// The render window.
    pub window: Rect,
    /// Wrong writes, and images that were not released.
    pub faults: Vec<String>,
    /// Clips whose images were fetched.
    pub fetched_clips: Vec<String>,
    /// The plugin's last message, if a render failed.
    pub message: Option<String>,
    /// The time of all renders.
    pub time: RenderTime,
}

impl Frame {
    /// Returns the frame if it was rendered without faults.
    ///
    /// # Errors
    /// The status and message, or the faults.
    fn checked(self) -> Result<Self, String> {
        if self.status != kOfxStatOK {
            let message = self.message.map_or_else(String::new, |message| {
                format!(" with the message {message:?}")
            });
            return Err(format!(
                "Render returned {}{message}",
                status_name(self.status)
            ));
        }
        if self.faults.is_empty() {
            Ok(self)
        } else {
            Err(self.faults.join("; "))
        }
    }
}

impl Instance<'_> {
    /// Renders a frame that must succeed without faults.
    ///
    /// # Errors
    /// If an action fails, or the render writes wrong pixels or does not release images.
    pub fn render_checked(&self, request: &RenderRequest) -> Result<Frame, String> {
        self.render(request)?.checked()
    }

    /// Renders a frame with the actions that hosts call before and after it.
    ///
    /// # Errors
    /// If one of the other actions fails. The status and faults of the render itself are in the frame.
    pub fn render(&self, request: &RenderRequest) -> Result<Frame, String> {
        let host = self.loaded.host;
        let (par, project) = {
            let scene = locked(&self.effect.scene);
            (scene.par, scene.project)
        };
        let rod = self
            .region_of_definition(request.time, request.scale)?
            .or_project(&project)
            .pixels(request.scale, par);
        let window = request.window.unwrap_or(rod);
        if host.profile.calls_optional_actions {
            self.frames_needed(request)?;
            self.identity(request.time, request.scale, window)?;
        }
        self.act_on_sequence(kOfxImageEffectActionBeginSequenceRender, request)?;
        let tiles = if request.tiles.is_empty() {
            vec![window]
        } else {
            request.tiles.clone()
        };
        let mut frame = Frame {
            status: kOfxStatOK,
            picture: Picture::constant(window, self.output_channels(), f32::NAN),
            rod,
            window,
            faults: Vec::new(),
            fetched_clips: Vec::new(),
            message: None,
            time: RenderTime::default(),
        };
        for tile in tiles {
            self.render_tile(request, tile, &mut frame)?;
        }
        self.act_on_sequence(kOfxImageEffectActionEndSequenceRender, request)?;
        Ok(frame)
    }

    /// Calls BeginSequenceRender or EndSequenceRender if the host does.
    fn act_on_sequence(&self, action: &CStr, request: &RenderRequest) -> Result<(), String> {
        let host = self.loaded.host;
        if !host.profile.calls_sequence_actions {
            return Ok(());
        }
        let in_args = for_sequence(request).in_args(host, action);
        let status = self.act_with(action, &in_args, None);
        host.invalidate(in_args.handle());
        check_status(&action.to_string_lossy(), status)
    }

    /// Renders one window and copies it to the frame.
    fn render_tile(
        &self,
        request: &RenderRequest,
        window: Rect,
        frame: &mut Frame,
    ) -> Result<(), String> {
        let host = self.loaded.host;
        let crops = if host.profile.calls_optional_actions || request.crop_inputs {
            let regions = self.regions_of_interest(request.time, request.scale, window)?;
            request.crop_inputs.then_some(regions)
        } else {
            None
        };
        let bounds = if request.crop_output {
            window
        } else {
            frame.rod.union(&window)
        };
        let tile = Tile {
            window,
            bounds,
            crops,
        };
        let (output, status) = self.render_round(request, &tile, frame, 0);
        let expected = |x: i32, y: i32| window.contains(x, y) && is_in_field(request.field, y);
        let mut written = output.written(expected);
        // Integers may be written as they were: a second round starts from others.
        let aborts = request.abort_after.is_some() || host.aborts();
        let may_be_equal = output.samples().white().is_some() && !aborts;
        if status == kOfxStatOK && may_be_equal && written.lacks_samples() {
            let (again, _) = self.render_round(request, &tile, frame, 1);
            written.confirm_unwritten(&again.written(expected));
        }
        frame.faults.extend(if status == kOfxStatOK {
            written.faults()
        } else {
            // A failed render may leave the window in any state.
            written.faults_outside()
        });
        let picture = output.picture();
        let channels = picture.channels;
        for (x, y) in window.pixels().filter(|(x, y)| expected(*x, *y)) {
            if let Some(index) = frame.picture.index(x, y) {
                frame.picture.samples[index..index + channels].copy_from_slice(picture.pixel(x, y));
            }
        }
        Ok(())
    }

    /// Renders one window to an image with the poison of a round, and records what the host sees of it.
    fn render_round(
        &self,
        request: &RenderRequest,
        tile: &Tile,
        frame: &mut Frame,
        round: u32,
    ) -> (Arc<GuardedBuffer>, OfxStatus) {
        let host = self.loaded.host;
        let rows = request.rows.unwrap_or(host.profile.rows);
        let (channels, samples) = (frame.picture.channels, self.loaded.samples());
        let output = GuardedBuffer::output(tile.bounds, channels, rows, samples, round);
        let output = Arc::new(output);
        let render = Arc::new(ActiveRender {
            time: request.time,
            scale: request.scale,
            rows,
            crops: tile.crops.clone(),
            output: Arc::clone(&output),
            rod: frame.rod,
            field: request.field,
            fetched_clips: Mutex::default(),
        });
        *locked(&host.image_work) = ImageWork::default();
        let stopwatch = Stopwatch::start();
        let deadline = request.abort_after.map(|after| Instant::now() + after);
        *locked(&host.abort_from) = deadline;
        let status = self.act_render(request, tile.window, &render);
        let time = stopwatch.stop(&locked(&host.image_work), deadline);
        *locked(&host.abort_from) = None;
        frame.time.add(time);
        let held = reclaim(host, Some(&render));
        if round == 0 {
            let faults = held.iter();
            (frame.faults).extend(faults.map(|c| format!("an image of {c} was not released")));
            (frame.fetched_clips).append(&mut locked(&render.fetched_clips));
        }
        frame.status = frame.status.max(status);
        if status != kOfxStatOK {
            let messages = locked(&host.messages);
            frame.message = messages.last().map(|message| message.text.clone());
        }
        (output, status)
    }

    /// Calls Render.
    fn act_render(
        &self,
        request: &RenderRequest,
        window: Rect,
        render: &Arc<ActiveRender>,
    ) -> OfxStatus {
        let host = self.loaded.host;
        let action = kOfxImageEffectActionRender;
        locked(&self.effect.renders).push(Arc::clone(render));
        self.set_project_properties(if host.profile.pixel_regions {
            request.scale
        } else {
            (1.0, 1.0)
        });
        let in_args = for_render(host, request, window).in_args(host, action);
        let arguments = ActionArguments {
            in_args: Some(&in_args),
            out_args: None,
            render: Some(Arc::clone(render)),
        };
        let status = act_with(&self.loaded.plugin, action, self.effect.handle(), arguments);
        host.invalidate(in_args.handle());
        locked(&self.effect.renders).retain(|r| !Arc::ptr_eq(r, render));
        status
    }

    /// Sets the size of the project, multiplied by `scale`.
    fn set_project_properties(&self, scale: (f64, f64)) {
        let project = locked(&self.effect.scene).project;
        let size = (project.x2 - project.x1, project.y2 - project.y1);
        let rows = [
            (kOfxImageEffectPropProjectSize, size),
            (kOfxImageEffectPropProjectOffset, (project.x1, project.y1)),
            (kOfxImageEffectPropProjectExtent, (project.x2, project.y2)),
        ];
        for (name, (x, y)) in rows {
            let values = vec![Value::Double(x * scale.0), Value::Double(y * scale.1)];
            self.effect.properties.put(name, values);
        }
    }
}

/// A part of a frame that is rendered at once.
struct Tile {
    window: Rect,
    /// Pixels of the output image.
    bounds: Rect,
    /// Regions to which input images are cropped.
    crops: Option<BTreeMap<String, Rect>>,
}

/// Returns whether a row belongs to a field. The lower field has the even rows.
fn is_in_field(field: &CStr, y: i32) -> bool {
    match field {
        f if f == kOfxImageFieldLower => y.rem_euclid(2) == 0,
        f if f == kOfxImageFieldUpper => y.rem_euclid(2) == 1,
        _ => true,
    }
}
