//! An opaque disc in the pupil, and the part of its shadow that lies within the stops.

use super::quadrature::{Fan, MORE_DIRECTIONS};
use super::{LocalPupil, Stop};

/// Smallest distance of the centre of a shadow from the edge of the pupil, in pupil radii, at which the pupil is a ring about it.
const LEAST_DEPTH: f64 = 0.02;
/// Largest radius of a shadow over that of the pupil about its centre: a PSF always has light.
const LARGEST: f64 = 0.98;

/// The shadow of the obstruction of a pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shadow {
    /// Its centre lies within the stops: the pupil is a ring about it, of which parts may be dark.
    Ring(Stop),
    /// Its centre lies outside the stops: it darkens a part of the pupil.
    Part(Stop),
}

impl LocalPupil {
    /// Puts the opaque `disc` into the pupil. The larger one counts where there is one already.
    pub fn obstruct(&mut self, disc: Stop) {
        if disc.radius > self.obstruction.map_or(0.0, |old| old.radius) {
            self.obstruction = Some(disc);
        }
    }

    /// Puts `disc` in the place of the opaque disc in the pupil.
    pub fn set_obstruction(&mut self, disc: Stop) {
        self.obstruction = Some(disc);
    }

    /// Returns the opaque disc in the pupil.
    pub fn obstruction(&self) -> Option<Stop> {
        self.obstruction
    }

    /// Returns the shadow of the obstruction within the stops. A disc that would take all light is smaller, or left out if
    /// its centre lies outside the stops.
    pub fn shadow(&self) -> Option<Shadow> {
        let disc = self.obstruction?;
        if self.depth(disc.centre) <= LEAST_DEPTH {
            let rays = self.fan_within_stops().rays(&self.transmission);
            let passes = rays.iter().any(|(_, u)| disc.depth(*u) <= 0.0);
            return passes.then_some(Shadow::Part(disc));
        }
        let reaches = self.edges(disc.centre, &MORE_DIRECTIONS);
        let farthest = reaches.into_iter().fold(0.0, f64::max);
        Some(Shadow::Ring(Stop {
            radius: disc.radius.min(LARGEST * farthest),
            ..disc
        }))
    }

    /// Returns rays over a pupil with an obstruction.
    pub(super) fn fan_beside_obstruction(&self) -> Fan {
        let disc = match self.shadow() {
            Some(Shadow::Ring(disc)) => disc,
            Some(Shadow::Part(disc)) => {
                return Fan {
                    dark: Some(disc),
                    ..self.fan_within_stops()
                };
            }
            None => return self.fan_within_stops(),
        };
        let outer = self.edges(disc.centre, &MORE_DIRECTIONS);
        Fan {
            centre: disc.centre,
            directions: &MORE_DIRECTIONS,
            inner: outer.iter().map(|outer| disc.radius.min(*outer)).collect(),
            outer,
            dark: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::Wavefront;

    fn disc(x: f64, radius: f64) -> Stop {
        Stop {
            centre: [x, 0.0],
            radius,
        }
    }

    #[test]
    fn moments_are_those_of_a_ring() {
        let mut wavefront = Wavefront::default();
        wavefront.add_monomial(2, 0, 2.0);
        wavefront.add_monomial(0, 2, 2.0);
        let mut pupil = LocalPupil::circular(wavefront, 0.0);
        pupil.obstruct(disc(0.0, 0.6));
        let (moments, centroid) = pupil.moments();
        // The mean of r² over a ring is (R² + h²) / 2; landing points are 4 u.
        let want = 16.0 * (1.0 + 0.36) / 4.0;
        assert!((moments.mu20 - want).abs() < 1e-9, "{moments:?}");
        assert!(centroid[0].hypot(centroid[1]) < 1e-9);
        pupil.obstruct(disc(0.0, 0.3));
        assert_eq!(pupil.obstruction(), Some(disc(0.0, 0.6)));
        assert!(!pupil.passes([0.5, 0.0]) && pupil.passes([0.7, 0.0]));
        let half = pupil.with_pupil(2.0);
        assert_eq!(half.obstruction(), Some(disc(0.0, 0.3)));
    }

    #[test]
    fn some_light_is_left() {
        let pupil = |blocked: Stop| {
            let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
            pupil.clip(disc(1.2, 1.0));
            pupil.obstruct(blocked);
            pupil
        };
        let all = pupil(disc(0.6, 5.0)).shadow();
        assert!(matches!(all, Some(Shadow::Ring(ring)) if ring.radius < 1.0));
        assert_eq!(pupil(disc(-0.5, 9.0)).shadow(), None);
        let part = pupil(disc(0.0, 0.4));
        assert!(matches!(part.shadow(), Some(Shadow::Part(_))));
        assert!(part.centroid()[0].is_finite());
    }
}
