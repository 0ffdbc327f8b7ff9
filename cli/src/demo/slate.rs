//! The slate at the focus: print to judge sharpness by.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};

use super::ray::{V3, v3};

/// Size of the board, and height of each of the two sticks above it, m.
const WIDTH_M: f64 = 0.33;
const HEIGHT_M: f64 = 0.264;
const STICK_M: f64 = 0.036;
/// Opening of the upper stick: rise over run.
const OPENING: f64 = 0.24;

const PAPER: V3 = v3(0.74, 0.73, 0.70);
const INK: V3 = v3(0.018, 0.019, 0.021);
const BOARD: V3 = v3(0.030, 0.033, 0.036);

/// First and last row of the capitals of the font.
const CAPITALS: (f64, f64) = (8.0, 25.0);

/// Patches of a colour chart.
const PATCHES: [V3; 6] = [
    v3(0.10, 0.045, 0.030),
    v3(0.52, 0.28, 0.20),
    v3(0.62, 0.16, 0.02),
    v3(0.02, 0.22, 0.24),
    v3(0.40, 0.03, 0.03),
    v3(0.78, 0.55, 0.02),
];

/// Returns the reflectance at `x` from the middle and `y` above the ground, m; `None` off the slate.
pub(super) fn reflectance(x: f64, y: f64) -> Option<V3> {
    let u = x / WIDTH_M + 0.5;
    if !(0.0..1.0).contains(&u) || y < 0.0 {
        return None;
    }
    let lower = y - HEIGHT_M;
    let upper = lower - STICK_M - 0.004 - OPENING * u * WIDTH_M;
    if lower < 0.0 {
        return Some(board(u, -lower / HEIGHT_M));
    }
    let stripes = |v: f64| two_tone(u * 7.0 + v);
    if lower < STICK_M {
        return Some(stripes(-0.55 * lower / STICK_M));
    }
    (0.0..STICK_M)
        .contains(&upper)
        .then(|| stripes(0.55 * upper / STICK_M))
}

/// Returns the reflectance of the board at (`u`, `v`), 0 to 1 across and down.
fn board(u: f64, v: f64) -> V3 {
    // Distances from the centre of the star; the board is 1.25 times as wide as high.
    let (x, y) = ((u - 0.73) * 1.25, v - 0.53);
    let words = text("SEIDEL", (u - 0.05) / 0.11, (v - 0.05) / 0.17)
        || text("50MM F/.95", (u - 0.05) / 0.042, (v - 0.30) / 0.07)
        || text("FOCUS 2 M", (u - 0.05) / 0.042, (v - 0.40) / 0.07);
    if words || (v - 0.255).abs() < 0.0035 || (v - 0.80).abs() < 0.0035 {
        return PAPER;
    }
    match (u, v) {
        (0.05..0.95, 0.83..0.96) => PATCHES[((u - 0.05) / 0.15) as usize],
        // Bars of rising fineness.
        (0.05..0.43, 0.53..0.76) => two_tone((u - 0.05) * (40.0 + 130.0 * u)),
        // A Siemens star in a ring.
        _ => match x.hypot(y) {
            0.012..0.245 => two_tone(y.atan2(x) / std::f64::consts::TAU * 36.0),
            ..0.255 => PAPER,
            _ => BOARD,
        },
    }
}

/// Returns paper or ink, in turn for each half unit of `turn`.
fn two_tone(turn: f64) -> V3 {
    if turn.rem_euclid(1.0) < 0.5 {
        PAPER
    } else {
        INK
    }
}

/// Returns whether `text` has ink at (`x`, `y`): a character per unit of x, one line for y in 0..1.
fn text(text: &str, x: f64, y: f64) -> bool {
    if x < 0.0 || !(0.0..1.0).contains(&y) {
        return false;
    }
    let character = text.chars().nth(x as usize);
    let glyph = character.and_then(|c| get_raster(c, FontWeight::Regular, RasterHeight::Size32));
    glyph.is_some_and(|glyph| {
        let column = (x.fract() * glyph.width() as f64) as usize;
        let row = CAPITALS.0 + y * (CAPITALS.1 - CAPITALS.0);
        glyph
            .pixel(column, row as usize)
            .is_some_and(|cover| cover > 127)
    })
}
