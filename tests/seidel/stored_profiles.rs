//! Lens profiles as each version of the format was written: they are read, and mean what they meant.

use seidel_core::{ImagePoint, Lens, ObjectDistance};

/// A stored profile with the variances (x, y) of its blur, px², at each of [`PLACES`] for objects at infinity and at 3 m.
struct Stored {
    name: &'static str,
    json: &'static str,
    channel: &'static str,
    variances: [[f64; 2]; 6],
}

/// Places as shares of the frame.
const PLACES: [[f64; 2]; 3] = [[0.1, 0.95], [0.5, 0.75], [0.8, 0.6]];

const STORED: [Stored; 3] = [
    Stored {
        name: "version 1, moments",
        json: include_str!("../profiles/version-1-moments.json"),
        channel: "G",
        variances: [
            [0.16115750033750603, 0.1383186179205079],
            [0.16115750033750603, 0.1383186179205079],
            [0.16983340932746638, 0.1786716408867072],
            [0.16983340932746638, 0.1786716408867072],
            [0.18473697517717744, 0.15730749104922154],
            [0.18473697517717744, 0.15730749104922154],
        ],
    },
    Stored {
        name: "version 1, reduced",
        json: include_str!("../profiles/version-1-reduced.json"),
        channel: "R",
        variances: [
            [0.08618629814406395, 0.07825128356420888],
            [0.08618629814406395, 0.07825128356420888],
            [0.080931952463675, 0.08417096779114529],
            [0.080931952463675, 0.08417096779114529],
            [0.08729957424654293, 0.07740675185457013],
            [0.08729957424654293, 0.07740675185457013],
        ],
    },
    Stored {
        name: "version 1, designed",
        json: include_str!("../profiles/version-1-designed.json"),
        channel: "B",
        variances: [
            [590.3457523105006, 562.5385712046784],
            [59.94813498153373, 51.37458482809214],
            [582.3923539808754, 588.1732525589895],
            [56.76708418741375, 58.58299216402324],
            [594.6649938818402, 569.3568991927709],
            [60.80429175755154, 52.90691135419636],
        ],
    },
];

#[test]
fn stored_profiles_of_every_version_mean_the_same() {
    for stored in &STORED {
        let lens = Lens::from_json(stored.json).expect(stored.name);
        let again = Lens::from_json(&lens.to_json()).expect(stored.name);
        for lens in [lens, again] {
            let frame = lens.profile().frame;
            let distances = [
                ObjectDistance::Infinity,
                ObjectDistance::metres(3.0).expect("a distance"),
            ];
            let cases = PLACES
                .iter()
                .flat_map(|place| distances.map(|d| (place, d)));
            for ((place, distance), expected) in cases.zip(stored.variances) {
                let at = ImagePoint::new(
                    f64::from(frame.width_px()) * place[0],
                    f64::from(frame.height_px()) * place[1],
                );
                let blur = lens.blur_at(stored.channel, at, distance);
                let moments = blur.expect(stored.name).moments;
                for (found, expected) in [moments.mu20, moments.mu02].into_iter().zip(expected) {
                    let error = (found / expected - 1.0).abs();
                    assert!(
                        error < 1e-9,
                        "{} {place:?} {distance:?}: {found}",
                        stored.name
                    );
                }
            }
        }
    }
}
