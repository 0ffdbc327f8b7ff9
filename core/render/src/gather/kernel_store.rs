//! Kernels kept from one render to the next.
//!
//! Kernels depend on the lens, its settings and the place in the frame, not on the plate. The next frame of a shot, and the next
//! render of a frame with other knobs that leave the blur alone, need the same ones. A kernel is known by the blur that it
//! draws, so a store serves any lens and any settings, and no change of them makes it wrong.

use super::passband::FilterStore;
use super::side_store::SideStore;
use super::stencil::Stencil;
use crate::scatter::Source;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Parts that are locked one by one, so that threads seldom wait.
const SHARDS: usize = 16;

/// Most memory that the kernels of a store take, bytes.
const MOST_BYTES: usize = 160 << 20;

/// Renders after which an unused kernel makes room for others.
const KEPT_RENDERS: u64 = 2;

/// Renders after which an unused kernel is dropped, so that a shot whose focus is animated does not fill the memory of a host with
/// kernels of the frames before. Two nodes with one lens, and a comparison of two values of a knob, need fewer.
const IDLE_RENDERS: u64 = 8;

/// The truncation of a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Truncation {
    /// Of a kernel from which stencils are interpolated: truncated again afterwards.
    ForStencils,
    /// Of a kernel that scatters light itself.
    ForScattering,
}

/// The blur that a kernel draws, and the accuracy.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct KernelKey {
    /// In plate pixels; without moments where rays draw the kernel.
    pub(super) source: Source,
    /// Bound of the offsets of weights along x and y, pixels of the level, if the kernel is cut there.
    pub(super) reach: Option<[i32; 2]>,
    /// Id of the PSF model.
    pub(super) model: &'static str,
    /// Pyramid level.
    pub(super) level: u32,
    pub(super) truncation: Truncation,
    /// Share of the light that is truncated.
    pub(super) truncated_share: f64,
    /// Smallest standard deviation drawn at a level, in its pixels.
    pub(super) narrowest: f64,
}

impl KernelKey {
    fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        let (x, y) = self.source.shift_px;
        let moments = self.source.blur.moments.to_array();
        let pupil = self.source.blur.pupil.iter();
        let rays = pupil.flat_map(|pupil| pupil.wavefront.coefficients());
        for number in rays.chain(&moments).chain([&x, &y]) {
            // Zeros of both signs are equal.
            (number + 0.0).to_bits().hash(&mut hasher);
        }
        (self.level, self.truncation, self.reach).hash(&mut hasher);
        hasher.finish()
    }
}

/// A kernel with the number of the render that used it last.
struct Kept {
    key: KernelKey,
    kernel: Arc<Stencil>,
    last_used: u64,
}

impl Kept {
    fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(self.kernel.weights.as_slice())
    }
}

/// A part of a store.
#[derive(Default)]
struct Shard {
    kernels: HashMap<u64, Vec<Kept>>,
    bytes: usize,
    /// The render that last made room.
    swept: u64,
}

impl Shard {
    fn find(&mut self, hash: u64, key: &KernelKey, render: u64) -> Option<Arc<Stencil>> {
        let kept = self.kernels.get_mut(&hash)?;
        let found = kept.iter_mut().find(|kept| kept.key == *key)?;
        found.last_used = render;
        Some(Arc::clone(&found.kernel))
    }

    /// Keeps a kernel, if there is room for it or unused ones make room.
    fn keep(&mut self, hash: u64, kept: Kept, most_bytes: usize) {
        let bytes = kept.bytes();
        if self.bytes + bytes > most_bytes && self.swept < kept.last_used {
            self.drop_unused(kept.last_used, KEPT_RENDERS);
        }
        if self.bytes + bytes <= most_bytes {
            self.bytes += bytes;
            self.kernels.entry(hash).or_default().push(kept);
        }
    }

    /// Drops the kernels that the last `renders` before `render` did not use.
    fn drop_unused(&mut self, render: u64, renders: u64) {
        self.swept = render;
        self.kernels.retain(|_, all| {
            all.retain(|kept| kept.last_used + renders > render);
            !all.is_empty()
        });
        self.bytes = self.kernels.values().flatten().map(Kept::bytes).sum();
    }
}

/// Kernels that renders have drawn, tile sides that they have measured and filters that they have fitted, kept for the next ones. The kernels take at most
/// 160 MiB.
pub struct KernelStore {
    shards: [Mutex<Shard>; SHARDS],
    // Both take little memory.
    pub(super) sides: SideStore,
    pub(super) filters: FilterStore,
    /// Number of renders begun.
    renders: AtomicU64,
    most_bytes: usize,
}

impl Default for KernelStore {
    fn default() -> Self {
        Self::with_room(MOST_BYTES)
    }
}

impl std::fmt::Debug for KernelStore {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("KernelStore")
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl KernelStore {
    /// An empty store that takes at most `most_bytes`.
    fn with_room(most_bytes: usize) -> Self {
        Self {
            shards: Default::default(),
            sides: SideStore::default(),
            filters: FilterStore::default(),
            renders: AtomicU64::new(0),
            most_bytes,
        }
    }

    /// Begins a render: kernels that the last two did not use make room for new ones, and those that the last eight did not use are
    /// dropped.
    pub fn begin_render(&self) {
        let render = self.renders.fetch_add(1, Ordering::Relaxed) + 1;
        for shard in &self.shards {
            let mut shard = lock(shard);
            let swept = shard.swept;
            shard.drop_unused(render, IDLE_RENDERS);
            shard.swept = swept;
        }
    }

    /// Returns the memory that the kernels take, bytes.
    pub fn bytes(&self) -> usize {
        let shards = self.shards.iter();
        shards.map(|shard| lock(shard).bytes).sum()
    }

    /// Returns the kernel of `key`, from the store or else from `draw`.
    pub(super) fn kernel(&self, key: &KernelKey, draw: impl FnOnce() -> Stencil) -> Arc<Stencil> {
        let hash = key.hash();
        let shard = &self.shards[hash as usize % SHARDS];
        let render = self.renders.load(Ordering::Relaxed);
        if let Some(found) = lock(shard).find(hash, key, render) {
            return found;
        }
        let kernel = Arc::new(draw());
        let mut shard = lock(shard);
        // Another thread may have drawn it in the meantime.
        if let Some(found) = shard.find(hash, key, render) {
            return found;
        }
        let kept = Kept {
            key: key.clone(),
            kernel: Arc::clone(&kernel),
            last_used: render,
        };
        shard.keep(hash, kept, self.most_bytes / SHARDS);
        kernel
    }
}

fn lock(shard: &Mutex<Shard>) -> MutexGuard<'_, Shard> {
    shard.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::field::Meridian;
    use seidel_optics::lens::{AperturePicture, LocalPupil, PictureMask, Wavefront};
    use seidel_optics::moments::CentralMoments;
    use seidel_optics::psf::LocalBlur;

    fn key(variance: f64) -> KernelKey {
        let moments = CentralMoments {
            mu20: variance,
            mu02: variance,
            ..CentralMoments::default()
        };
        KernelKey {
            source: Source {
                blur: LocalBlur::from_moments(moments, Meridian::X),
                shift_px: (0.0, 0.0),
            },
            reach: None,
            model: "gaussian",
            level: 0,
            truncation: Truncation::ForScattering,
            truncated_share: 1e-3,
            narrowest: 1.0,
        }
    }

    /// Returns whether the store had to draw `key`.
    fn is_drawn(store: &KernelStore, key: &KernelKey) -> bool {
        let mut is_drawn = false;
        store.kernel(key, || {
            is_drawn = true;
            Stencil::zeros(0..10, 0..10)
        });
        is_drawn
    }

    #[test]
    fn a_kernel_is_drawn_once_and_kernels_of_other_blur_or_accuracy_are_others() {
        let store = KernelStore::default();
        let first = key(2.0);
        assert!(is_drawn(&store, &first) && !is_drawn(&store, &first));
        let changes: [fn(&mut KernelKey); 7] = [
            |key| key.source.shift_px.0 = 0.25,
            |key| key.level = 1,
            |key| key.reach = Some([40, 30]),
            |key| key.truncation = Truncation::ForStencils,
            |key| key.truncated_share = 2e-3,
            |key| key.narrowest = 2.0,
            |key| key.model = "skew-normal",
        ];
        let changed = changes.map(|change| {
            let mut other = first.clone();
            change(&mut other);
            other
        });
        for other in changed.iter().chain([&key(2.5)]) {
            assert!(is_drawn(&store, other), "{other:?}");
        }
    }

    #[test]
    fn pictures_of_equal_samples_share_kernels() {
        let store = KernelStore::default();
        let behind = |transmission: f32| {
            let picture = AperturePicture::new(2, &[transmission; 4]).expect("lit");
            let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
            pupil.transmission.picture = Some(PictureMask {
                picture,
                scale: 1.0,
            });
            let mut key = key(2.0);
            key.source.blur.pupil = Some(pupil);
            key
        };
        assert!(is_drawn(&store, &behind(1.0)) && !is_drawn(&store, &behind(1.0)));
        assert!(is_drawn(&store, &behind(0.5)));
    }

    #[test]
    fn memory_is_bounded_and_unused_kernels_make_room() {
        let one = size_of::<Kept>() + 400;
        let store = KernelStore::with_room(4 * one * SHARDS);
        store.begin_render();
        for k in 0..200 {
            is_drawn(&store, &key(1.0 + f64::from(k)));
        }
        assert!(store.bytes() <= 4 * one * SHARDS);
        let kept = store.bytes();
        assert!(kept > 2 * one * SHARDS, "{kept}");
        // The kernels kept are used again; those that find no room do not push them out.
        let drawn = (0..200).filter(|k| is_drawn(&store, &key(1.0 + f64::from(*k))));
        assert_eq!(drawn.count(), 200 - kept / one);
        for _ in 0..KEPT_RENDERS {
            store.begin_render();
        }
        let new = (0..200).map(|k| key(1000.0 + f64::from(k)));
        let drawn = new.clone().filter(|key| is_drawn(&store, key)).count();
        assert_eq!(drawn, 200);
        assert!(new.filter(|key| is_drawn(&store, key)).count() < 200);
        assert!(store.bytes() <= 4 * one * SHARDS);
        for _ in 0..IDLE_RENDERS {
            store.begin_render();
        }
        assert_eq!(store.bytes(), 0);
    }
}
