//! The lens that took a shot, compared with that of a profile.

use seidel_optics::camera::Camera;

use super::record::FrameRecord;

const MODEL: &str = "lens model";
const SERIAL_NUMBER: &str = "lens serial number";

/// Returns a note on the lens that took the shot: its names, and whether the profile of `camera` is of another.
pub fn identity_note(record: &FrameRecord, camera: &Camera) -> Option<String> {
    let stated = |name| record.identity.get(name).map(String::as_str);
    let serial = |text: &str| format!("serial number {text}");
    let make = stated("lens make").map(str::to_owned);
    let own = [
        make,
        stated(MODEL).map(str::to_owned),
        stated(SERIAL_NUMBER).map(serial),
    ];
    let own: Vec<String> = own.into_iter().flatten().collect();
    if own.is_empty() {
        return None;
    }
    let own = own.join(", ");
    let model = camera.lens_model.as_deref();
    let number = camera.lens_serial_number.as_deref();
    let is_another = |a: Option<&str>, b: Option<&str>, agree: fn(&str, &str) -> bool| {
        a.zip(b).is_some_and(|(a, b)| !agree(a, b))
    };
    if !is_another(stated(MODEL), model, is_same_model)
        && !is_another(stated(SERIAL_NUMBER), number, is_same_number)
    {
        return Some(format!("lens of the shot: {own}"));
    }
    let of_profile = [model.map(str::to_owned), number.map(serial)];
    let of_profile: Vec<String> = of_profile.into_iter().flatten().collect();
    Some(format!(
        "the lens of the shot is {own}, that of the profile {}: check that the profile is of this lens",
        of_profile.join(", ")
    ))
}

/// Returns whether two names may be of one lens: makers and spaces are left out at will.
fn is_same_model(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(letters);
    a.contains(&b) || b.contains(&a)
}

fn is_same_number(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(letters);
    a.trim_start_matches('0') == b.trim_start_matches('0')
}

/// Returns letters and digits in lower case.
fn letters(text: &str) -> String {
    let kept = text.chars().filter(|c| c.is_alphanumeric());
    kept.flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_lens_than_that_of_the_profile_is_named() {
        let note = |model: &str, number: &str, own: [Option<&str>; 2]| {
            let mut record = FrameRecord::default();
            for (name, text) in [(MODEL, model), (SERIAL_NUMBER, number)] {
                if !text.is_empty() {
                    record.identity.insert(name, text.to_owned());
                }
            }
            let [lens_model, lens_serial_number] = own.map(|text| text.map(str::to_owned));
            let camera = Camera {
                lens_model,
                lens_serial_number,
                ..Camera::default()
            };
            identity_note(&record, &camera)
        };
        let cooke = [Some("S4/i 40 mm"), Some("007")];
        let same = note("Cooke S4/i 40mm", "7", cooke).expect("named");
        assert_eq!(same, "lens of the shot: Cooke S4/i 40mm, serial number 7");
        for (model, number) in [("S4/i 50mm", "7"), ("S4/i 40mm", "8"), ("", "8")] {
            let other = note(model, number, cooke).expect("named");
            assert!(
                other.contains("that of the profile S4/i 40 mm, serial number 007: check"),
                "{other}"
            );
        }
        let unknown = note("S4/i 50mm", "7", [None, None]).expect("named");
        assert!(unknown.starts_with("lens of the shot: "), "{unknown}");
        assert_eq!(note("", "", cooke), None);
    }
}
