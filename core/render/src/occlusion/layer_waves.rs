//! Crops of depth layers that are blurred at the same time, before they are composited in order.

use crate::RenderWindow;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// A part of a depth layer.
#[derive(Debug, Clone, Copy)]
pub(super) struct LayerCrop {
    pub(super) layer: usize,
    pub(super) crop: RenderWindow,
}

/// Groups `crops` in order into waves that are blurred at the same time: at most one a thread, and together at most one
/// plate of `plate_pixels`, which bounds the memory taken. A wave has at least one crop.
pub(super) fn waves(crops: &[LayerCrop], plate_pixels: usize) -> Vec<Range<usize>> {
    let threads = rayon::current_num_threads().max(1);
    let pixels = |part: &LayerCrop| part.crop.width * part.crop.height;
    let mut found = Vec::new();
    let (mut start, mut held) = (0, 0);
    for (index, part) in crops.iter().enumerate() {
        let is_full = index - start == threads || held + pixels(part) > plate_pixels;
        if index > start && is_full {
            found.push(start..index);
            (start, held) = (index, 0);
        }
        held += pixels(part);
    }
    if start < crops.len() {
        found.push(start..crops.len());
    }
    found
}

/// The progress of crops that are blurred at the same time.
pub(super) struct CropProgress<'a> {
    /// Share done of each crop.
    shares: Mutex<Vec<f64>>,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
}

impl<'a> CropProgress<'a> {
    /// The progress of `count` crops, reported as that of all of them to `progress`.
    pub(super) fn new(count: usize, progress: &'a (dyn Fn(f64) -> bool + Sync)) -> Self {
        Self {
            shares: Mutex::new(vec![0.0; count]),
            progress,
        }
    }

    /// Sets the share done of crop `index`, which never falls; returns whether to go on.
    pub(super) fn set(&self, index: usize, share: f64) -> bool {
        let mut shares = self.shares.lock().unwrap_or_else(PoisonError::into_inner);
        shares[index] = shares[index].max(share);
        let done = shares.iter().sum::<f64>() / shares.len() as f64;
        drop(shares);
        (self.progress)(done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crops(sides: &[usize]) -> Vec<LayerCrop> {
        sides
            .iter()
            .enumerate()
            .map(|(layer, side)| LayerCrop {
                layer,
                crop: RenderWindow::from_size(*side, *side),
            })
            .collect()
    }

    #[test]
    fn waves_hold_all_crops_once_and_at_most_a_plate_unless_one_is_larger() {
        let sides = [10, 10, 3, 3, 3, 3, 3, 3, 10, 1];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build();
        let found = pool.map(|pool| pool.install(|| waves(&crops(&sides), 100)));
        assert_eq!(found.ok(), Some(vec![0..1, 1..2, 2..6, 6..8, 8..9, 9..10]));
        assert!(waves(&[], 100).is_empty());
        assert_eq!(waves(&crops(&[20]), 100), vec![0..1]);
    }

    #[test]
    fn progress_is_the_mean_of_all_crops() {
        let last = Mutex::new(0.0);
        let report = |share: f64| {
            *last.lock().unwrap_or_else(PoisonError::into_inner) = share;
            share < 0.6
        };
        let progress = CropProgress::new(2, &report);
        assert!(progress.set(1, 1.0));
        assert!(progress.set(1, 0.5), "no share falls");
        assert!(!progress.set(0, 0.5));
        assert_eq!(*last.lock().unwrap_or_else(PoisonError::into_inner), 0.75);
    }
}
