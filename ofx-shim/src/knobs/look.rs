//! The look group: iris, squeeze, obstruction, aberrations and bloom.

use std::ffi::CString;

use seidel_core::{Blades, HostGroup, LookPreset};

use super::{Group, Kind, Knob, Own, PresetMenu, Rows, named};
use crate::host::{Change, ParameterValue};

/// Blades: those of the lens.
pub(crate) const OF_LENS: i32 = 0;
/// Blades: a round iris.
pub(crate) const ROUND: i32 = 1;
/// Blades: index of three blades in the menu; more follow.
const THREE: i32 = 2;

/// Returns the number of blades at `index` of the menu, 0 for a round iris; `None` for those of the lens.
pub(crate) fn blade_count(index: i32) -> Option<u32> {
    match index {
        OF_LENS => None,
        ROUND => Some(0),
        _ => Some((index - THREE) as u32 + Blades::COUNTS.0),
    }
}

/// Returns the index of a number of blades in the menu: the inverse of [`blade_count`].
fn blade_index(count: Option<u32>) -> i32 {
    match count {
        None => OF_LENS,
        Some(0) => ROUND,
        Some(count) => THREE + (count - Blades::COUNTS.0) as i32,
    }
}

pub(crate) static PRESET: Knob = Knob {
    name: c"lookPreset",
    label: c"Set Look",
    hint: c"Sets Blades to Tilt Direction to a look with a name, or to that of the lens. Bloom and the aperture stay.",
    kind: Kind::Presets(PresetMenu::Looks),
};

/// Returns the entries of [`PRESET`] after the one that chooses nothing: the look of the lens, then the presets.
pub(super) fn preset_labels() -> Vec<CString> {
    let presets = LookPreset::all().iter().map(|preset| preset.label);
    let labels = std::iter::once("As Lens").chain(presets);
    labels
        .filter_map(|label| CString::new(label).ok())
        .collect()
}

/// Returns the changes of other knobs that the entry `index` of [`PRESET`] makes; none for the one that chooses nothing.
pub(crate) fn preset_changes(index: i32) -> Vec<Change> {
    let Some(index) = usize::try_from(index).ok().filter(|index| *index > 0) else {
        return Vec::new();
    };
    // The first entry is the look of the lens.
    let preset = index
        .checked_sub(2)
        .and_then(|index| LookPreset::all().get(index));
    let blades = blade_index(preset.and_then(|preset| preset.blades));
    let numbers: Vec<_> = match preset {
        Some(preset) => preset.values().collect(),
        None => seidel_core::Knob::numbers_of_look().collect(),
    };
    let numbers = numbers.into_iter();
    let numbers = numbers.map(|(row, value)| (named(row.name).name, ParameterValue::Double(value)));
    let blades = (BLADES.name, ParameterValue::Int(blades));
    std::iter::once(blades).chain(numbers).collect()
}

pub(crate) static BLADES: Knob = Knob {
    name: c"blades",
    label: c"Blades",
    hint: c"Number of iris blades: discs are polygons. Looks need a lens of rays: one that comes with Seidel, or one fitted with --model reduced. They act on the lens as F Stop and Focus set it.",
    kind: Kind::Choice {
        default: OF_LENS,
        options: &[
            c"As Lens", c"Round", c"3", c"4", c"5", c"6", c"7", c"8", c"9", c"10", c"11", c"12",
            c"13",
        ],
    },
};

pub(crate) static USE_APERTURE: Knob = Knob {
    name: c"useAperture",
    label: c"Use Aperture",
    hint: c"Discs show the picture of the input Aperture: white where light passes, its shorter side as wide as the pupil.",
    kind: Kind::Switch(false),
};

pub(crate) static GROUP: Group = Group {
    name: c"lookGroup",
    label: c"Look",
    open: false,
    own: &[
        Own::first(&PRESET),
        Own::first(&BLADES),
        Own::after("rotation", &USE_APERTURE),
    ],
    table: Rows::Of(HostGroup::Look),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_set_every_knob_of_the_look() {
        assert!(preset_changes(0).is_empty());
        assert!(preset_changes(-1).is_empty());
        let menu = preset_labels();
        assert_eq!(menu.len(), 1 + LookPreset::all().len());
        let neutral = preset_changes(1);
        for index in 2..=menu.len() as i32 {
            let changes = preset_changes(index);
            let names = |changes: &[Change]| changes.iter().map(|c| c.0).collect::<Vec<_>>();
            assert_eq!(names(&changes), names(&neutral));
            assert_ne!(changes, neutral, "{:?}", menu[index as usize - 1]);
        }
        for count in [None, Some(0), Some(3), Some(13)] {
            assert_eq!(blade_count(blade_index(count)), count);
        }
    }
}
