//! What is printed on the slate: fine detail to judge sharpness by.

use font8x8::{BASIC_FONTS, UnicodeFonts};

use super::vector::V3;

const PAPER: V3 = V3(0.74, 0.73, 0.70);
const INK: V3 = V3(0.018, 0.019, 0.021);
const BOARD: V3 = V3(0.030, 0.033, 0.036);

/// Six patches of a colour chart, linear.
const PATCHES: [V3; 6] = [
    V3(0.10, 0.045, 0.030),
    V3(0.52, 0.28, 0.20),
    V3(0.62, 0.16, 0.02),
    V3(0.02, 0.22, 0.24),
    V3(0.40, 0.03, 0.03),
    V3(0.78, 0.55, 0.02),
];

/// Reflectance of the slate's board at (`u`, `v`): 0..1 across and down.
pub(super) fn board(u: f64, v: f64) -> V3 {
    let chalk = PAPER * 0.9;
    let line = |a: f64, at: f64| (a - at).abs() < 0.0035;
    if !(0.018..=0.982).contains(&u) || !(0.02..=0.98).contains(&v) {
        return BOARD;
    }
    if v < 0.24 {
        let on = text("SEIDEL", (u - 0.05) / 0.062, (v - 0.055) / 0.14);
        let small = text("50MM F/0.95", (u - 0.50) / 0.041, (v - 0.055) / 0.055)
            || text("FOCUS 2.0 M", (u - 0.50) / 0.041, (v - 0.14) / 0.055);
        return if on || small { chalk } else { BOARD };
    }
    if line(v, 0.245) || (v < 0.80 && v > 0.245 && line(u, 0.49)) || line(v, 0.80) {
        return chalk;
    }
    if v > 0.80 {
        return footer(u, (v - 0.80) / 0.18);
    }
    if u < 0.49 {
        return left_half(u / 0.49, (v - 0.245) / 0.555);
    }
    // The board is 1.25 times as wide as high.
    siemens_star((u - 0.736) * 1.25, v - 0.522)
}

/// Words over lines of rising fineness.
fn left_half(u: f64, v: f64) -> V3 {
    let chalk = PAPER * 0.9;
    if v < 0.46 {
        let on = text("SCENE 22", (u - 0.08) / 0.108, (v - 0.09) / 0.14)
            || text("TAKE  01", (u - 0.08) / 0.108, (v - 0.28) / 0.14);
        return if on { chalk } else { BOARD };
    }
    let inside = u > 0.08 && u < 0.94 && v < 0.92;
    if !inside {
        return BOARD;
    }
    let across = (u - 0.08) / 0.86;
    let block = (across * 4.0).floor();
    let within = across * 4.0 - block;
    if !(0.06..0.94).contains(&within) {
        return BOARD;
    }
    let pairs = [5.0, 8.0, 12.0, 17.0][block.clamp(0.0, 3.0) as usize];
    let bars = if v < 0.68 {
        within
    } else {
        (v - 0.46) / 0.46 * 1.15
    };
    let on = (bars * pairs).fract() < 0.5 && !(0.67..=0.70).contains(&v);
    if on { PAPER } else { INK }
}

/// Spokes that grow finer towards the middle, in a ring.
fn siemens_star(x: f64, y: f64) -> V3 {
    let r = x.hypot(y);
    if r > 0.268 {
        return BOARD;
    }
    if !(0.012..=0.255).contains(&r) {
        return PAPER;
    }
    let spokes = 36.0;
    let turn = y.atan2(x) / std::f64::consts::TAU * spokes;
    if turn.rem_euclid(1.0) < 0.5 {
        PAPER
    } else {
        INK
    }
}

/// Colour patches, then a fine checker.
fn footer(u: f64, v: f64) -> V3 {
    if !(0.16..0.90).contains(&v) {
        return BOARD;
    }
    if (0.05..0.62).contains(&u) {
        let place = (u - 0.05) / 0.57 * 6.0;
        let index = place.floor().clamp(0.0, 5.0);
        let gap = place - index;
        return if (0.05..0.95).contains(&gap) {
            PATCHES[index as usize]
        } else {
            INK
        };
    }
    if (0.66..0.95).contains(&u) {
        let (i, j) = ((u - 0.66) * 76.0, v * 10.0);
        let odd = (i as i64 + j as i64) % 2 != 0;
        return if odd { PAPER } else { INK };
    }
    BOARD
}

/// Slanted stripes of the clapper stick at (`u`, `v`): 0..1 across and down.
pub(super) fn stick(u: f64, v: f64) -> V3 {
    if (u * 7.0 + v * 0.55).rem_euclid(1.0) < 0.5 {
        PAPER
    } else {
        INK
    }
}

/// Squares on a ball at longitude and latitude, radians.
pub(super) fn checker(longitude: f64, latitude: f64) -> V3 {
    let (i, j) = (
        (longitude * 4.6).floor() as i64,
        (latitude * 4.6).floor() as i64,
    );
    if (i + j).rem_euclid(2) == 0 {
        V3(0.62, 0.21, 0.045)
    } else {
        V3(0.030, 0.034, 0.038)
    }
}

/// Whether `text` has ink at (`x`, `y`): one character to a unit of x, one line high for y in 0..1.
fn text(text: &str, x: f64, y: f64) -> bool {
    if x < 0.0 || !(0.0..1.0).contains(&y) {
        return false;
    }
    let Some(glyph) = text
        .chars()
        .nth(x as usize)
        .and_then(|c| BASIC_FONTS.get(c))
    else {
        return false;
    };
    let (column, row) = ((x.fract() * 8.0) as u32, (y * 8.0) as usize);
    glyph[row.min(7)] & (1 << column) != 0
}
