//! The exact renderer and what it is made of: kernels scattered pixel by pixel.

mod local_kernel;
mod reach;
mod renderer;
mod sheet;
mod sources;
mod spot;

pub use local_kernel::{LocalKernel, LocalKernels};
pub(crate) use reach::{reach, reach_of_pass};
pub use renderer::Scatter;
pub(crate) use sheet::fold;
pub(crate) use sources::{Source, Sources};
pub use spot::at_pixels;
