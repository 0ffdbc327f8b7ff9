//! Results of earlier renders: another mix or mask of the same render needs no render.

use std::sync::Arc;

use seidel_core::{Image, Result, ResultStore};

use crate::remarks::Remark;

/// Most results, of all instances together: some frames and settings to compare. More would be frames of a shot, which no other mix
/// or mask needs.
const MOST: usize = 8;

/// Most memory that results take, bytes, of all instances together: seven HD frames or one of 4096 x 2160 with alpha.
const MOST_BYTES: usize = 256 << 20;

/// An image, and remarks on the inputs that it was made from.
pub(super) struct KeptResult {
    pub(super) image: Image,
    pub(super) remarks: Vec<Remark>,
}

static RESULTS: ResultStore<KeptResult> = ResultStore::new(MOST, MOST_BYTES);

/// Returns what `render` makes, or made before with the same `key`, a hash of all that it is made from.
///
/// # Errors
/// Those of `render`.
pub(super) fn kept_or_rendered(
    key: u64,
    render: impl FnOnce() -> Result<KeptResult>,
) -> Result<Arc<KeptResult>> {
    if let Some(result) = RESULTS.get(key) {
        return Ok(result);
    }
    let result = Arc::new(render()?);
    let image = &result.image;
    let planes = image.colours.iter().chain(&image.alpha);
    let bytes = planes.map(|plane| size_of_val(plane.as_slice())).sum();
    RESULTS.insert(key, bytes, Arc::clone(&result));
    Ok(result)
}

/// Drops all results.
pub(crate) fn forget_results() {
    RESULTS.clear();
}
