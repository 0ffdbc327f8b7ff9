//! Samples of a channel, of any type and with mip or rip levels.

use exr::image::{FlatSamples, Levels};
use exr::meta::attribute::SampleType;
use half::f16;

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

/// Overwrites `to` with `from`, converted to the type of `to`. Returns how many finite samples were clipped.
pub(super) fn overwrite(to: &mut FlatSamples, from: &[f32]) -> usize {
    match to {
        FlatSamples::F32(to) => {
            to.copy_from_slice(from);
            0
        }
        FlatSamples::F16(to) => {
            let mut clipped = 0;
            for (to, &from) in to.iter_mut().zip(from) {
                let half = f16::from_f32(from);
                *to = if half.is_infinite() {
                    clipped += usize::from(from.is_finite());
                    if from > 0.0 { f16::MAX } else { f16::MIN }
                } else {
                    half
                };
            }
            clipped
        }
        FlatSamples::U32(to) => {
            let mut clipped = 0;
            for (to, &from) in to.iter_mut().zip(from) {
                let rounded = from.round();
                clipped += usize::from(rounded < 0.0 || rounded >= u32::MAX as f32);
                // A cast from float saturates and turns NaN into 0.
                *to = rounded as u32;
            }
            clipped
        }
    }
}
