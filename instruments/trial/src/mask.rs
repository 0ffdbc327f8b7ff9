//! The aperture and transmission of the pupil.

/// The blades of an iris.
#[derive(Debug, Clone)]
pub(super) struct Blades {
    /// Directions of the centres of the blades, unit vectors.
    pub(super) normals: Vec<[f64; 2]>,
    /// 0 for a circle, 1 for straight blades between corners on the rim.
    pub(super) straightness: f64,
}

/// The aperture and transmission of the pupil; by default the open unit disc.
#[derive(Debug, Clone)]
pub(super) struct Mask {
    /// Radius of the pupil over its nominal radius.
    pub(super) pupil_scale: f64,
    /// Circles of other elements that clip the pencil: centre x, y and radius, nominal pupil radii.
    pub(super) clips: Vec<[f64; 3]>,
    pub(super) blades: Option<Blades>,
    /// Coefficient a of the intensity transmission exp(-a |u|²).
    pub(super) fading: f64,
    /// Radius of a central obstruction, pupil radii.
    pub(super) obstruction: f64,
}

impl Default for Mask {
    fn default() -> Self {
        Self {
            pupil_scale: 1.0,
            clips: Vec::new(),
            blades: None,
            fading: 0.0,
            obstruction: 0.0,
        }
    }
}

impl Mask {
    /// Returns the open share of a cell of width `cell` about `u`.
    pub(super) fn open(&self, u: [f64; 2], cell: f64) -> f64 {
        let radius = u[0].hypot(u[1]);
        let mut inside = 1.0 - radius;
        if inside < -cell {
            return 0.0;
        }
        for [x, y, r] in &self.clips {
            let scale = self.pupil_scale;
            inside = inside.min((r - (scale * u[0] - x).hypot(scale * u[1] - y)) / scale);
        }
        if let Some(blades) = &self.blades {
            let across = blades
                .normals
                .iter()
                .map(|n| n[0] * u[0] + n[1] * u[1])
                .fold(f64::MIN, f64::max)
                .max(1e-9);
            let half_angle = std::f64::consts::PI / blades.normals.len() as f64;
            let polygon = libm::cos(half_angle) * radius / across;
            let edge = 1.0 + blades.straightness * (polygon - 1.0);
            inside = inside.min(edge - radius);
        }
        let mut share = (0.5 + inside / cell).clamp(0.0, 1.0);
        if self.obstruction > 0.0 {
            share *= (0.5 + (radius - self.obstruction) / cell).clamp(0.0, 1.0);
        }
        share
    }

    /// Returns the intensity transmission at `u`.
    pub(super) fn transmission(&self, u: [f64; 2]) -> f64 {
        if self.fading == 0.0 {
            1.0
        } else {
            libm::exp(-self.fading * (u[0] * u[0] + u[1] * u[1]))
        }
    }

    /// Returns the light through a cell of width `cell` about `u`; 1 for an open cell.
    pub(super) fn light(&self, u: [f64; 2], cell: f64) -> f64 {
        let open = self.open(u, cell);
        if open > 0.0 {
            open * self.transmission(u)
        } else {
            0.0
        }
    }
}
