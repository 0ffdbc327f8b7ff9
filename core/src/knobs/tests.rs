//! Names, defaults and ranges of the table, and that knobs read back what they write.

use std::collections::BTreeSet;

use super::*;

#[test]
fn names_are_unique_and_helps_are_one_sentence() {
    let mut names = BTreeSet::new();
    for knob in Knob::all() {
        assert!(names.insert(knob.name), "{}", knob.name);
        assert!(!knob.help.ends_with('.'), "{}", knob.name);
        assert!(knob.details.is_empty() || knob.details.ends_with('.'));
        assert!(std::ptr::eq(
            Knob::named(knob.name).expect("its name"),
            knob
        ));
    }
}

/// Settings in which every knob has a place: blades, bloom and a clip level are given.
fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.look.blades = Some(seidel_optics::profile::Blades {
        count: 5,
        roundness: 0.0,
        rotation_deg: 0.0,
    });
    settings.bloom = Some(seidel_render::Bloom::default());
    settings.removal.saturation = seidel_render::remove::Saturation::Level(1.0);
    settings
}

#[test]
fn defaults_of_the_table_are_those_of_the_settings() {
    let defaults = Settings::default();
    let mut set = Settings::default();
    for knob in Knob::all() {
        match &knob.kind {
            KnobKind::Number(number) => {
                let found = (number.get)(&settings());
                let share = (knob.name == "bloom").then_some(0.0);
                let level = (knob.name == "clip-level").then_some(1.0);
                assert_eq!(found.or(share).or(level), number.default, "{}", knob.name);
                let (least, most) = number.range;
                assert!(number.default.is_none_or(|v| (least..=most).contains(&v)));
                assert_eq!(number.default.is_none(), !number.absent.is_empty());
                if let Some(default) = number.default {
                    knob.put_number(default, &mut set).expect("a default");
                }
            }
            KnobKind::Choice(choice) => {
                assert_eq!((choice.get)(&defaults), choice.default, "{}", knob.name);
                knob.put_index(choice.default, &mut set).expect("a default");
            }
            KnobKind::Switch(switch) => {
                assert_eq!((switch.get)(&defaults), switch.default, "{}", knob.name);
                knob.put_index(usize::from(switch.default), &mut set)
                    .expect("a default");
            }
        }
    }
    assert_eq!(set, defaults);
}

#[test]
fn knobs_read_back_what_they_write() {
    for knob in Knob::all() {
        let mut settings = settings();
        match &knob.kind {
            KnobKind::Number(number) => {
                let value = number.slider.1;
                knob.put_number(value, &mut settings)
                    .expect("a usual value");
                let found = (number.get)(&settings).expect("the value");
                assert!((found - value).abs() < 1e-12 * value.abs(), "{}", knob.name);
            }
            KnobKind::Choice(choice) => {
                for index in 0..choice.options.len() {
                    knob.put_index(index, &mut settings).expect("an option");
                    assert_eq!((choice.get)(&settings), index, "{}", knob.name);
                    assert_eq!(choice.index_of(choice.options[index].word), Some(index));
                }
                assert!(knob.put_index(choice.options.len(), &mut settings).is_err());
            }
            KnobKind::Switch(switch) => {
                for is_on in [true, false] {
                    knob.put_index(usize::from(is_on), &mut settings)
                        .expect("a state");
                    assert_eq!((switch.get)(&settings), is_on, "{}", knob.name);
                }
                assert!(knob.put_index(2, &mut settings).is_err());
            }
        }
    }
}

#[test]
fn numbers_out_of_range_are_refused_wherever_they_were_set() {
    for knob in Knob::all() {
        let Some(number) = knob.number() else {
            continue;
        };
        let (least, most) = number.range;
        // Clear of the rounding of units.
        let (below, above) = (
            least - 1e-6 * (1.0 + least.abs()),
            most + 1e-6 * (1.0 + most.abs()),
        );
        for bad in [f64::NAN, below, above, f64::NEG_INFINITY] {
            if (least..=most).contains(&bad) {
                continue;
            }
            let error = knob.put_number(bad, &mut settings()).expect_err("refused");
            assert_eq!(error.place, knob.name);
            let mut given = settings();
            (number.set)(&mut given, bad);
            // What cannot be represented cannot be set either.
            if (number.get)(&given).is_some_and(|value| !(value == 0.0 && least == 0.0)) {
                let error = check(&given).expect_err("refused");
                assert_eq!(error.place, knob.name);
            }
        }
    }
}

#[test]
fn ranges_read_as_words() {
    let words = |name: &str| {
        let knob = Knob::named(name).expect("a knob");
        knob.number().expect("a number").range_words()
    };
    assert_eq!(words("amount"), "0 to 16");
    assert_eq!(words("focus-distance"), "above 0 metres, or inf");
    assert_eq!(words("rotation"), "-180 to 180 degrees");
    assert_eq!(words("bloom-level"), "0 or more scene-linear");
}
