//! Statements of set and lens about the camera, compared.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{Controls, LensProfile};

/// Largest ratio of two statements of one number that agree: markings are rounded.
const AGREE: f64 = 1.06;
/// Ratio of the gaps with and without the statement of the set, below which the set describes its camera better than the lens does.
const DESCRIBES: f64 = 0.8;
/// Gap from which on a prediction can judge between the statements.
const MIN_GAP: f64 = 0.01;

/// A contradiction between what a set and a lens state of the camera.
pub(super) struct Contradiction {
    /// The statements, in words.
    pub(super) words: String,
    pub(super) side: Side,
}

/// The side that the tiles support.
pub(super) enum Side {
    /// The tiles are those of the lens as it stands, by its predictions.
    Lens,
    /// No prediction decides: predictions do not depend on the stated pixel pitch and focal length.
    Undecided,
    /// The lens agrees better with the tiles at the settings that the set states: the gap of that.
    Set(f64),
}

/// A number that set and lens state.
struct Statement {
    name: &'static str,
    unit: &'static str,
    of_set: f64,
    of_lens: f64,
}

impl Statement {
    fn differs(&self) -> bool {
        let (a, b) = (self.of_set.abs(), self.of_lens.abs());
        a.max(b) > AGREE * a.min(b)
    }

    fn words(&self) -> String {
        let Self {
            name,
            unit,
            of_set,
            of_lens,
        } = self;
        format!("a {name} of {of_set}{unit}, the lens {of_lens}{unit}")
    }
}

/// Returns the contradiction between `set` and `lens`; `None` where they agree or leave it out. `gap` measures the set against a lens, and
/// gives `before` for the lens as it stands.
pub(super) fn contradiction(
    lens: &LensProfile,
    set: &ObservationSet,
    before: f64,
    gap: impl Fn(&LensProfile) -> Option<f64>,
) -> Option<Contradiction> {
    let stated = statements(lens, set);
    let wrong: Vec<&Statement> = stated.iter().filter(|s| s.differs()).collect();
    if wrong.is_empty() {
        return None;
    }
    let words: Vec<String> = wrong.iter().map(|s| s.words()).collect();
    let differs = |name: &str| wrong.iter().any(|s| s.name == name);
    let controls = Controls {
        f_number: set.camera.f_number.filter(|_| differs(F_NUMBER)),
        focus_distance: Some(set.camera.focus_distance).filter(|_| differs(FOCUS)),
        ..Controls::default()
    };
    let at_settings = (before > MIN_GAP && !controls.is_empty())
        .then(|| gap(&lens.with_controls(&controls).ok()?))
        .flatten();
    let side = match at_settings {
        Some(after) if after < DESCRIBES * before => Side::Set(after.max(0.0)),
        None if before > MIN_GAP => Side::Undecided,
        _ => Side::Lens,
    };
    Some(Contradiction {
        words: format!("the set states {}", words.join("; ")),
        side,
    })
}

const F_NUMBER: &str = "f-number";
const FOCUS: &str = "focus distance";

/// Returns the numbers that both state.
fn statements(lens: &LensProfile, set: &ObservationSet) -> Vec<Statement> {
    let metres = |distance: ObjectDistance| match distance {
        ObjectDistance::Metres(metres) => Some(metres),
        ObjectDistance::Infinity | ObjectDistance::Unknown => None,
    };
    let statement = |name, unit, of_set: Option<f64>, of_lens: Option<f64>| {
        Some(Statement {
            name,
            unit,
            of_set: of_set?,
            of_lens: of_lens?,
        })
    };
    let (own, theirs) = (&set.camera, &lens.camera);
    let all = [
        statement(
            "pixel pitch",
            " µm",
            set.pixel_pitch_um,
            lens.pixel_pitch_um,
        ),
        statement(
            "focal length",
            " mm",
            own.focal_length_mm,
            theirs.focal_length_mm,
        ),
        statement(F_NUMBER, "", own.f_number, theirs.f_number),
        statement(
            FOCUS,
            " m",
            metres(own.focus_distance),
            metres(theirs.focus_distance),
        ),
    ];
    all.into_iter().flatten().collect()
}
