//! Looks with a name: values of the knobs of a look that belong together.

use super::Knob;

/// A look with a name.
#[derive(Debug)]
pub struct LookPreset {
    /// The word for the option `--look`.
    pub name: &'static str,
    /// The entry in the menu of a host.
    pub label: &'static str,
    /// One sentence without a full stop.
    pub help: &'static str,
    /// Iris blades in place of the lens's own, 0 for a round iris; `None` keeps those.
    pub blades: Option<u32>,
    /// The knobs that are not at their defaults.
    numbers: &'static [(&'static str, f64)],
}

static ALL: [LookPreset; 6] = [
    LookPreset {
        name: "portrait",
        label: "Portrait",
        help: "Discs with soft edges, round over most of the field, and half the colour fringes",
        blades: Some(0),
        numbers: &[
            ("cats-eye", -0.5),
            ("spherical", -0.6),
            ("axial-colour", 0.5),
            ("lateral-colour", 0.5),
        ],
    },
    LookPreset {
        name: "swirl",
        label: "Swirl",
        help: "Cat's eyes that turn around the centre of the picture",
        blades: Some(0),
        numbers: &[("cats-eye", 1.0), ("spherical", 0.3)],
    },
    LookPreset {
        name: "bubble",
        label: "Bubble",
        help: "Round discs with bright rims",
        blades: Some(0),
        numbers: &[("cats-eye", -0.5), ("spherical", 1.0)],
    },
    LookPreset {
        name: "anamorphic",
        label: "Anamorphic",
        help: "Upright ovals, as of a 2x anamorphic lens",
        blades: Some(0),
        numbers: &[("squeeze", 2.0), ("cats-eye", 0.2)],
    },
    LookPreset {
        name: "catadioptric",
        label: "Catadioptric",
        help: "Rings without colour fringes, as of a mirror lens",
        blades: Some(0),
        numbers: &[
            ("obstruction", 0.5),
            ("axial-colour", 0.0),
            ("lateral-colour", 0.0),
        ],
    },
    LookPreset {
        name: "miniature",
        label: "Miniature",
        help: "A small model: one strip of the ground is sharp, all above and below it blurred",
        blades: None,
        numbers: &[("tilt", 8.0), ("tilt-direction", -90.0)],
    },
];

impl LookPreset {
    /// Returns all presets, in the order of menus. Projects store the values of the knobs, not the preset.
    pub fn all() -> &'static [Self] {
        &ALL
    }

    /// Returns the preset called `name`.
    pub fn named(name: &str) -> Option<&'static Self> {
        ALL.iter().find(|preset| preset.name == name)
    }

    /// Returns the numbers of a look with the values that the preset gives them. Bloom is not among them.
    pub fn values(&self) -> impl Iterator<Item = (&'static Knob, f64)> {
        Knob::numbers_of_look().map(|(knob, default)| {
            let own = self.numbers.iter().find(|(name, _)| *name == knob.name);
            (knob, own.map_or(default, |(_, value)| *value))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn presets_are_valid_looks_and_differ() {
        let mut looks = vec![Settings::default().look];
        for preset in LookPreset::all() {
            let found = LookPreset::named(preset.name).expect("its name");
            assert_eq!(found.label, preset.label);
            assert!(!preset.help.ends_with('.'));
            for (name, _) in preset.numbers {
                assert!(Knob::named(name).is_some_and(Knob::is_of_look), "{name}");
            }
            let mut settings = Settings::default();
            settings.look.blades = preset.blades.map(crate::Blades::straight);
            for (knob, value) in preset.values() {
                knob.put_number(value, &mut settings).expect("in its range");
            }
            assert!(!looks.contains(&settings.look), "{}", preset.name);
            looks.push(settings.look);
        }
    }
}
