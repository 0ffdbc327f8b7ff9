//! Edge sets: profiles of straight edges in photographs of one camera.
//!
//! A profile constrains the PSF along the normal of its edge only, at all of its shape: it is the integral of the line spread
//! function. With u on the pupil and n the normal, `E(t) = sum of w_k Phi((t - n.d_k) / s)` for rays that land at d_k with
//! light w_k (docs/background/model.md section 4).

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, Result};
use crate::field::{Frame, ImagePoint};

/// A bin of an edge profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileBin {
    /// Mean distance of its pixels from the edge along the normal, px: positive on the bright side.
    pub t_px: f64,
    /// Mean level, 0 on the dark and 1 on the bright side.
    pub level: f64,
    /// Standard deviation of the level.
    pub sigma: f64,
    /// Variance of the distances of its pixels, px².
    pub spread_px2: f64,
}

/// An edge in one channel of one photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// File of the photograph.
    pub source: String,
    /// Index of the edge in its photograph: the same in all channels.
    pub index: usize,
    /// Index of the channel.
    pub channel: usize,
    /// Distance of the object.
    pub distance: ObjectDistance,
    /// Middle of the edge.
    pub mid: ImagePoint,
    /// Unit normal (x, y), from dark to bright.
    pub normal: [f64; 2],
    /// Length of edge that was used, px.
    pub length_px: f64,
    /// Levels of the dark and the bright side, counts above black.
    pub levels: [f64; 2],
    /// Variance of the optical PSF along the normal, without the pixel's area, px².
    pub variance_px2: f64,
    /// Standard deviation of the variance, px².
    pub variance_sigma: f64,
    /// Third central moment along the normal, px³.
    pub third_px3: f64,
    /// Standard deviation of the third moment, px³.
    pub third_sigma: f64,
    /// Profile, by rising distance; zero distance is the centroid of the line spread function.
    pub profile: Vec<ProfileBin>,
}

impl Edge {
    /// Returns the level of the dark side over the step from dark to bright.
    pub fn dark_over_step(&self) -> f64 {
        let [dark, bright] = self.levels;
        dark / (bright - dark)
    }
}

/// The edges of photographs that one camera took with one lens at one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeSet {
    /// The full frame and its optical axis.
    pub frame: Frame,
    /// Channel names.
    pub channels: Vec<String>,
    /// Sensor pixel pitch, micrometres, if known.
    pub pixel_pitch_um: Option<f64>,
    /// Known settings of the camera.
    pub camera: Camera,
    /// The edges.
    pub edges: Vec<Edge>,
}

impl EdgeSet {
    /// Checks that every edge names a channel of the set and has a finite profile with positive errors.
    ///
    /// # Errors
    /// The first edge that does not, and the field.
    pub fn check(&self) -> Result<()> {
        for (index, edge) in self.edges.iter().enumerate() {
            if let Some((field, problem)) = self.fault_of(edge) {
                return Err(Error::new(
                    format!("edges[{index}].{field}"),
                    problem,
                    "measure the photograph again",
                ));
            }
        }
        Ok(())
    }

    fn fault_of(&self, edge: &Edge) -> Option<(&'static str, String)> {
        let [dark, bright] = edge.levels;
        let [x, y] = edge.normal;
        let numbers = [
            edge.mid.x_px,
            edge.mid.y_px,
            edge.length_px,
            edge.variance_px2,
            edge.third_px3,
        ];
        if edge.channel >= self.channels.len() {
            return Some(("channel", "is none of the set's".to_owned()));
        }
        if (x.hypot(y) - 1.0).abs() > 1e-6 {
            return Some(("normal", "is not a unit vector".to_owned()));
        }
        if !(dark.is_finite() && bright.is_finite() && bright > dark) {
            return Some(("levels", "do not rise from dark to bright".to_owned()));
        }
        if !numbers.iter().all(|v| v.is_finite()) {
            return Some(("variance", "or position is not finite".to_owned()));
        }
        let errors = [edge.variance_sigma, edge.third_sigma];
        if !errors.iter().all(|s| s.is_finite() && *s > 0.0) {
            return Some(("variance_sigma", "is not positive".to_owned()));
        }
        let sound = |b: &ProfileBin| {
            b.t_px.is_finite()
                && b.level.is_finite()
                && b.sigma.is_finite()
                && b.sigma > 0.0
                && b.spread_px2.is_finite()
                && b.spread_px2 >= 0.0
        };
        if edge.profile.len() < MIN_BINS || !edge.profile.iter().all(sound) {
            let problem = format!("is not {MIN_BINS} finite bins or more with positive errors");
            return Some(("profile", problem));
        }
        None
    }
}

/// Bins that a profile needs.
const MIN_BINS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    fn edge() -> Edge {
        let bin = |k: usize| ProfileBin {
            t_px: k as f64 - 5.0,
            level: 0.5,
            sigma: 0.01,
            spread_px2: 0.02,
        };
        Edge {
            source: "a.dng".to_owned(),
            index: 0,
            channel: 0,
            distance: ObjectDistance::Unknown,
            mid: ImagePoint::new(10.0, 10.0),
            normal: [0.6, -0.8],
            length_px: 20.0,
            levels: [100.0, 900.0],
            variance_px2: 1.0,
            variance_sigma: 0.1,
            third_px3: 0.0,
            third_sigma: 0.1,
            profile: (0..11).map(bin).collect(),
        }
    }

    #[test]
    fn faults_name_the_edge_and_its_field() {
        let mut set = EdgeSet {
            frame: Frame::new(100, 80, None).expect("valid"),
            channels: vec!["Y".to_owned()],
            pixel_pitch_um: None,
            camera: Camera::default(),
            edges: vec![edge(), edge()],
        };
        set.check().expect("sound");
        assert_eq!(set.edges[0].dark_over_step(), 0.125);
        set.edges[1].levels = [5.0, 5.0];
        let error = set.check().expect_err("no step").to_string();
        assert!(error.contains("edges[1].levels"), "{error}");
        set.edges[1] = Edge {
            channel: 1,
            ..edge()
        };
        assert!(set.check().is_err());
    }
}
