//! libseidel: Seidel's C ABI. Opaque handles, status codes and buffers that stay the caller's, around `seidel-core`,
//! so that any host that can call C can load a lens, ask for its PSFs, put its blur on plates and take it off.
//!
//! `plugin/include/seidel.h` is made from what is public here (`cargo xtask header`), and says all that a caller has to
//! know. Every export goes through `guard`, which turns errors and panics into a status and a text.

mod apply;
mod call_args;
mod callbacks;
mod guard;
mod handles;
mod image;
mod kernel;
mod last_error;
mod lens;
mod lens_check;
mod plate;
mod pointers;
mod region;
mod relens;
mod remove;
mod results;
mod settings;
mod status;
mod threads;
mod version;

pub use apply::seidel_apply;
pub use callbacks::{SeidelCallbacks, SeidelProgress};
pub use image::{SEIDEL_FLOAT, SEIDEL_HALF, SeidelImage, SeidelRect};
pub use kernel::{SeidelKernel, seidel_kernel};
pub use last_error::seidel_last_error;
pub use lens::{
    SEIDEL_LENS_MOMENTS, SEIDEL_LENS_RAYS, SeidelLens, SeidelLensInfo, seidel_lens_channel,
    seidel_lens_info, seidel_lens_model, seidel_lens_open, seidel_lens_read, seidel_lens_release,
    seidel_lens_retain,
};
pub use lens_check::seidel_check_lens;
pub use plate::SeidelPlate;
pub use region::{seidel_memory_needed, seidel_region_of_interest};
pub use relens::seidel_relens;
pub use remove::{SeidelFindings, seidel_remove};
pub use settings::*;
pub use status::SeidelStatus;
pub use threads::seidel_shutdown;
pub use version::{SEIDEL_ABI_VERSION, seidel_abi_version, seidel_version};
