//! A frame rendered: where it lies, what goes in, what comes out.

mod copied;
mod frame;
mod inputs;
mod mixing;
mod outcome;
mod preview;
mod psf_grid;

pub(crate) use copied::Copied;
pub(crate) use frame::{Frame, field_of, project_of, window_of};
pub(crate) use inputs::{Inputs, is_unpremultiplied, picture};
pub(crate) use mixing::{Mixing, mix};
pub(crate) use outcome::{Lenses, Outcome, Task, perform, progress};
pub(crate) use preview::{InFocus, focal_plane};
pub(crate) use psf_grid::psf_grid;
