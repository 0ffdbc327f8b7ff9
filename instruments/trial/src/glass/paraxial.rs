//! Paraxial rays: focal length, pupils, and the colour errors of a lens.

use super::assembly::{Assembly, GREEN};
use super::surface::Surface;

/// A paraxial ray: height, mm, and slope in the medium that it is in.
#[derive(Debug, Clone, Copy)]
pub(super) struct ParaxialRay {
    pub(super) height: f64,
    pub(super) slope: f64,
}

impl ParaxialRay {
    /// Returns the ray `far` mm on.
    fn moved(self, far: f64) -> Self {
        Self {
            height: self.height + far * self.slope,
            ..self
        }
    }

    /// Returns the distance to where the ray meets the axis, mm.
    fn to_axis(self) -> f64 {
        -self.height / self.slope
    }
}

/// Follows a paraxial ray in air at z = 0 through `surfaces`; returns it at the vertex of the last, behind it.
fn follow(surfaces: &[Surface], channel: usize, ray: ParaxialRay) -> ParaxialRay {
    let (mut ray, mut z, mut index) = (ray, 0.0, 1.0);
    for surface in surfaces {
        ray = ray.moved(surface.vertex[2] - z);
        z = surface.vertex[2];
        let behind = surface.index[channel];
        let bent = index * ray.slope - ray.height * surface.curvature * (behind - index);
        (ray.slope, index) = (bent / behind, behind);
    }
    ray
}

/// Focal length and back focus of a lens, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Focus {
    pub(super) focal: f64,
    /// Distance from the last surface to the focus of an object at infinity.
    pub(super) back: f64,
}

/// Returns the focal length and the back focus of `surfaces` in a channel.
pub(super) fn focus(surfaces: &[Surface], channel: usize) -> Focus {
    let out = follow(
        surfaces,
        channel,
        ParaxialRay {
            height: 1.0,
            slope: 0.0,
        },
    );
    Focus {
        focal: -1.0 / out.slope,
        back: out.to_axis(),
    }
}

/// A paraxial entrance pupil.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pupil {
    /// Position, mm.
    pub(super) z: f64,
    /// Its radius over that of the stop.
    pub(super) growth: f64,
}

/// Returns the entrance pupil in green: the image of the stop in the scene.
pub(super) fn entrance_pupil(surfaces: &[Surface], stop: usize) -> Pupil {
    let at_stop = |ray: ParaxialRay| {
        let before = follow(&surfaces[..stop], GREEN, ray);
        let from = stop.checked_sub(1).map_or(0.0, |i| surfaces[i].vertex[2]);
        before.moved(surfaces[stop].vertex[2] - from).height
    };
    // Heights at the stop of the rays of height 1 and of slope 1 at z = 0.
    let high = at_stop(ParaxialRay {
        height: 1.0,
        slope: 0.0,
    });
    let steep = at_stop(ParaxialRay {
        height: 0.0,
        slope: 1.0,
    });
    // A ray through the middle of the stop has the height -steep / high at z = 0 for slope 1.
    Pupil {
        z: steep / high,
        growth: 1.0 / high,
    }
}

/// The course of the light of a channel to the sensor, by paraxial rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// Height of the marginal ray of an axis point, mm: defocus.
    pub(super) defocus: f64,
    /// Height of the chief ray of slope 1, mm: magnification.
    pub(super) chief: f64,
}

/// Returns the course of a channel for an axis point at `depth_m`.
pub(super) fn course(assembly: &Assembly, channel: usize, depth_m: f64) -> Course {
    let last = assembly.surfaces.len() - 1;
    let gap = assembly.sensor.centre[2] - assembly.surfaces[last].vertex[2];
    let to_sensor = |ray: ParaxialRay| follow(&assembly.surfaces, channel, ray).moved(gap).height;
    let view = assembly.view;
    let slope = view.pupil_mm / (1000.0 * depth_m);
    Course {
        defocus: to_sensor(ParaxialRay {
            height: view.pupil_mm - slope * view.pupil_z,
            slope,
        }),
        chief: to_sensor(ParaxialRay {
            height: -view.pupil_z,
            slope: 1.0,
        }),
    }
}
