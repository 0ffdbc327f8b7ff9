//! Effects on the pencil, one function for each effect, with random parameters.

use super::change;
use super::lens::{Lens, Place};
use super::mask::Blades;
use super::pencil::Pencil;
use super::perturb_sensor as sensor;
use super::rng::Rng;

/// A function that applies a change of given strength to a pencil.
pub(super) type Perturbation = Box<dyn Fn(f64, &Lens, &Place, &mut Pencil) + Send + Sync>;

/// A cause of the third-order simulator with all parameters drawn except its strength.
pub(super) type Change = change::Change<Perturbation>;

impl Change {
    pub(super) fn new(
        id: &'static str,
        range: [f64; 2],
        apply: impl Fn(f64, &Lens, &Place, &mut Pencil) + Send + Sync + 'static,
    ) -> Self {
        Self::with_action(id, range, Box::new(apply))
    }
}

/// Phase of a focus error by vergence, m: neighbouring distances have errors of their own.
const FOCUS_ERROR_PHASE_M: f64 = 100.0;

/// Draws the effect `id` for `lens`.
///
/// # Panics
/// If `id` is neither one of [`super::third_order::EFFECTS`] nor `focus_error`, which no deck of blind cases holds.
pub(super) fn effect(id: &str, lens: &Lens, rng: &mut Rng) -> Change {
    match id {
        "defocus_offset" => defocus_offset(rng),
        "depth_scale" => depth_scale(rng),
        "focus_error" => focus_error(rng),
        "sensor_tilt" => sensor_tilt(rng),
        "decentre" => decentre(rng),
        "diffraction" => diffraction(lens),
        "vignetting" => vignetting(rng),
        "aperture_polygon" => aperture_polygon(rng),
        "apodisation" => apodisation(),
        "higher_order" => higher_order(rng),
        "axial_colour" => axial_colour(rng),
        "lateral_colour" => lateral_colour(rng),
        "distortion" => distortion(rng),
        "anamorphic" => anamorphic(rng),
        "pixel_footprint" => sensor::pixel_footprint(rng),
        "motion" => sensor::motion(rng),
        "veiling_glare" => sensor::veiling_glare(rng),
        "pupil_scale" => pupil_scale(rng),
        "tone_curve" => sensor::tone_curve(rng),
        _ => panic!("`{id}` is not on the list of effects"),
    }
}

/// Returns the factor of a channel for colour errors, which have opposite signs in red and blue: 1 for red.
fn colour(place: &Place, green: f64, blue: f64) -> f64 {
    [1.0, green, blue][place.channel]
}

/// Adds `px` of defocus by a sensor shift, with the change of magnification.
///
/// `tele` is 1 for a thin lens and 0 for an image-side telecentric lens.
fn refocus(px: f64, tele: f64, lens: &Lens, pencil: &mut Pencil) {
    pencil.defocus(px);
    let growth = px * lens.growth_per_px() * tele * lens.frame.half_width_px();
    pencil.chief[0] += growth * pencil.field[0];
    pencil.chief[1] += growth * pencil.field[1];
}

fn defocus_offset(rng: &mut Rng) -> Change {
    let (sign, tele) = (rng.sign(), rng.between(0.3, 1.0));
    Change::new("defocus_offset", [0.02, 2.5], move |t, lens, _, pencil| {
        refocus(sign * t, tele, lens, pencil);
    })
    .scaled("alpha", sign)
    .fixed("growth_share", tele)
}

/// Each distance has another focus, without a rule.
fn focus_error(rng: &mut Rng) -> Change {
    let (phase, tele) = (
        rng.between(0.0, std::f64::consts::TAU),
        rng.between(0.3, 1.0),
    );
    Change::new("focus_error", [0.02, 2.5], move |t, lens, place, pencil| {
        let error = libm::sin(phase + FOCUS_ERROR_PHASE_M / place.depth_m);
        refocus(t * error, tele, lens, pencil);
    })
    .fixed("phase", phase)
    .fixed("growth_share", tele)
}

fn depth_scale(rng: &mut Rng) -> Change {
    let sign = rng.sign();
    // True distances are exp(sign t) times the stated ones.
    Change::new(
        "depth_scale",
        [0.001, 0.3],
        move |t, lens, place, pencil| {
            let stated = 1.0 / place.depth_m;
            pencil.defocus(lens.alpha(stated * libm::exp(-sign * t)) - lens.alpha(stated));
        },
    )
    .scaled("log_factor", sign)
}

fn sensor_tilt(rng: &mut Rng) -> Change {
    let (d, tele) = (rng.direction(), rng.between(0.3, 1.0));
    Change::new("sensor_tilt", [0.05, 5.0], move |t, lens, _, pencil| {
        let [x, y] = pencil.field;
        refocus(t * (d[0] * x + d[1] * y), tele, lens, pencil);
    })
    .scaled("alpha_by_x", d[0])
    .scaled("alpha_by_y", d[1])
    .fixed("keystone_share", tele)
}

fn decentre(rng: &mut Rng) -> Change {
    let n = rng.direction();
    let (astigmatism, focus) = (rng.signed(0.3, 1.2), rng.signed(0.3, 1.2));
    let (shift, prism) = (rng.between(0.4, 1.2), rng.signed(0.1, 0.3));
    Change::new("decentre", [0.02, 2.0], move |t, _, place, pencil| {
        let [x, y] = pencil.field;
        let [cx, cy] = [t * n[0], t * n[1]];
        pencil.coma[0] += cx;
        pencil.coma[1] += cy;
        // The wavefront a (X.u)(n.u), and half f (X.n) |u|².
        let a = astigmatism;
        pencil.linear[0] += 2.0 * a * x * cx;
        pencil.linear[1] += a * (x * cy + y * cx);
        pencil.linear[2] += 2.0 * a * y * cy;
        pencil.defocus(focus * (x * cx + y * cy));
        let push = shift + prism * colour(place, 0.0, -0.8);
        pencil.chief[0] += push * cx;
        pencil.chief[1] += push * cy;
    })
    .scaled("coma_x", n[0])
    .scaled("coma_y", n[1])
    .scaled("shift_x", shift * n[0])
    .scaled("shift_y", shift * n[1])
    .fixed("astigmatism_over_coma", astigmatism)
    .fixed("focus_over_coma", focus)
    .fixed("prism_over_coma", prism)
}

fn diffraction(lens: &Lens) -> Change {
    Change::new("diffraction", [1.0, 1.0], |_, lens, place, pencil| {
        pencil.wave_px = Some(lens.wave_px(place.channel));
    })
    .fixed("q_green", lens.wave_px(1))
}

fn vignetting(rng: &mut Rng) -> Change {
    let (r, way) = (rng.between(0.9, 1.1), rng.sign());
    let second = rng
        .chance(0.5)
        .then(|| (rng.between(0.95, 1.1), rng.between(0.5, 1.0)));
    let change = Change::new("vignetting", [0.15, 1.2], move |t, _, _, pencil| {
        let [x, y] = pencil.field;
        let s = way * t;
        pencil.mask.clips.push([s * x, s * y, r]);
        if let Some((r, ratio)) = second {
            pencil.mask.clips.push([-ratio * s * x, -ratio * s * y, r]);
        }
    })
    .scaled("s1", way)
    .fixed("r1", r);
    match second {
        Some((r, ratio)) => change.scaled("s2", -ratio * way).fixed("r2", r),
        None => change,
    }
}

fn aperture_polygon(rng: &mut Rng) -> Change {
    let blades = 5 + rng.below(5);
    let turn = rng.between(0.0, std::f64::consts::TAU);
    let normals: Vec<[f64; 2]> = (0..blades)
        .map(|i| {
            let (sin, cos) = libm::sincos(turn + std::f64::consts::TAU * i as f64 / blades as f64);
            [cos, sin]
        })
        .collect();
    Change::new("aperture_polygon", [0.1, 1.0], move |t, _, _, pencil| {
        pencil.mask.blades = Some(Blades {
            normals: normals.clone(),
            straightness: t,
        });
    })
    .fixed("blades", blades as f64)
    .fixed("turn_rad", turn)
    .scaled("straightness", 1.0)
}

fn apodisation() -> Change {
    Change::new("apodisation", [0.1, 3.0], |t, _, _, pencil| {
        pencil.mask.fading += t;
    })
    .scaled("a", 1.0)
}

fn higher_order(rng: &mut Rng) -> Change {
    const NAMES: [&str; 6] = ["w060", "w151", "w240", "w242", "w331", "w333"];
    let mut order: Vec<usize> = (0..NAMES.len()).collect();
    rng.shuffle(&mut order);
    let count = 1 + rng.below(3);
    let mut size = [0.0; 6];
    for &term in &order[..count] {
        size[term] = rng.signed(0.5, 1.0);
    }
    let change = Change::new("higher_order", [0.1, 5.0], move |t, _, _, pencil| {
        let [x, y] = pencil.field;
        let h2 = x * x + y * y;
        let s = size.map(|s| s * t);
        // Sizes are slopes at the rim along the meridian at h = 1.
        pencil.spherical5 += s[0];
        let coma5 = s[1] / 5.0;
        pencil.coma5[0] += coma5 * x;
        pencil.coma5[1] += coma5 * y;
        pencil.spherical += s[2] * h2;
        pencil.oblique += s[3] / 2.0;
        let coma = -s[4] * h2 / 3.0;
        pencil.coma[0] += coma * x;
        pencil.coma[1] += coma * y;
        pencil.elliptical += s[5];
    });
    order[..count].iter().fold(change, |change, &term| {
        change.scaled(NAMES[term], size[term])
    })
}

fn axial_colour(rng: &mut Rng) -> Change {
    let (red, green, blue) = (rng.sign(), rng.between(-0.06, 0.06), -rng.between(0.6, 1.1));
    Change::new("axial_colour", [0.02, 2.5], move |t, _, place, pencil| {
        pencil.defocus(red * t * colour(place, green, blue));
    })
    .scaled("alpha_r", red)
    .scaled("alpha_g", red * green)
    .scaled("alpha_b", red * blue)
}

fn lateral_colour(rng: &mut Rng) -> Change {
    let (red, blue) = (rng.sign(), -rng.between(0.6, 1.1));
    Change::new("lateral_colour", [0.03, 1.8], move |t, _, place, pencil| {
        let push = red * t * colour(place, 0.0, blue);
        pencil.chief[0] += push * pencil.field[0];
        pencil.chief[1] += push * pencil.field[1];
    })
    .scaled("shift_r", red)
    .scaled("shift_b", red * blue)
}

/// Share of distortions that are strong, and their range, px at h = 1; 24 px in the corner of the frame, at h = 1.147.
const STRONG_DISTORTION: f64 = 0.35;
const STRONG_DISTORTION_PX: [f64; 2] = [3.0, 15.9];

fn distortion(rng: &mut Rng) -> Change {
    let way = rng.sign();
    let strong = rng.chance(STRONG_DISTORTION);
    let range = if strong {
        let [least, most] = STRONG_DISTORTION_PX;
        [rng.between_log(least, most); 2]
    } else {
        [0.05, 3.0]
    };
    let mut change = Change::new("distortion", range, move |t, _, _, pencil| {
        let [x, y] = pencil.field;
        let push = way * t * (x * x + y * y);
        pencil.chief[0] += push * x;
        pencil.chief[1] += push * y;
    })
    .scaled("shift", way);
    change.moves_far = strong;
    change
}

fn pupil_scale(rng: &mut Rng) -> Change {
    let way = rng.sign();
    Change::new("pupil_scale", [0.01, 0.26], move |t, _, _, pencil| {
        pencil.mask.pupil_scale = libm::exp(way * t);
    })
    .scaled("log_factor", way)
}

fn anamorphic(rng: &mut Rng) -> Change {
    let (focus, by_pupil) = (rng.signed(1.0, 5.0), rng.chance(0.5));
    let stretch = if rng.chance(0.5) {
        rng.signed(0.5, 4.0)
    } else {
        0.0
    };
    // The strength is 1 minus the squeeze; the other parameters are proportional to it.
    Change::new("anamorphic", [0.005, 0.25], move |t, _, _, pencil| {
        if by_pupil {
            pencil.squeeze_pupil *= 1.0 - t;
        } else {
            pencil.squeeze_blur *= 1.0 - t;
        }
        pencil.linear[0] += focus * t;
        pencil.linear[2] -= focus * t;
        pencil.chief[0] += stretch * t * pencil.field[0];
        pencil.chief[1] -= 0.3 * stretch * t * pencil.field[1];
    })
    .scaled("squeeze_less_one", -1.0)
    .fixed("pupil_not_blur", f64::from(u8::from(by_pupil)))
    .scaled("focus_x", focus)
    .scaled("focus_y", -focus)
    .scaled("stretch_x", stretch)
}
