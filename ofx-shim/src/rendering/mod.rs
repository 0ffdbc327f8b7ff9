//! Rendering of a frame: its place, its inputs, and its result.

mod aperture;
mod coc_map;
mod focal_plane;
mod focal_point;
mod frame;
mod gap;
mod host_pixels;
mod inputs;
mod mixing;
mod psf_grid;
mod results;
mod source;
mod task;

pub(crate) use aperture::aperture_picture;
pub(crate) use focal_plane::{FocusRange, tint_by_focus};
pub(crate) use focal_point::focus_at;
pub(crate) use frame::{Frame, field, project_region, render_window};
pub(crate) use gap::gap_map;
pub(crate) use host_pixels::in_host_pixels;
pub(crate) use inputs::{Inputs, image_of_input};
pub(crate) use mixing::{MixedChannels, Mixing};
pub(crate) use psf_grid::draw_psf_grid;
pub(crate) use results::forget_results;
pub(crate) use source::Source;
pub(crate) use task::{Outcome, RenderJob, Task};
