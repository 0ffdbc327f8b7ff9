//! Two photographs at one stated distance whose blur differs: another lens, focus or distance.

use seidel_optics::numeric::{median, scatter};

use super::{Concern, Severity};
use crate::photograph::Photograph;

/// Pairs that the check needs.
const MIN_PAIRS: usize = 12;
/// Difference of the variances of two photographs, as a share, and multiple of its own error from which on it is beyond doubt.
const MAX_DIFFERENCE: f64 = 0.04;
const MIN_SIGMAS: f64 = 6.0;
/// Largest distance between two places whose blur is compared, as a share of the width of the frame.
const NEAR_SHARE: f64 = 0.08;

/// Variance of the blur at a place, along a direction where it has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Width {
    /// Frame position, px.
    pub at: [f64; 2],
    /// Unit vector along which the variance was measured; zero for all directions.
    pub normal: [f64; 2],
    /// Variance, with the pixel's area, px².
    pub variance_px2: f64,
}

/// Cosine of the angle within which two directions are compared.
const MIN_COSINE: f64 = 0.97;

/// Returns whether `things` of photograph `b` are wider or narrower than those beside them in photograph `a`.
pub fn check(
    a: (&Photograph, &[Width]),
    b: (&Photograph, &[Width]),
    things: &str,
) -> Option<Concern> {
    let near = NEAR_SHARE * a.0.width as f64;
    let mut ratios: Vec<f64> = (b.1.iter())
        .filter_map(|own| {
            let off = |other: &Width| (other.at[0] - own.at[0]).hypot(other.at[1] - own.at[1]);
            let along = |other: &&Width| {
                let cosine = own.normal[0] * other.normal[0] + own.normal[1] * other.normal[1];
                own.normal == [0.0; 2] || cosine.abs() > MIN_COSINE
            };
            let beside = a.1.iter().filter(along);
            let nearest = beside.min_by(|p, q| off(p).total_cmp(&off(q)))?;
            let ratio = (own.variance_px2 / nearest.variance_px2).ln();
            (off(nearest) < near && ratio.is_finite()).then_some(ratio)
        })
        .collect();
    if ratios.len() < MIN_PAIRS {
        return None;
    }
    let sigma = 1.25 * scatter(&ratios) / (ratios.len() as f64).sqrt();
    let middle = median(&mut ratios);
    (middle.abs() > MAX_DIFFERENCE.max(MIN_SIGMAS * sigma)).then(|| {
        Concern::new(
            Severity::Refuse,
            &b.0.name,
            format!(
                "shows another lens, focus or distance than {}: the variance of its {things} is {:.0} % {}, at one stated distance",
                a.0.name,
                100.0 * middle.exp_m1().abs(),
                if middle > 0.0 { "larger" } else { "smaller" }
            ),
            "state the distance of each photograph, or measure them one by one",
        )
    })
}

/// Returns the concerns about every photograph and the first at its distance; `widths` are those of the photographs.
pub fn check_all(photographs: &[Photograph], widths: &[Vec<Width>], things: &str) -> Vec<Concern> {
    let each = photographs.iter().enumerate().filter_map(|(index, photo)| {
        let mut earlier = photographs[..index].iter();
        let first = earlier.position(|p| p.distance == photo.distance)?;
        let (a, b) = (&widths[first], &widths[index]);
        check((&photographs[first], a), (photo, b), things)
    });
    each.collect()
}
