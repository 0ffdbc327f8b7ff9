//! Pupils mirrored along the axes of the image.

use super::{LocalPupil, Stop, Transmission};

impl LocalPupil {
    /// Returns the pupil mirrored along x and y, as `along` says, which mirrors the PSF; `None` for a pupil with a picture, or behind
    /// which the sensor is not ideal.
    #[must_use]
    pub fn mirrored(&self, along: [bool; 2]) -> Option<Self> {
        if self.transmission.picture.is_some() || !self.sensor.is_ideal() {
            return None;
        }
        let [x, y] = along.map(|mirrored| if mirrored { -1.0 } else { 1.0 });
        let moved = |centre: [f64; 2]| [x * centre[0], y * centre[1]];
        let stop = |stop: Stop| Stop {
            centre: moved(stop.centre),
            ..stop
        };
        Some(Self {
            wavefront: self.wavefront.mirrored(along),
            stops: self.stops.map(stop),
            outer: self.outer.map(stop),
            obstruction: self.obstruction.map(stop),
            transmission: Transmission {
                centre: moved(self.transmission.centre),
                ..self.transmission.clone()
            },
            ..*self
        })
    }
}
