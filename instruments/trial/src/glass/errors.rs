//! Errors of manufacture and use that effects of the library describe, one function for each.

use super::assembly::{Assembly, GREEN, Hole};
use super::beam::Beam;
use super::change::GlassChange;
use super::colour;
use super::figure::Figure;
use super::lens::{GlassLens, least_clear};
use super::vector::turned;
use crate::mask::Mask;
use crate::perturb;
use crate::rng::Rng;

/// Field radius at which an added hole that just passes everything is measured: the corner, half frame widths.
const CORNER: f64 = 1.14;

/// Draws the effect `id` for `lens`.
///
/// # Panics
/// If `id` is not one of [`super::EFFECTS`].
pub(super) fn error(id: &str, lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    match id {
        "defocus_offset" => defocus_offset(lens, rng),
        "depth_scale" => depth_scale(rng),
        "sensor_tilt" => sensor_tilt(lens, rng),
        "decentre" => decentre(lens, rng),
        "pupil_scale" => pupil_scale(rng),
        "vignetting" => vignetting(lens, rng),
        "higher_order" => higher_order(lens, rng),
        "axial_colour" => colour::axial_colour(lens, rng),
        "lateral_colour" => colour::lateral_colour(lens, rng),
        "distortion" => distortion(lens, rng),
        "anamorphic" => anamorphic(lens, rng),
        "aperture_polygon" | "apodisation" | "pixel_footprint" | "motion" | "veiling_glare"
        | "tone_curve" => perturb::effect(id, &lens.camera, rng).into(),
        _ => panic!("`{id}` is not on the list of effects of traced lenses"),
    }
}

/// Returns the shift of the sensor that adds 1 px of defocus at the rim, mm.
fn shift_per_px(lens: &GlassLens) -> f64 {
    2.0 * lens.camera.f_number * lens.design.sensor.pitch_mm
}

/// Moves the sensor, or the lens against it.
fn defocus_offset(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let shift = rng.sign() * shift_per_px(lens);
    let change = if rng.chance(0.5) {
        GlassChange::new("defocus_offset", [0.03, 4.0], move |t, _, built| {
            built.sensor.centre[2] += t * shift;
        })
    } else {
        GlassChange::new("defocus_offset", [0.03, 4.0], move |t, _, built| {
            let last = built.cover() - 1;
            built.shift(0..=last, [0.0, 0.0, -t * shift]);
        })
    };
    change.scaled("shift_mm", shift)
}

/// States distances that are wrong by a factor.
fn depth_scale(rng: &mut Rng) -> GlassChange {
    let sign = rng.sign();
    GlassChange::new("depth_scale", [0.003, 0.3], move |t, _, built| {
        built.depth_factor = libm::exp(sign * t);
    })
    .scaled("log_factor", sign)
}

/// Tilts the sensor about its centre.
fn sensor_tilt(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let [x, y] = rng.direction();
    let half_mm = lens.camera.frame.half_width_px() * lens.design.sensor.pitch_mm;
    let angle = shift_per_px(lens) / half_mm;
    GlassChange::new("sensor_tilt", [0.05, 8.0], move |t, _, built| {
        built.sensor.normal = turned(built.sensor.normal, [x, y, 0.0], t * angle);
    })
    .scaled("angle_rad", angle)
    .fixed("about_x", x)
    .fixed("about_y", y)
}

/// Moves the sensor across the axis, so that the image of the axis point in focus is where it was designed to be: frames are
/// registered on it.
fn register(built: &mut Assembly, focus_m: f64) {
    let axis = built.sensor.axis_px;
    let mask = Mask::default();
    let object = built.object(axis, focus_m);
    let Some(beam) = Beam::new(built, GREEN, object, &mask) else {
        return;
    };
    let at = beam.centroid();
    // The frame is upright, the image is not.
    for i in 0..2 {
        built.sensor.centre[i] -= (at[i] - axis[i]) * built.sensor.pitch_mm;
    }
}

/// Shifts or tilts an element, or all elements on one side of the stop.
fn decentre(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let elements = lens.design.elements();
    let group = if rng.chance(0.3) {
        let side = |front: bool| {
            let mut of_side = elements
                .iter()
                .filter(|e| (*e.start() < lens.design.stop) == front);
            let first = of_side.next();
            let last = of_side.next_back().or(first);
            first.zip(last).map(|(a, b)| *a.start()..=*b.end())
        };
        let front = rng.chance(0.5);
        side(front)
            .or_else(|| side(!front))
            .expect("a lens has elements")
    } else {
        elements[rng.below(elements.len())].clone()
    };
    let [x, y] = rng.direction();
    let first = *group.start() as f64;
    let last = *group.end() as f64;
    let size = lens.camera.focal_mm / 50.0;
    let change = if rng.chance(0.6) {
        GlassChange::new(
            "decentre",
            [0.003 * size, 1.5 * size],
            move |t, lens, built| {
                built.shift(group.clone(), [t * x, t * y, 0.0]);
                register(built, lens.camera.focus_m);
            },
        )
        .scaled("shift_x_mm", x)
        .scaled("shift_y_mm", y)
    } else {
        GlassChange::new("decentre", [3e-4, 0.06], move |t, lens, built| {
            built.tilt(group.clone(), [x, y, 0.0], t);
            register(built, lens.camera.focus_m);
        })
        .scaled("tilt_about_x_rad", x)
        .scaled("tilt_about_y_rad", y)
    };
    change
        .fixed("first_surface", first)
        .fixed("last_surface", last)
}

/// Makes the stop too large or too small: factors from 0.75 to 1.25.
fn pupil_scale(rng: &mut Rng) -> GlassChange {
    let sign = rng.sign();
    let most = if sign > 0.0 { 1.25_f64 } else { 1.0 / 0.75 };
    GlassChange::new(
        "pupil_scale",
        [0.004, libm::log(most)],
        move |t, _, built| {
            built.stop_mm *= libm::exp(sign * t);
        },
    )
    .scaled("log_factor", sign)
}

/// Adds a screen with a hole before or behind the lens.
///
/// Strength 0 just passes the beams of the corners; strength 1 just passes that of the axis.
fn vignetting(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let design = &lens.design;
    let rear = design.cover() - 1;
    let hole = if rng.chance(0.6) {
        let before = rng.between(0.1, 0.6) * lens.camera.focal_mm;
        Hole {
            behind: None,
            z: design.surfaces[0].vertex[2] - before,
            radius: 0.0,
        }
    } else {
        let z = design.surfaces[rear].vertex[2];
        let room = design.surfaces[rear + 1].vertex[2] - z;
        Hole {
            behind: Some(rear),
            z: z + rng.between(0.1, 0.5) * room,
            radius: 0.0,
        }
    };
    let radius_at = |field: f64| {
        let probe = |radius: f64| {
            let mut assembly = design.clone();
            // Rims of the design clip as well.
            for surface in &mut assembly.surfaces {
                surface.clear_mm = None;
            }
            assembly.holes.push(Hole { radius, ..hole });
            assembly
        };
        let at = lens.position(field);
        least_clear(probe, at, lens.camera.focus_m, design.view.pupil_mm)
    };
    let (corner, axis) = (radius_at(CORNER), radius_at(0.0));
    GlassChange::new("vignetting", [0.03, 1.0], move |t, _, built| {
        let radius = corner - t * (corner - axis);
        built.holes.push(Hole { radius, ..hole });
    })
    .fixed("corner_mm", corner)
    .fixed("axis_mm", axis)
    .fixed("z_mm", hole.z)
    .fixed("before_lens", f64::from(u8::from(hole.behind.is_none())))
}

/// The lever of a surface near the stop: the slope of its figure at the rim of the axis beam, to px at the rim.
pub(super) struct Lever {
    pub(super) surface: usize,
    /// Height of the rim of the axis beam, mm.
    pub(super) rim_mm: f64,
    /// Slope of the surface that moves a ray through the rim by 1 px.
    pub(super) slope_per_px: f64,
}

/// Returns the lever of `surface`, by the invariant of Lagrange.
pub(super) fn lever(lens: &GlassLens, surface: usize) -> Lever {
    let design = &lens.design;
    let rim_mm = lens.beam_height(surface, 0.0);
    let before = surface
        .checked_sub(1)
        .map_or(1.0, |i| design.surfaces[i].index[GREEN]);
    let step = design.surfaces[surface].index[GREEN] - before;
    let shift = step * rim_mm * 2.0 * lens.camera.f_number;
    Lever {
        surface,
        rim_mm,
        slope_per_px: design.sensor.pitch_mm / shift.abs(),
    }
}

/// Returns the refracting surfaces of the lens whose index step is at least that of a cemented surface with leverage.
pub(super) fn polished(lens: &GlassLens) -> Vec<usize> {
    let surfaces = &lens.design.surfaces;
    (0..lens.design.cover())
        .filter(|&i| {
            let before = i.checked_sub(1).map_or(1.0, |k| surfaces[k].index[GREEN]);
            (surfaces[i].index[GREEN] - before).abs() > 0.3
        })
        .collect()
}

/// Returns the lever of the refracting surface nearest to the stop.
pub(super) fn lever_at_stop(lens: &GlassLens) -> Lever {
    let stop = lens.design.surfaces[lens.design.stop].vertex[2];
    let from_stop = |i: &usize| (lens.design.surfaces[*i].vertex[2] - stop).abs();
    let nearest = polished(lens)
        .into_iter()
        .min_by(|a, b| from_stop(a).total_cmp(&from_stop(b)))
        .expect("a lens has refracting surfaces");
    lever(lens, nearest)
}

/// Polishes a zone of sixth degree into a surface. Away from the stop it brings all fifth-order aberrations.
fn higher_order(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let polished = polished(lens);
    let lever = lever(lens, polished[rng.below(polished.len())]);
    let sextic = rng.sign() * lever.slope_per_px / (6.0 * lever.rim_mm.powi(5));
    let surface = lever.surface;
    GlassChange::new("higher_order", [0.1, 12.0], move |t, _, built| {
        built.bend(
            surface,
            Figure {
                sextic: t * sextic,
                ..Figure::default()
            },
        );
    })
    .scaled("sextic", sextic)
    .fixed("surface", surface as f64)
    .fixed("rim_mm", lever.rim_mm)
}

/// Bows the rear surface of the plate before the sensor, where beams are so narrow that little but their place changes.
fn distortion(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let design = &lens.design;
    let rear = design.surfaces.len() - 1;
    let gap = design.sensor.centre[2] - design.surfaces[rear].vertex[2];
    let height = lens.camera.frame.half_width_px() * design.sensor.pitch_mm;
    let step = design.surfaces[rear - 1].index[GREEN] - 1.0;
    // Shift at h = 1: the slope 4 q h³ times the index step and the gap.
    let quartic = rng.sign() * design.sensor.pitch_mm / (4.0 * height.powi(3) * step * gap);
    GlassChange::new("distortion", [0.1, 4.0], move |t, _, built| {
        let surface = built.surfaces.len() - 1;
        built.bend(
            surface,
            Figure {
                quartic: t * quartic,
                ..Figure::default()
            },
        );
    })
    .scaled("quartic", quartic)
}

/// Bends the surface nearest to the stop to a weak cylinder or saddle along the axes of the frame.
fn anamorphic(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let lever = lever_at_stop(lens);
    let square = rng.sign() * lever.slope_per_px / (2.0 * lever.rim_mm);
    let shape = match rng.below(3) {
        0 => [1.0, 0.0],
        1 => [0.0, 1.0],
        _ => [0.7, -0.7],
    };
    let surface = lever.surface;
    GlassChange::new("anamorphic", [0.05, 5.0], move |t, _, built| {
        built.bend(
            surface,
            Figure {
                square: shape.map(|s| t * s * square),
                ..Figure::default()
            },
        );
    })
    .scaled("square_x", shape[0] * square)
    .scaled("square_y", shape[1] * square)
    .fixed("surface", surface as f64)
}
