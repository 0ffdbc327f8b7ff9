//! Conventions of depth passes, and conversion to object vergence.

use rayon::prelude::*;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::ImagePoint;

/// The convention of a depth pass. All distances are along the optical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthConvention {
    /// Distance in units of `metres_per_unit`.
    Distance {
        /// Metres per unit; negative for passes of negative depth.
        metres_per_unit: f64,
    },
    /// 1 / distance, with distance in units of `metres_per_unit`; zero is infinity.
    Inverse {
        /// Metres per unit of distance.
        metres_per_unit: f64,
    },
    /// 0 at `near_m` and 1 at `far_m`, linear in distance.
    FarOne {
        /// Distance at 0, metres.
        near_m: f64,
        /// Distance at 1, metres.
        far_m: f64,
    },
    /// 1 at `near_m` and 0 at `far_m`, linear in distance.
    FarZero {
        /// Distance at 1, metres.
        near_m: f64,
        /// Distance at 0, metres.
        far_m: f64,
    },
}

/// The object vergence read from a depth pass, with counts of special pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthReading {
    /// Vergence of every pixel, 1 / distance in 1/m.
    pub vergence: Vec<f32>,
    /// Pixels at infinity.
    pub infinite: usize,
    /// Pixels whose distance is zero or negative; they count as infinitely far.
    pub empty: usize,
    /// Normalised values outside 0..1, clamped.
    pub outside: usize,
    /// Nearest and farthest finite distance, metres; `None` if every pixel is at infinity.
    pub range_m: Option<(f64, f64)>,
}

/// The counts and the range of a row of a depth pass, as in [`DepthReading`].
#[derive(Default)]
struct RowCounts {
    infinite: usize,
    empty: usize,
    outside: usize,
    range_m: Option<(f64, f64)>,
}

/// The meaning of one sample of a depth pass.
enum Sample {
    Metres(f64),
    Infinity,
    Empty,
    Invalid,
}

impl DepthReading {
    /// Converts distances r along the ray from the camera to distances z along its axis,
    /// z = r / sqrt(1 + (x² + y²) / F²).
    ///
    /// x and y are measured from `axis`, F is `focal_px`, all in pixel widths. The pass is `width` pixels wide; pixels are
    /// `pixel_aspect` times as wide as they are high.
    ///
    /// # Errors
    /// A focal length that is not above zero, and an axis that is not finite.
    pub fn turn_along_axis(
        &mut self,
        width: usize,
        axis: ImagePoint,
        focal_px: f64,
        pixel_aspect: f64,
    ) -> Result<()> {
        let finite = axis.x_px.is_finite() && axis.y_px.is_finite();
        if !(finite && focal_px.is_finite() && focal_px > 0.0) {
            return Err(Error::new(
                "focal length for distances along the ray",
                format!("is {focal_px} px, the axis at {axis:?}"),
                "give half the plate's width over the tangent of half its field of view, in plate pixels",
            ));
        }
        let mut range: Option<(f64, f64)> = None;
        for (index, vergence) in self.vergence.iter_mut().enumerate() {
            if *vergence <= 0.0 {
                continue;
            }
            let x = (index % width.max(1)) as f64 + 0.5 - axis.x_px;
            let y = ((index / width.max(1)) as f64 + 0.5 - axis.y_px) / pixel_aspect;
            let ray = (1.0 + (x * x + y * y) / (focal_px * focal_px)).sqrt();
            let turned = f64::from(*vergence) * ray;
            *vergence = turned as f32;
            let (near, far) = range.unwrap_or((f64::INFINITY, 0.0));
            range = Some((near.min(1.0 / turned), far.max(1.0 / turned)));
        }
        self.range_m = range;
        Ok(())
    }
}

impl DepthConvention {
    /// Reads a depth pass `width` pixels wide.
    ///
    /// # Errors
    /// A NaN or invalid value (the message names the pixel), a pass in which no pixel has a distance in front of the
    /// camera, and an invalid unit or range.
    pub fn read(&self, samples: &[f32], width: usize) -> Result<DepthReading> {
        self.check()?;
        let mut vergence = vec![0.0; samples.len()];
        let rows = vergence.par_chunks_mut(width.max(1));
        let rows = rows.zip(samples.par_chunks(width.max(1))).enumerate();
        let counts: Vec<RowCounts> = rows
            .map(|(row, (out, samples))| self.read_row(samples, row, out))
            .collect::<Result<_>>()?;
        let sum = |count: fn(&RowCounts) -> usize| counts.iter().map(count).sum();
        let ranges = counts.iter().filter_map(|counts| counts.range_m);
        let reading = DepthReading {
            vergence,
            infinite: sum(|counts| counts.infinite),
            empty: sum(|counts| counts.empty),
            outside: sum(|counts| counts.outside),
            range_m: ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))),
        };
        if reading.empty == samples.len() {
            return Err(Error::new(
                "depth pass",
                "has no pixel with a distance in front of the camera",
                "check its channel and convention; a pass of negative depth needs a negative unit",
            ));
        }
        Ok(reading)
    }

    /// Writes the vergences of the samples of `row` to `out`.
    fn read_row(&self, samples: &[f32], row: usize, out: &mut [f32]) -> Result<RowCounts> {
        let mut counts = RowCounts::default();
        for (column, (&value, out)) in samples.iter().zip(out).enumerate() {
            let normalised = matches!(self, Self::FarOne { .. } | Self::FarZero { .. });
            if normalised && !(0.0..=1.0).contains(&value) {
                counts.outside += 1;
            }
            match self.sample(f64::from(value)) {
                Sample::Metres(m) => {
                    let (near, far) = counts.range_m.unwrap_or((m, m));
                    counts.range_m = Some((near.min(m), far.max(m)));
                    *out = (1.0 / m) as f32;
                }
                Sample::Infinity => counts.infinite += 1,
                Sample::Empty => counts.empty += 1,
                Sample::Invalid => {
                    return Err(Error::new(
                        format!("pixel ({column}, {row})"),
                        format!("is {value}"),
                        "give every pixel a depth; the background may be at infinity",
                    ));
                }
            }
        }
        Ok(counts)
    }

    fn sample(&self, value: f64) -> Sample {
        if value.is_nan() {
            return Sample::Invalid;
        }
        match *self {
            Self::Distance { metres_per_unit } => {
                let metres = value * metres_per_unit;
                if metres == f64::INFINITY {
                    Sample::Infinity
                } else if metres > 0.0 {
                    Sample::Metres(metres)
                } else {
                    Sample::Empty
                }
            }
            Self::Inverse { metres_per_unit } => {
                if value == 0.0 {
                    Sample::Infinity
                } else if value.is_infinite() {
                    Sample::Invalid
                } else if value / metres_per_unit > 0.0 {
                    Sample::Metres(metres_per_unit / value)
                } else {
                    Sample::Empty
                }
            }
            Self::FarOne { near_m, far_m } => {
                Sample::Metres(near_m + value.clamp(0.0, 1.0) * (far_m - near_m))
            }
            Self::FarZero { near_m, far_m } => {
                Sample::Metres(far_m + value.clamp(0.0, 1.0) * (near_m - far_m))
            }
        }
    }

    fn check(&self) -> Result<()> {
        match *self {
            Self::Distance { metres_per_unit } | Self::Inverse { metres_per_unit } => {
                if metres_per_unit.is_finite() && metres_per_unit != 0.0 {
                    return Ok(());
                }
                Err(Error::new(
                    "depth unit",
                    format!("is {metres_per_unit} m"),
                    "give the metres per unit of the pass",
                ))
            }
            Self::FarOne { near_m, far_m } | Self::FarZero { near_m, far_m } => {
                if near_m > 0.0 && far_m > near_m && far_m.is_finite() {
                    return Ok(());
                }
                Err(Error::new(
                    "depth range",
                    format!("is {near_m} m to {far_m} m"),
                    "give a near distance above zero and a far distance beyond it",
                ))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_conventions_give_the_same_vergence() {
        let want = [0.5, 0.125];
        for (convention, samples) in [
            (
                DepthConvention::Distance {
                    metres_per_unit: 1.0,
                },
                [2.0, 8.0],
            ),
            (
                DepthConvention::Distance {
                    metres_per_unit: -0.01,
                },
                [-200.0, -800.0],
            ),
            (
                DepthConvention::Inverse {
                    metres_per_unit: 1.0,
                },
                [0.5, 0.125],
            ),
            (
                DepthConvention::Inverse {
                    metres_per_unit: 0.01,
                },
                [0.005, 0.00125],
            ),
            (
                DepthConvention::FarOne {
                    near_m: 2.0,
                    far_m: 10.0,
                },
                [0.0, 0.75],
            ),
            (
                DepthConvention::FarZero {
                    near_m: 2.0,
                    far_m: 10.0,
                },
                [1.0, 0.25],
            ),
        ] {
            let reading = convention.read(&samples, 2).expect("valid");
            for (got, want) in reading.vergence.iter().zip(want) {
                assert!((got - want).abs() < 1e-6, "{convention:?}: {got}");
            }
            let (near, far) = reading.range_m.expect("finite");
            assert!((near - 2.0).abs() < 1e-6 && (far - 8.0).abs() < 1e-5);
        }
    }

    #[test]
    fn empty_infinite_and_outside_pixels_are_counted() {
        let metres = DepthConvention::Distance {
            metres_per_unit: 1.0,
        };
        let reading = metres
            .read(&[1.0, f32::INFINITY, 0.0, -3.0], 2)
            .expect("valid");
        assert_eq!((reading.infinite, reading.empty), (1, 2));
        assert_eq!(reading.vergence, [1.0, 0.0, 0.0, 0.0]);
        let unit = DepthConvention::FarOne {
            near_m: 1.0,
            far_m: 2.0,
        };
        assert_eq!(unit.read(&[-0.5, 1.5, 0.5], 3).expect("valid").outside, 2);
    }

    #[test]
    fn invalid_values_and_conventions_are_refused() {
        let metres = DepthConvention::Distance {
            metres_per_unit: 1.0,
        };
        let error = metres.read(&[1.0, 2.0, f32::NAN], 2).expect_err("NaN");
        assert!(error.place.contains("(0, 1)"), "{error}");
        assert!(metres.read(&[0.0, -1.0], 2).is_err());
        let inverse = DepthConvention::Inverse {
            metres_per_unit: 1.0,
        };
        assert!(inverse.read(&[f32::INFINITY], 1).is_err());
        for bad in [
            DepthConvention::Distance {
                metres_per_unit: 0.0,
            },
            DepthConvention::FarOne {
                near_m: 0.0,
                far_m: 2.0,
            },
            DepthConvention::FarZero {
                near_m: 3.0,
                far_m: 2.0,
            },
        ] {
            assert!(bad.read(&[1.0], 1).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn distances_along_the_ray_convert_to_those_along_the_axis() {
        // A wall perpendicular to the axis at 2 m, in a field of view of 90 degrees.
        let (width, focal_px) = (9, 4.5);
        let axis = ImagePoint::new(4.5, 2.5);
        let ray = |k: usize| {
            let (x, y) = ((k % width) as f64 - 4.0, (k / width) as f64 - 2.0);
            (x * x + y * y + focal_px * focal_px).sqrt() / focal_px
        };
        let mut samples: Vec<f32> = (0..45).map(|k| (2.0 * ray(k)) as f32).collect();
        samples[3] = 0.0;
        let metres = DepthConvention::Distance {
            metres_per_unit: 1.0,
        };
        let mut reading = metres.read(&samples, width).expect("readable");
        reading
            .turn_along_axis(width, axis, focal_px, 1.0)
            .expect("a camera");
        for (k, v) in reading.vergence.iter().enumerate() {
            let want = if k == 3 { 0.0 } else { 0.5 };
            assert!((v - want).abs() < 1e-6, "{k}: {v}");
        }
        let (near, far) = reading.range_m.expect("a range");
        assert!((near - 2.0).abs() < 1e-6 && (far - 2.0).abs() < 1e-6);
        for bad in [0.0, -3.0, f64::NAN, f64::INFINITY] {
            assert!(
                reading.turn_along_axis(width, axis, bad, 1.0).is_err(),
                "{bad}"
            );
        }
    }
}
