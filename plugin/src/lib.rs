//! libseidel: the C ABI of Seidel. Opaque handles, status codes and the caller's own buffers around `seidel-core`, so
//! that any program that can call C can load a lens, get its PSFs, apply its blur to plates and remove it.
//!
//! `cargo xtask header` generates `plugin/include/seidel.h` from the public items here. Every export goes through
//! `guard`, which turns errors and panics into a status and a text.

// Modules with exports, in the order of the header. The blank lines keep rustfmt from sorting them.
mod version;

mod status;

mod last_error;

mod lens;

mod settings;

mod image;

mod plate;

mod callbacks;

mod apply;

mod remove;

mod relens;

mod check_lens;

mod kernel;

mod region;

mod match_colours;
mod memory;

mod pick;

mod depth_findings;

mod threads;

mod call_args;
mod guard;
mod handles;
mod panics;
mod pointers;

pub use apply::seidel_apply;
pub use callbacks::{SeidelCallbacks, SeidelProgress};
pub use check_lens::seidel_check_lens;
pub use depth_findings::seidel_depth_findings;
pub use handles::SeidelLens;
pub use image::{SEIDEL_FLOAT, SEIDEL_HALF, SeidelImage, SeidelRect};
pub use kernel::{SeidelKernel, seidel_kernel};
pub use last_error::seidel_last_error;
pub use lens::{
    SEIDEL_LENS_MOMENTS, SEIDEL_LENS_RAYS, SeidelLensInfo, seidel_lens_channel, seidel_lens_info,
    seidel_lens_model, seidel_lens_open, seidel_lens_read, seidel_lens_release, seidel_lens_retain,
};
pub use match_colours::seidel_match_colours;
pub use memory::seidel_memory_needed;
pub use pick::seidel_distance_at;
pub use plate::SeidelPlate;
pub use region::seidel_region_of_interest;
pub use relens::seidel_relens;
pub use remove::{SeidelFindings, seidel_remove};
pub use settings::*;
pub use status::SeidelStatus;
pub use threads::seidel_shutdown;
pub use version::{SEIDEL_ABI_VERSION, seidel_abi_version, seidel_version};
