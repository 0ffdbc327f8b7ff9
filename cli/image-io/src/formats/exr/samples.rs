//! Samples of a channel, of any type and with mip or rip levels.

use exr::image::{FlatSamples, Levels};
use exr::meta::attribute::SampleType;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

/// Returns the samples of full resolution.
pub(super) fn full_level(levels: &Levels<FlatSamples>) -> Option<&FlatSamples> {
    match levels {
        Levels::Singular(samples) => Some(samples),
        Levels::Mip { level_data, .. } => level_data.first(),
        Levels::Rip { level_data, .. } => level_data.map_data.first(),
    }
}

/// Drops all levels but the full resolution. Returns whether there were others.
pub(super) fn keep_full_level(levels: &mut Levels<FlatSamples>) -> bool {
    let data = match levels {
        Levels::Singular(_) => return false,
        Levels::Mip { level_data, .. } => level_data,
        Levels::Rip { level_data, .. } => &mut level_data.map_data,
    };
    if data.is_empty() {
        return false;
    }
    *levels = Levels::Singular(data.swap_remove(0));
    true
}

pub(super) fn sample_type(samples: &FlatSamples) -> SampleType {
    match samples {
        FlatSamples::F16(_) => SampleType::F16,
        FlatSamples::F32(_) => SampleType::F32,
        FlatSamples::U32(_) => SampleType::U32,
    }
}

/// Samples that one thread converts at a time.
const CHUNK: usize = 1 << 16;

/// Returns samples as floats. Unsigned integers above 2^24 are rounded.
pub(super) fn as_floats(samples: &FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F16(samples) => {
            let mut out = vec![0.0; samples.len()];
            let chunks = out.par_chunks_mut(CHUNK).zip(samples.par_chunks(CHUNK));
            chunks.for_each(|(out, samples)| samples.convert_to_f32_slice(out));
            out
        }
        FlatSamples::F32(samples) => samples.clone(),
        #[allow(clippy::cast_precision_loss)]
        FlatSamples::U32(samples) => samples.par_iter().map(|&s| s as f32).collect(),
    }
}

/// Overwrites `to` with `from`, converted to the type of `to`. Returns how many finite samples were clipped.
pub(super) fn overwrite(to: &mut FlatSamples, from: &[f32]) -> usize {
    match to {
        FlatSamples::F32(to) => {
            to.copy_from_slice(from);
            0
        }
        FlatSamples::F16(to) => overwrite_each(to, from, |from| {
            let half = f16::from_f32(from);
            if half.is_infinite() {
                let limit = if from > 0.0 { f16::MAX } else { f16::MIN };
                (limit, from.is_finite())
            } else {
                (half, false)
            }
        }),
        FlatSamples::U32(to) => overwrite_each(to, from, |from| {
            let rounded = from.round();
            // A cast from float saturates and turns NaN into 0.
            (rounded as u32, rounded < 0.0 || rounded >= u32::MAX as f32)
        }),
    }
}

/// Overwrites `to` with what `convert` returns for each of `from`; returns the number of those for which it also returns true.
fn overwrite_each<T: Send>(
    to: &mut [T],
    from: &[f32],
    convert: impl Fn(f32) -> (T, bool) + Sync,
) -> usize {
    let chunks = to.par_chunks_mut(CHUNK).zip(from.par_chunks(CHUNK));
    let clipped = chunks.map(|(to, from)| {
        let mut clipped = 0;
        for (to, from) in to.iter_mut().zip(from) {
            let (value, is_clipped) = convert(*from);
            *to = value;
            clipped += usize::from(is_clipped);
        }
        clipped
    });
    clipped.sum()
}
