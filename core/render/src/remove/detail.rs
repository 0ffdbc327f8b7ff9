//! Detail of a picture told from noise by its own spectra: small squares of the picture found so far and of what it leaves
//! unexplained, filtered as if the true picture had the spectrum that the one found has.
//!
//! Few slopes are a poor guide where a picture is all texture, or smooth because its camera was: there this gives back what
//! was flattened, and takes away what was made up. Where a few edges are all there is, it keeps off.

use super::local::Local;
use super::squares::Squares;
use super::transform::{Space, Transform};
use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// How much stronger a picture is than the one found tells, in power.
const STRONGER: f32 = 1.5;
/// How much is given up of what such a filter would: waves that only slopes tell are right in some pictures (drawn ones) and
/// wrong in others, and most of either gain is had on the way between.
const GIVEN_UP: f32 = 0.65;
/// Where slopes are spread as noise's (as for [`SPREAD`]) they tell nothing, and all of it is given up: from none more at
/// the first value on to all at the second.
const NOISE_LIKE: [f32; 2] = [0.65, 0.75];
/// A square with slopes spread so little (mean size over root mean square, squared) is left as it is, and from the second
/// value on not.
const SPREAD: [f32; 2] = [0.25, 0.35];
/// The same for slopes, in standard deviations of the noise: what is as even as this has no detail.
const STEEP: [f32; 2] = [0.3, 1.2];
/// The other way round for what the lens leaves unexplained, likewise: more than noise would is not to be gone after.
const UNEXPLAINED: [f32; 2] = [2.0, 1.2];

/// A picture on a plane, as far as it was found.
pub(super) struct Found<'a> {
    pub(super) picture: &'a [f32],
    /// Plate less what the lens makes of the picture, none where the plate is not known.
    pub(super) rest: &'a [f32],
    /// Lengths of the picture's slopes.
    pub(super) slopes: &'a [f32],
    /// Standard deviation of what is not known of the plate.
    pub(super) deviation: f32,
}

/// How `found` should change; squares that have no `share` somewhere are left as they are: other spectra are at work there.
pub(super) fn change(
    local: &Local,
    size: (usize, usize),
    found: &Found,
    share: Option<&[f32]>,
) -> Vec<f32> {
    let times = if local.squares.side.is_multiple_of(3 * 32) {
        local.squares.side / 32
    } else {
        3
    };
    let squares = Squares::new(size, local.squares.side / times);
    let transform = Transform::new(squares.side);
    let noise = found.deviation.powi(2) * squares.energy();
    let of_square = |space: &mut Space, place: &(i32, i32)| {
        if share.is_some_and(|share| !squares.is_full(share, *place)) {
            return None;
        }
        let mut rest = squares.cut(found.rest, *place);
        let lengths = squares.cut(found.slopes, *place);
        let sight = Sight::of((&lengths, &rest), &squares, found.deviation)?;
        let mut square = squares.cut(found.picture, *place);
        transform.forward(&mut square, space);
        let picture = space.spectrum.clone();
        transform.forward(&mut rest, space);
        let lens = local.spectrum_at(squares.middle(*place), times);
        for ((rest, picture), h) in space.spectrum.iter_mut().zip(&picture).zip(lens) {
            *rest = changed(*picture, *rest, h, (noise, sight.given_up)) * sight.trust;
        }
        transform.back(space, &mut square);
        Some(square)
    };
    let places = squares.places.par_iter();
    let parts: Vec<_> = places.map_init(Space::default, of_square).collect();
    squares.put_together(&parts)
}

/// The change of a wave: a Wiener filter's of what the lens made of the picture and the rest, the signal being as strong as
/// the picture, but for the share of the picture that is not given up.
fn changed(
    picture: Complex<f32>,
    rest: Complex<f32>,
    h: Complex<f32>,
    (noise, given_up): (f32, f32),
) -> Complex<f32> {
    let power = STRONGER * picture.norm_sqr();
    let all = h.norm_sqr() * power + noise;
    (h.conj() * rest * power - picture * (given_up * noise)) / all
}

/// What is to be done by the spectrum of a square.
struct Sight {
    /// How far to go by it, above 0 to 1.
    trust: f32,
    given_up: f32,
}

impl Sight {
    /// Of a square that has these lengths of slopes and rest, both under its window; none if it is to be left as it is.
    fn of((lengths, rest): (&[f32], &[f32]), squares: &Squares, deviation: f32) -> Option<Self> {
        let (mut sum, mut power, mut unexplained) = (0.0, 0.0, 0.0);
        for (length, rest) in lengths.iter().zip(rest) {
            sum += length;
            power += length * length;
            unexplained += rest * rest;
        }
        if power == 0.0 || deviation == 0.0 {
            return None;
        }
        let energy = squares.energy();
        let (size, power, unexplained) =
            (sum / squares.weight(), power / energy, unexplained / energy);
        let spread = size * size / power;
        let trust = ramp(spread, SPREAD)
            * ramp(power.sqrt() / deviation, STEEP)
            * ramp(unexplained.sqrt() / deviation, UNEXPLAINED);
        (trust > 0.0).then(|| Self {
            trust,
            given_up: GIVEN_UP + (1.0 - GIVEN_UP) * ramp(spread, NOISE_LIKE),
        })
    }
}

/// 0 before the first value, 1 from the second on.
fn ramp(value: f32, [from, to]: [f32; 2]) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}
