//! The designed lens: a published prescription on a realistic camera.

use super::assembly::{Assembly, GREEN, SensorPlane, View};
use super::beam::Beam;
use super::paraxial;
use super::prescription::{self, Prescription};
use super::surface::Surface;
use crate::lens::{CHANNELS, Lens, LensConstraints, WAVELENGTHS_NM};
use crate::mask::Mask;
use crate::rng::Rng;
use seidel_optics::field::{FieldPoint, Frame};

/// Plate in front of the sensor of lenses whose prescription has none: thickness and distance to the sensor, mm; index at
/// the d line and Abbe number of N-BK7.
const COVER_MM: f64 = 0.8;
const COVER_GAP_MM: f64 = 1.5;
const COVER: super::dispersion::Glass = super::dispersion::Glass {
    nd: 1.5168,
    vd: 64.17,
};
/// Field radii at which beams are checked, half frame widths.
const FIELDS: [f64; 4] = [0.0, 0.5, 0.8, 1.12];

/// A designed lens on its camera.
#[derive(Debug, Clone)]
pub(crate) struct GlassLens {
    /// The camera, with an ideal lens.
    pub(super) camera: Lens,
    /// The lens and its sensor as designed, in focus.
    pub(super) design: Assembly,
    pub(super) prescription: &'static Prescription,
}

/// The choices that make a [`GlassLens`], except object distances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choices {
    pub(super) prescription: &'static Prescription,
    pub(super) frame: Frame,
    pub(super) focal_mm: f64,
    pub(super) f_number: f64,
    pub(super) pitch_um: f64,
    pub(super) focus_m: f64,
    /// Field radius up to which the rims of the first and last lens pass the full beam, half frame widths; `None` for rims
    /// that never clip.
    pub(super) full_field: Option<f64>,
}

/// Returns the surfaces of a prescription, scaled, with their indices at `wavelengths`.
pub(super) fn surfaces(
    prescription: &Prescription,
    scale: f64,
    wavelengths: [f64; CHANNELS.len()],
) -> Vec<Surface> {
    let mut z = 0.0;
    prescription
        .rows
        .iter()
        .map(|row| {
            let surface = Surface {
                vertex: [0.0, 0.0, z],
                axis: [0.0, 0.0, 1.0],
                curvature: row.curvature / scale,
                figure: None,
                clear_mm: None,
                index: wavelengths.map(|nm| row.glass.map_or(1.0, |glass| glass.index(nm))),
            };
            z += row.thickness * scale;
            surface
        })
        .collect()
}

impl GlassLens {
    /// Draws a random lens that meets `constraints` and whose beams fit well inside tiles of `tile` pixels.
    pub(super) fn draw_for(rng: &mut Rng, constraints: LensConstraints, tile: usize) -> Self {
        loop {
            let choices = Choices::draw(rng);
            // Larger tiles are for larger blur.
            let blur = rng.between(3.0, 6.0 * (tile as f64 / 33.0).max(1.0));
            if choices.corner_deg() > choices.prescription.field_deg {
                continue;
            }
            let mut lens = Self::new(&choices);
            let distances = (lens.camera).draw_distances(constraints.distances, blur, rng);
            let Some(depths_m) = distances else {
                continue;
            };
            lens.camera.depths_m = depths_m;
            let largest_px = tile as f64 / 2.0 - 2.0;
            if lens.camera.has_depth_ratio(constraints.depth_ratio)
                && lens
                    .largest_radius_px()
                    .is_some_and(|r| constraints.room * r < largest_px)
            {
                return lens;
            }
        }
    }

    /// Builds the lens of `choices`, in focus.
    pub(super) fn new(choices: &Choices) -> Self {
        let prescription = choices.prescription;
        let unscaled = surfaces(prescription, 1.0, WAVELENGTHS_NM);
        let scale = choices.focal_mm / paraxial::focus(&unscaled, GREEN).focal;
        let mut surfaces = surfaces(prescription, scale, WAVELENGTHS_NM);
        let back = paraxial::focus(&surfaces, GREEN).back;
        let pupil = paraxial::entrance_pupil(&surfaces, prescription.stop);
        let pupil_mm = choices.focal_mm / (2.0 * choices.f_number);
        let last = surfaces[surfaces.len() - 1].vertex[2];
        // Extension of an image at the distance in focus over one at infinity.
        let extension = choices.focal_mm * choices.focal_mm / (1000.0 * choices.focus_m);
        let mut sensor_z = last + back + extension;
        if !prescription.has_cover {
            let index = WAVELENGTHS_NM.map(|nm| COVER.index(nm));
            sensor_z += COVER_MM * (1.0 - 1.0 / index[GREEN]);
            for (z, index) in [
                (sensor_z - COVER_GAP_MM - COVER_MM, index),
                (sensor_z - COVER_GAP_MM, [1.0; CHANNELS.len()]),
            ] {
                surfaces.push(Surface {
                    vertex: [0.0, 0.0, z],
                    axis: [0.0, 0.0, 1.0],
                    curvature: 0.0,
                    figure: None,
                    clear_mm: None,
                    index,
                });
            }
        }
        let axis = choices.frame.axis();
        let mut design = Assembly {
            surfaces,
            stop: prescription.stop,
            stop_mm: pupil_mm / pupil.growth,
            holes: Vec::new(),
            sensor: SensorPlane {
                centre: [0.0, 0.0, sensor_z],
                normal: [0.0, 0.0, 1.0],
                pitch_mm: 1e-3 * choices.pitch_um,
                axis_px: [axis.x_px, axis.y_px],
            },
            view: View {
                pupil_z: pupil.z,
                pupil_mm,
                chief_mm: 1.0,
            },
            depth_factor: 1.0,
        };
        design.refocus(choices.focus_m);
        design.view.chief_mm = paraxial::course(&design, GREEN, choices.focus_m).chief;
        let camera = Lens::ideal(
            choices.frame,
            choices.focal_mm,
            choices.f_number,
            choices.pitch_um,
            choices.focus_m,
        );
        let mut lens = Self {
            camera,
            design,
            prescription,
        };
        if let Some(field) = choices.full_field {
            let elements = lens.design.elements();
            for rim in [*elements[0].start(), *elements[elements.len() - 1].end()] {
                let height = lens.beam_height(rim, field);
                lens.design.surfaces[rim].clear_mm = Some(height);
            }
        }
        lens
    }

    /// Returns the frame position at `field` half frame widths from the axis, along x.
    pub(super) fn position(&self, field: f64) -> [f64; 2] {
        let at = self.camera.frame.image_point(FieldPoint::new(field, 0.0));
        [at.x_px, at.y_px]
    }

    /// Returns the largest height on a surface of rays in focus to `field` half frame widths from the axis, mm.
    pub(super) fn beam_height(&self, surface: usize, field: f64) -> f64 {
        let probe = |clear: f64| {
            let mut assembly = self.design.clone();
            assembly.surfaces[surface].clear_mm = Some(clear);
            assembly
        };
        least_clear(
            probe,
            self.position(field),
            self.camera.focus_m,
            self.design.view.pupil_mm,
        )
    }

    /// Returns the largest distance of a ray from the centroid of its beam, px, over sampled positions; `None` if light
    /// does not reach one.
    fn largest_radius_px(&self) -> Option<f64> {
        let mask = Mask::default();
        let mut most = 0.0_f64;
        for field in FIELDS {
            for &depth_m in &self.camera.depths_m {
                for channel in 0..CHANNELS.len() {
                    let object = self.design.object(self.position(field), depth_m);
                    let beam = Beam::new(&self.design, channel, object, &mask)?;
                    most = most.max(beam.largest_radius_px());
                }
            }
        }
        Some(most)
    }
}

/// Returns the radius of an aperture that just passes the beam through the whole stop, mm.
///
/// `with_radius` builds the lens with that aperture.
pub(super) fn least_clear(
    with_radius: impl Fn(f64) -> Assembly,
    ideal: [f64; 2],
    depth_m: f64,
    pupil_mm: f64,
) -> f64 {
    const RAYS: usize = 61;
    const WIDE: f64 = 1000.0;
    let assembly = with_radius(WIDE);
    let object = assembly.object(ideal, depth_m);
    let mut most = 0.0_f64;
    let at = |k: usize| (2.0 * k as f64 / (RAYS - 1) as f64 - 1.0) * 1.6 * pupil_mm;
    let aims = (0..RAYS * RAYS).map(|i| [at(i % RAYS), at(i / RAYS)]);
    let landings = assembly.follow_all(GREEN, object, aims);
    for l in landings.iter().flatten() {
        if l.stop[0].hypot(l.stop[1]) <= 1.0 {
            most = most.max(WIDE - l.inside_mm);
        }
    }
    most
}

impl Choices {
    fn draw(rng: &mut Rng) -> Self {
        let prescription = prescription::ALL[rng.below(prescription::ALL.len())];
        let (width, height) = if rng.chance(0.5) {
            (3840, 2160)
        } else {
            (1920, 1080)
        };
        let pick = |rng: &mut Rng, from: &[f64]| from[rng.below(from.len())];
        Self {
            prescription,
            frame: Frame::new(width, height, None).expect("the frame is a real one"),
            focal_mm: pick(rng, prescription.focal_mm),
            f_number: pick(rng, prescription.f_numbers),
            pitch_um: (rng.between(3.5, 6.0) * 10.0).round() / 10.0,
            focus_m: (rng.between(1.5, 4.0) * 10.0).round() / 10.0,
            full_field: rng.chance(0.35).then(|| rng.between(0.6, 0.9)),
        }
    }

    /// Returns the angle from the axis to the corner of the frame, degrees.
    fn corner_deg(&self) -> f64 {
        let corner = self.frame.corner_radius() * self.frame.half_width_px();
        libm::atan(corner * 1e-3 * self.pitch_um / self.focal_mm).to_degrees()
    }
}
