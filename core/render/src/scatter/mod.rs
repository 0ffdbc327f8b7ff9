//! The exact renderer: kernels scattered pixel by pixel.

mod accumulators;
mod exact_pixels;
mod local_kernel;
mod reach;
mod renderer;
mod sources;

pub(crate) use accumulators::fold;
pub use exact_pixels::exact_at_pixels;
pub(crate) use local_kernel::weighted_sum;
pub use local_kernel::{LocalKernel, LocalKernels};
pub(crate) use reach::kernel_reach;
pub use renderer::Scatter;
pub(crate) use sources::{Source, Sources};
