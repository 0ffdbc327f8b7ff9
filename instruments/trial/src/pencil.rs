//! A pencil: the light from one point to one channel of the sensor.
//!
//! The pupil point u lies in the unit disc. Slopes are landing points relative to the chief ray in pixels; they are the
//! gradient of the wavefront W, which is in pixels as well.

use super::mask::Mask;
use super::sensor::Sensor;

/// A sinusoidal ripple of the wavefront.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ripple {
    /// Largest slope, px.
    pub(super) slope: f64,
    /// Wave vector (x, y), radians per pupil radius; rings use its length.
    pub(super) wave_number: [f64; 2],
    /// Phase, radians.
    pub(super) phase: f64,
    /// True if the ripple forms rings about the centre instead of lines.
    pub(super) rings: bool,
}

/// A displacement of rays that is not the gradient of a wavefront: linear in u, in |u|² and in u_x u_y.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Warp {
    pub(super) linear: [f64; 4],
    pub(super) square: [f64; 2],
    pub(super) cross: [f64; 2],
}

/// A pencil of light.
#[derive(Debug, Clone)]
pub(super) struct Pencil {
    /// Field point, half frame widths.
    pub(super) field: [f64; 2],
    /// Landing point of the chief ray, frame pixels.
    pub(super) chief: [f64; 2],
    /// Coefficients of the slopes linear in u: xx, xy, yy.
    pub(super) linear: [f64; 3],
    /// Coefficient of the slope |u|² u.
    pub(super) spherical: f64,
    /// Coefficient of the slope |u|⁴ u.
    pub(super) spherical5: f64,
    /// Vector c of the slope -(|u|² c + 2 u (c.u)).
    pub(super) coma: [f64; 2],
    /// Vector c of the slope |u|⁴ c + 4 |u|² u (c.u).
    pub(super) coma5: [f64; 2],
    /// Coefficient o of the wavefront o |u|² (X.u)² / 2.
    pub(super) oblique: f64,
    /// Coefficient e of the wavefront e (X.u)³ / 3.
    pub(super) elliptical: f64,
    /// Real and imaginary part of trefoil.
    pub(super) trefoil: [f64; 2],
    pub(super) ripple: Option<Ripple>,
    pub(super) warp: Option<Warp>,
    /// Width of the elliptical pupil over its height.
    pub(super) squeeze_pupil: f64,
    /// Factor on all slopes along x.
    pub(super) squeeze_blur: f64,
    /// Aperture and transmission.
    pub(super) mask: Mask,
    /// 2 N lambda / pitch for wave optics, pixels; `None` for rays.
    pub(super) wave_px: Option<f64>,
    /// The sensor.
    pub(super) sensor: Sensor,
}

impl Pencil {
    /// Creates a pencil without aberrations, whose rays all land on `chief`.
    pub(super) fn sharp(field: [f64; 2], chief: [f64; 2]) -> Self {
        Self {
            field,
            chief,
            linear: [0.0; 3],
            spherical: 0.0,
            spherical5: 0.0,
            coma: [0.0; 2],
            coma5: [0.0; 2],
            oblique: 0.0,
            elliptical: 0.0,
            trefoil: [0.0; 2],
            ripple: None,
            warp: None,
            squeeze_pupil: 1.0,
            squeeze_blur: 1.0,
            mask: Mask::default(),
            wave_px: None,
            sensor: Sensor::default(),
        }
    }

    /// Adds isotropic defocus, px at the rim.
    pub(super) fn defocus(&mut self, px: f64) {
        self.linear[0] += px;
        self.linear[2] += px;
    }

    /// Returns the factors from mask points, in units of the actual radius, to pupil points, in units of the nominal one to
    /// which all coefficients refer.
    pub(super) fn pupil_axes(&self) -> [f64; 2] {
        let scale = self.mask.pupil_scale;
        [scale * self.squeeze_pupil, scale]
    }

    /// Returns the landing point of the ray through the mask point `m`, relative to the chief ray, px.
    pub(super) fn slope(&self, m: [f64; 2]) -> [f64; 2] {
        let [sx, sy] = self.pupil_axes();
        let [x, y] = [m[0] * sx, m[1] * sy];
        let r2 = x * x + y * y;
        let [fx, fy] = self.field;
        let along = fx * x + fy * y;
        let coma = self.coma[0] * x + self.coma[1] * y;
        let coma5 = self.coma5[0] * x + self.coma5[1] * y;
        let by_u = (self.spherical + self.spherical5 * r2) * r2 - 2.0 * coma
            + 4.0 * r2 * coma5
            + self.oblique * along * along;
        let by_field = self.oblique * r2 * along + self.elliptical * along * along;
        let r4 = r2 * r2;
        let (diff, cross) = (x * x - y * y, 2.0 * x * y);
        let mut px = self.linear[0] * x + self.linear[1] * y + by_u * x + by_field * fx
            - r2 * self.coma[0]
            + r4 * self.coma5[0]
            + self.trefoil[0] * diff
            + self.trefoil[1] * cross;
        let mut py = self.linear[1] * x + self.linear[2] * y + by_u * y + by_field * fy
            - r2 * self.coma[1]
            + r4 * self.coma5[1]
            - self.trefoil[0] * cross
            + self.trefoil[1] * diff;
        if let Some(ripple) = self.ripple {
            let [kx, ky] = ripple.wave_number;
            let k = kx.hypot(ky);
            let r = r2.sqrt();
            let (angle, dx, dy) = if ripple.rings {
                let unit = if r > 0.0 { 1.0 / r } else { 0.0 };
                (k * r + ripple.phase, x * unit, y * unit)
            } else {
                (kx * x + ky * y + ripple.phase, kx / k, ky / k)
            };
            let slope = -ripple.slope * libm::sin(angle);
            px += slope * dx;
            py += slope * dy;
        }
        if let Some(warp) = self.warp {
            px += warp.linear[0] * x + warp.linear[1] * y;
            px += warp.square[0] * r2 + warp.cross[0] * cross;
            py += warp.linear[2] * x + warp.linear[3] * y;
            py += warp.square[1] * r2 + warp.cross[1] * cross;
        }
        [px * self.squeeze_blur, py]
    }

    /// Returns the wavefront at the mask point `m`, px; its gradient gives the slopes before `squeeze_blur`.
    ///
    /// Ripples and warps are not included: they apply to rays only.
    pub(super) fn wavefront(&self, m: [f64; 2]) -> f64 {
        let [sx, sy] = self.pupil_axes();
        let [x, y] = [m[0] * sx, m[1] * sy];
        let r2 = x * x + y * y;
        let along = self.field[0] * x + self.field[1] * y;
        let coma = self.coma[0] * x + self.coma[1] * y;
        let coma5 = self.coma5[0] * x + self.coma5[1] * y;
        let [lxx, lxy, lyy] = self.linear;
        0.5 * (lxx * x * x + lyy * y * y)
            + lxy * x * y
            + self.spherical * r2 * r2 / 4.0
            + self.spherical5 * r2 * r2 * r2 / 6.0
            - r2 * coma
            + r2 * r2 * coma5
            + self.oblique * r2 * along * along / 2.0
            + self.elliptical * along * along * along / 3.0
            + self.trefoil[0] * (x * x * x - 3.0 * x * y * y) / 3.0
            + self.trefoil[1] * (3.0 * x * x * y - y * y * y) / 3.0
    }

    /// Returns the mean landing point of the rays, frame pixels, before the sensor.
    pub(super) fn centroid(&self) -> [f64; 2] {
        const STEPS: usize = 40;
        let step = 2.0 / STEPS as f64;
        let (mut sum, mut light) = ([0.0; 2], 0.0);
        for row in 0..STEPS {
            for column in 0..STEPS {
                let m = [
                    (column as f64 + 0.5) * step - 1.0,
                    (row as f64 + 0.5) * step - 1.0,
                ];
                let weight = self.mask.light(m, step);
                if weight > 0.0 {
                    let p = self.slope(m);
                    sum[0] += weight * p[0];
                    sum[1] += weight * p[1];
                    light += weight;
                }
            }
        }
        [
            self.chief[0] + sum[0] / light,
            self.chief[1] + sum[1] / light,
        ]
    }
}
