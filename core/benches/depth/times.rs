//! Times of renders with depth, as ratios.

use super::aim::{Aim, Wanted};
use super::lens;
use super::plates::{FOLIAGE, RAMP, plate, shot};
use seidel_core::{
    Controls, Lens, LensSession, ObjectDistance, Plate, Quality, RenderWindow, Result, Settings,
    apply, no_progress,
};
use std::sync::Arc;
use std::time::Instant;

const HD: usize = 1920;
const UHD: usize = 3840;

/// The timed renders.
#[derive(Clone, Copy)]
enum Case {
    First,
    Next,
    Again,
    OtherFocus,
    Quarter,
    Draft,
    Moments,
    Ramp,
    Foliage,
}

const CASES: usize = Case::Foliage as usize + 1;

/// Returns the aims of time. Cases take turns `rounds` times; the frame of 3840 x 2160 is rendered once.
pub(crate) fn aims(moments: &Lens, rounds: usize) -> Result<Vec<Aim>> {
    let (first, next) = (plate(&shot(0), HD)?, plate(&shot(1), HD)?);
    let (ramp, foliage) = (plate(&RAMP, HD)?, plate(&FOLIAGE, HD)?);
    let settings = Settings::default();
    let mut refocused = Settings::default();
    refocused.controls = Controls {
        focus_distance: Some(ObjectDistance::metres(2.2)?),
        ..Controls::default()
    };
    let mut draft = Settings::default();
    draft.quality = Quality::Draft;
    let mut times: [Vec<f64>; CASES] = Default::default();
    for round in 1..=rounds {
        eprintln!("times: round {round} of {rounds}");
        let mut note = |case: Case, seconds: f64| times[case as usize].push(seconds);
        let kept = lens()?;
        note(Case::First, seconds(&kept, &first, &settings)?);
        note(Case::Next, seconds(&kept, &next, &settings)?);
        note(Case::Again, seconds(&kept, &next, &settings)?);
        note(Case::OtherFocus, seconds(&kept, &next, &refocused)?);
        note(Case::Quarter, seconds_of_quarter(&first, &settings)?);
        note(Case::Draft, seconds(&lens()?, &first, &draft)?);
        note(Case::Moments, seconds(moments, &first, &settings)?);
        note(Case::Ramp, seconds(&lens()?, &ramp, &settings)?);
        note(Case::Foliage, seconds(&lens()?, &foliage, &settings)?);
    }
    eprintln!("times: {UHD} x {}", UHD * 9 / 16);
    let uhd = seconds(&lens()?, &plate(&shot(0), UHD)?, &settings)?;
    let medians = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    let of = |case: Case| medians[case as usize];
    let share = |case: Case| 100.0 * of(case) / of(Case::First);
    let at_most =
        |what: &str, most: f64, unit, found: f64| Aim::new(what, Wanted::AtMost(most), unit, found);
    Ok(vec![
        at_most("HD shot, first frame", 1.0, "s", of(Case::First)),
        at_most("the next frame", 60.0, "%", share(Case::Next)),
        at_most("the same frame again", 60.0, "%", share(Case::Again)),
        at_most(
            "the same frame, another focus",
            60.0,
            "%",
            share(Case::OtherFocus),
        ),
        at_most("a quarter of the frame", 40.0, "%", share(Case::Quarter)),
        at_most("draft / final", 100.0 / 3.0, "%", share(Case::Draft)),
        at_most("3840 x 2160 / HD", 5.0, "", uhd / of(Case::First)),
        at_most(
            "ray by ray / moments",
            2.0,
            "",
            of(Case::First) / of(Case::Moments),
        ),
        at_most(
            "foliage / ramp",
            1.5,
            "",
            of(Case::Foliage) / of(Case::Ramp),
        ),
    ])
}

fn seconds(lens: &Lens, plate: &Plate, settings: &Settings) -> Result<f64> {
    let start = Instant::now();
    apply(lens, plate, settings, &no_progress)?;
    Ok(start.elapsed().as_secs_f64())
}

/// Returns the seconds of the middle quarter of `plate`, of [`HD`] columns.
fn seconds_of_quarter(plate: &Plate, settings: &Settings) -> Result<f64> {
    let lens = lens()?;
    let start = Instant::now();
    let session = Arc::new(LensSession::new(&lens, settings)?);
    let (width, height) = (HD, HD * 9 / 16);
    let window = RenderWindow {
        column: width / 4,
        row: height / 4,
        width: width / 2,
        height: height / 2,
    };
    let prepared = session.prepare(plate.clone())?;
    prepared.apply_window(window, &no_progress)?;
    Ok(start.elapsed().as_secs_f64())
}
