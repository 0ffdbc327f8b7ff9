//! The bare lens: a third-order lens for each channel, on a realistic camera.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_8;

use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};

use super::conditions::Conditions;
use super::pencil::Pencil;
use super::recipe::Kind;
use super::rng::Rng;

/// Channel names, in the order of all tiles.
pub(super) const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// Wavelengths of the channels, nanometres.
pub(super) const WAVELENGTHS_NM: [f64; 3] = [620.0, 540.0, 460.0];
/// Vergence of the farthest objects, 1/m.
const LEAST_VERGENCE: f64 = 0.04;
/// Index of the reference channel for colour errors.
const GREEN: usize = 1;

/// Third-order coefficients of one channel, px at the rim of the pupil and h = 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seidel {
    /// Defocus relative to the reference channel.
    axial: f64,
    beta: f64,
    gamma: f64,
    delta: f64,
    phi: f64,
    /// Radial shift at h = 1, half widths, cubic in h.
    distortion: f64,
    /// Radial shift at h = 1, px, linear in h.
    lateral: f64,
}

/// A lens on a camera.
#[derive(Debug, Clone)]
pub(super) struct Lens {
    pub(super) frame: Frame,
    pub(super) focal_mm: f64,
    pub(super) f_number: f64,
    pub(super) pitch_um: f64,
    pub(super) focus_m: f64,
    /// The object distances, metres, the farthest first.
    pub(super) depths_m: Vec<f64>,
    channels: [Seidel; 3],
}

/// Constraints on the random lens that make a cause identifiable.
#[derive(Debug, Clone, Copy)]
pub(super) struct LensConstraints {
    /// True if the aperture is small enough for visible diffraction: q of 1.5 to 4 px.
    pub(super) slow: bool,
    /// Smallest ratio of the farthest to the nearest object distance, if there are several.
    pub(super) depth_ratio: f64,
    /// Number of object distances.
    pub(super) distances: usize,
    /// Growth of pencils for which tiles have room.
    pub(super) room: f64,
}

impl LensConstraints {
    /// Returns the constraints of a case.
    pub(super) fn of(kind: Kind, conditions: &Conditions) -> Self {
        let depths_matter = kind.holds("defocus_offset") || kind.holds("depth_scale");
        Self {
            slow: kind.holds("diffraction"),
            depth_ratio: if depths_matter { 1.3 } else { 1.1 },
            distances: conditions.distances,
            // Blur grows with the pupil.
            room: if kind.holds("pupil_scale") { 1.4 } else { 1.0 },
        }
    }
}

/// A point in the scene and a channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Image position through an undistorted lens, frame pixels.
    pub(super) ideal: [f64; 2],
    /// The stated object distance, metres.
    pub(super) depth_m: f64,
    /// Index of the channel.
    pub(super) channel: usize,
}

impl Lens {
    /// Draws a random lens that meets `constraints` and whose pencils fit well inside tiles of `tile` pixels.
    pub(super) fn draw_for(rng: &mut Rng, constraints: LensConstraints, tile: usize) -> Self {
        loop {
            let lens = Self::draw_any(rng, constraints, tile);
            if let Some(lens) = lens
                && lens.has_depth_ratio(constraints.depth_ratio)
                && constraints.room * lens.largest_radius_px() < tile as f64 / 2.0 - 2.0
            {
                return lens;
            }
        }
    }

    /// Returns whether the object distances span `ratio`; a single one always does.
    pub(super) fn has_depth_ratio(&self, ratio: f64) -> bool {
        match self.depths_m[..] {
            [far, .., near] => far > ratio * near,
            _ => true,
        }
    }

    /// Draws `count` object distances, the farthest first, whose defocus is up to about `blur` px; `None` if one would be
    /// beyond 25 m.
    pub(super) fn draw_distances(
        &self,
        count: usize,
        blur: f64,
        rng: &mut Rng,
    ) -> Option<Vec<f64>> {
        // One distance lies on either side of the focus; several span it evenly.
        let steps = count.saturating_sub(1);
        let side = rng.sign();
        let mut depths_m = Vec::with_capacity(count);
        for step in 0..count {
            let part = match steps {
                0 => side,
                _ => 2.0 * step as f64 / steps as f64 - 1.0,
            };
            let defocus = blur * (part + rng.between(-0.15, 0.15));
            let vergence = 1.0 / self.focus_m + defocus / self.px_per_dioptre();
            if vergence < LEAST_VERGENCE {
                return None;
            }
            depths_m.push((1000.0 / vergence).round() / 1000.0);
        }
        Some(depths_m)
    }

    /// Returns the lens with the object distances as far on the other side of focus; `None` if it has points on both sides, or
    /// if one would be beyond 25 m.
    pub(super) fn beyond_focus(&self) -> Option<Self> {
        let in_focus = 1.0 / self.focus_m;
        let offsets = self.depths_m.iter().map(|depth| 1.0 / depth - in_focus);
        let offsets: Vec<f64> = offsets.collect();
        let on_one_side = offsets.iter().all(|o| *o > 0.0) || offsets.iter().all(|o| *o < 0.0);
        let vergences = offsets.iter().map(|offset| in_focus - offset);
        let vergences: Vec<f64> = vergences.collect();
        let near_enough = vergences.iter().all(|v| *v >= LEAST_VERGENCE);
        (on_one_side && near_enough).then(|| Self {
            depths_m: vergences.iter().map(|v| 1.0 / v).collect(),
            ..self.clone()
        })
    }

    fn draw_any(rng: &mut Rng, constraints: LensConstraints, tile: usize) -> Option<Self> {
        let slow = constraints.slow;
        let (width, height) = if rng.chance(0.5) {
            (3840, 2160)
        } else {
            (1920, 1080)
        };
        let focal_mm = [25.0, 28.0, 35.0, 40.0, 50.0, 65.0, 75.0, 85.0][rng.below(8)];
        let pitch_um = (rng.between(3.5, if slow { 4.6 } else { 6.0 }) * 10.0).round() / 10.0;
        let f_number = if slow {
            let q = rng.between(1.5, 4.0);
            (q * pitch_um / (2.0e-3 * WAVELENGTHS_NM[GREEN]) * 10.0).round() / 10.0
        } else {
            [1.4, 1.8, 2.0, 2.8, 4.0, 5.6][rng.below(6)]
        };
        let focus_m = (rng.between(1.5, 4.0) * 10.0).round() / 10.0;
        // Larger tiles are for larger blur.
        let blur = rng.between(3.0, 6.0 * (tile as f64 / 33.0).max(1.0));
        let (beta, gamma, delta, phi) = (
            rng.signed(0.8, 2.5),
            rng.signed(0.4, 2.5),
            rng.signed(0.4, 2.5),
            rng.signed(0.4, 1.3),
        );
        let distortion = rng.signed(0.001, 0.015);
        let axial = rng.signed(0.3, 0.6);
        let lateral = rng.signed(0.0, 0.15);
        let spread: [f64; 4] = std::array::from_fn(|_| rng.signed(0.01, 0.06));
        let blue = -rng.between(0.7, 1.1);
        let channels = [1.0, 0.0, blue].map(|c| Seidel {
            axial: axial * c,
            beta: beta * (1.0 + spread[0] * c),
            gamma: gamma * (1.0 + spread[1] * c),
            delta: delta * (1.0 + spread[2] * c),
            phi: phi * (1.0 + spread[3] * c),
            distortion,
            lateral: lateral * c,
        });
        let frame = Frame::new(width, height, None).expect("the frame is a real one");
        let mut lens = Self {
            frame,
            focal_mm,
            f_number,
            pitch_um,
            focus_m,
            depths_m: Vec::new(),
            channels,
        };
        lens.depths_m = lens.draw_distances(constraints.distances, blur, rng)?;
        Some(lens)
    }

    /// Creates a camera with a lens without aberrations and without object distances.
    pub(super) fn ideal(
        frame: Frame,
        focal_mm: f64,
        f_number: f64,
        pitch_um: f64,
        focus_m: f64,
    ) -> Self {
        let none = Seidel {
            axial: 0.0,
            beta: 0.0,
            gamma: 0.0,
            delta: 0.0,
            phi: 0.0,
            distortion: 0.0,
            lateral: 0.0,
        };
        Self {
            frame,
            focal_mm,
            f_number,
            pitch_um,
            focus_m,
            depths_m: Vec::new(),
            channels: [none; CHANNELS.len()],
        }
    }

    /// Returns the defocus of one dioptre, px at the rim.
    pub(super) fn px_per_dioptre(&self) -> f64 {
        self.focal_mm * self.image_mm() / (2.0 * self.f_number * self.pitch_um)
    }

    /// Returns the distance of the focused image behind the thin lens, mm.
    pub(super) fn image_mm(&self) -> f64 {
        self.focal_mm / (1.0 - self.focal_mm / (1000.0 * self.focus_m))
    }

    /// Returns the defocus of an object at vergence `v` (1/m), px at the rim, without axial colour.
    pub(super) fn alpha(&self, v: f64) -> f64 {
        self.px_per_dioptre() * (v - 1.0 / self.focus_m)
    }

    /// Returns q = 2 N lambda / pitch of a channel, px.
    pub(super) fn wave_px(&self, channel: usize) -> f64 {
        2.0 * self.f_number * WAVELENGTHS_NM[channel] * 1e-3 / self.pitch_um
    }

    /// Returns the relative change of magnification for a sensor shift that adds one px of defocus.
    pub(super) fn growth_per_px(&self) -> f64 {
        -2.0 * self.f_number * self.pitch_um * 1e-3 / self.image_mm()
    }

    /// Returns the pencil of the bare lens.
    pub(super) fn pencil(&self, place: &Place) -> Pencil {
        let s = &self.channels[place.channel];
        let [ideal_x, ideal_y] = place.ideal;
        let FieldPoint { x, y } = self.frame.field_point(ImagePoint::new(ideal_x, ideal_y));
        let h2 = x * x + y * y;
        let push = s.distortion * self.frame.half_width_px() * h2 + s.lateral;
        let mut pencil = Pencil::sharp([x, y], [ideal_x + push * x, ideal_y + push * y]);
        pencil.defocus(self.alpha(1.0 / place.depth_m) + s.axial + s.delta * h2);
        pencil.linear[0] += s.gamma * x * x;
        pencil.linear[1] += s.gamma * x * y;
        pencil.linear[2] += s.gamma * y * y;
        pencil.spherical = s.beta;
        pencil.coma = [s.phi * x, s.phi * y];
        pencil
    }

    /// Returns the largest distance of a ray from the centroid of its pencil, px, over sampled positions and rays.
    fn largest_radius_px(&self) -> f64 {
        let unit = self.frame.half_width_px();
        let axis = self.frame.axis();
        let mut most = 0.0_f64;
        for h in [0.0, 0.5, 0.8, 1.12] {
            for &depth_m in &self.depths_m {
                for channel in 0..CHANNELS.len() {
                    let pencil = self.pencil(&Place {
                        ideal: [axis.x_px + h * unit, axis.y_px],
                        depth_m,
                        channel,
                    });
                    let [cx, cy] = pencil.centroid();
                    for step in 0..64 {
                        let (sin, cos) = libm::sincos(f64::from(step % 16) * FRAC_PI_8);
                        let r = 0.25 * f64::from(step / 16 + 1);
                        let [px, py] = pencil.slope([r * cos, r * sin]);
                        let at = [px + pencil.chief[0] - cx, py + pencil.chief[1] - cy];
                        most = most.max(at[0].hypot(at[1]));
                    }
                }
            }
        }
        most
    }

    /// Returns the camera as stated in a manifest.
    pub(super) fn camera(&self) -> Camera {
        let wavelength_nm: BTreeMap<String, f64> = CHANNELS
            .iter()
            .zip(WAVELENGTHS_NM)
            .map(|(name, nm)| ((*name).to_owned(), nm))
            .collect();
        Camera {
            focal_length_mm: Some(self.focal_mm),
            f_number: Some(self.f_number),
            focus_distance: ObjectDistance::Metres(self.focus_m),
            wavelength_nm,
            ..Camera::default()
        }
    }
}
