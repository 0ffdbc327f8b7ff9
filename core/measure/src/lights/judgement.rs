//! Faults that only all lights of a photograph show together: sharpening, a curve between light and values, motion, two lenses.

use seidel_optics::numeric::{median, quantile, scatter};

use super::{Found, LightSet, MeasuredLight};
use crate::checks::direction::{self, Blur};
use crate::checks::two_lenses::{self, Width};
use crate::checks::{Concern, Severity, black_level, greens, noise_correlation};
use crate::photograph::Photograph;
use crate::rejection::Reason;
use crate::robust_fit::linear_fit;

/// Lights that the checks of a photograph need.
const MIN_LIGHTS: usize = 12;
/// Multiple of its own error from which on a fault is beyond doubt.
const MIN_SIGMAS: f64 = 6.0;
/// Depth of a dark ring around the lights from which on a photograph was sharpened, share of the peak.
const MIN_RING: f64 = 0.004;
/// Change of the logarithm of the area of lights between faint and bright ones from which on values are no light. Linear simulated
/// photographs stay below 0.08, logarithmic ones reach 0.28 and those of gamma 2.4 0.19.
const MAX_WIDENING: f64 = 0.1;
/// Multiple of its own error from which on that change is beyond doubt. The area of lights set to one peak follows their brightness
/// without a curve: the photographs of the demo reach 6.7, those with a curve 14 to 31.
const MIN_CURVE_SIGMAS: f64 = 10.0;
/// Radius of that area in units of the extent of a light.
const AREA_REACH: f64 = 1.1;
/// Share of lights that clip or overlap from which on it is mentioned.
const MANY: f64 = 0.25;

/// Returns the covariance of `light` in `channel`.
fn covariance(light: &MeasuredLight, channel: usize) -> Option<[f64; 3]> {
    light.profiles[channel].as_ref().map(|p| p.covariance)
}

/// Returns the place of `light` from the middle of the frame, in half widths.
fn place(photo: &Photograph, light: &MeasuredLight) -> [f64; 2] {
    let half = photo.width as f64 / 2.0;
    let [x, y] = light.place();
    [(x - half) / half, (y - photo.height as f64 / 2.0) / half]
}

/// Returns whether dark rings surround the lights: the mean light around them, by distance, falls below that farther out.
fn sharpened(photo: &Photograph, found: &Found) -> Option<Concern> {
    let reach = found.extent_px.max(3.0);
    let bins = (2.6 * reach).ceil() as usize;
    let clear = |k: usize| {
        let peak = &found.peaks[k];
        let border =
            (peak.x.min(photo.width - 1 - peak.x)).min(peak.y.min(photo.height - 1 - peak.y));
        let alone = found.peaks.iter().enumerate().all(|(other, p)| {
            let off = (p.x as f64 - peak.x as f64).hypot(p.y as f64 - peak.y as f64);
            other == k || p.height < 0.03 * peak.height || off > bins as f64 + reach
        });
        alone && border > bins && peak.snr > 60.0 && !photo.is_clipped(peak.x, peak.y)
    };
    let plane = &found.signal.planes[photo.plane_of(photo.reference_channel())];
    let mut rings: Vec<Vec<f64>> = vec![Vec::new(); bins];
    for peak in (0..found.peaks.len())
        .filter(|k| clear(*k))
        .map(|k| &found.peaks[k])
    {
        let (mut sums, mut counts) = (vec![0.0; bins], vec![0.0; bins]);
        for y in peak.y - bins..=peak.y + bins {
            for x in peak.x - bins..=peak.x + bins {
                let off = (x as f64 - peak.x as f64).hypot(y as f64 - peak.y as f64) as usize;
                if off < bins {
                    sums[off] += f64::from(plane[y * photo.width + x]);
                    counts[off] += 1.0;
                }
            }
        }
        for ((ring, sum), count) in rings.iter_mut().zip(&sums).zip(&counts) {
            ring.push(sum / count / f64::from(peak.height));
        }
    }
    let lights = rings[0].len();
    if lights < MIN_LIGHTS {
        return None;
    }
    let outside = (2.0 * reach) as usize;
    let levels: Vec<f64> = rings.iter_mut().map(|ring| median(ring)).collect();
    let far = levels[outside..].iter().sum::<f64>() / (bins - outside) as f64;
    let (darkest, level) =
        (levels[..outside].iter().enumerate()).min_by(|a, b| a.1.total_cmp(b.1))?;
    let sigma = 1.25 * scatter(&rings[darkest]) / (lights as f64).sqrt();
    let depth = far - level;
    (depth > MIN_RING.max(MIN_SIGMAS * sigma)).then(|| {
        Concern::new(
            Severity::Refuse,
            &photo.name,
            format!(
                "was sharpened or enlarged: dark rings of {:.1} % of their peak surround the lights, {darkest} px away",
                100.0 * depth
            ),
            "give the raw file, or develop it at its own size without sharpening",
        )
    })
}

/// Returns how the photograph was processed.
pub(super) fn processed(photo: &Photograph, found: &Found) -> Option<Concern> {
    sharpened(photo, found).or_else(|| noise_correlation::check(photo))
}

/// Light of one tile and the area that it covers.
struct Spread {
    light: f64,
    /// Square of the light over the sum of its squares, px.
    area: f64,
}

fn spread(photo: &Photograph, light: &MeasuredLight, reach: f64) -> Option<Spread> {
    let channel = light.reference;
    let plane = &photo.planes[photo.plane_of(channel)];
    let ([cx, cy], [across, down]) = (light.place(), light.slope[channel]);
    let middle = [0, 1].map(|axis| {
        let (corner, size) = (
            [light.corner.0, light.corner.1],
            [light.size.0, light.size.1],
        );
        corner[axis] as f64 + size[axis] as f64 / 2.0
    });
    let (mut sum, mut squares) = (0.0, 0.0);
    for k in 0..light.size.0 * light.size.1 {
        let (x, y) = (
            light.corner.0 + k % light.size.0,
            light.corner.1 + k / light.size.0,
        );
        let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
        let is_used = light.mask.as_ref().is_none_or(|mask| mask[k]);
        if is_used && photo.covers(channel, x, y) && (px - cx).hypot(py - cy) < AREA_REACH * reach {
            let background =
                light.background[channel] + across * (px - middle[0]) + down * (py - middle[1]);
            let value = f64::from(plane[y * photo.width + x]) - background;
            sum += value;
            squares += value * value - light.noise_sigma[channel].powi(2);
        }
    }
    (sum > 0.0 && squares > 0.0).then(|| Spread {
        light: sum,
        area: sum * sum / squares,
    })
}

/// Returns whether bright lights cover a larger or smaller area than faint ones beside them, as where values are no light.
fn not_linear(photo: &Photograph, lights: &[&MeasuredLight], reach: f64) -> Option<Concern> {
    let degree = (1..=4)
        .rev()
        .find(|d| lights.len() > (d + 1) * (d + 2) + 6)?;
    let (mut rows, mut values, mut brightness) = (Vec::new(), Vec::new(), Vec::new());
    for light in lights {
        let Some(spread) = spread(photo, light, reach) else {
            continue;
        };
        let [x, y] = place(photo, light);
        let mut row = vec![spread.light.ln()];
        row.extend(
            (0..=degree)
                .flat_map(|m| (0..=degree - m).map(move |n| x.powi(m as i32) * y.powi(n as i32))),
        );
        brightness.push(row[0]);
        rows.push(row);
        values.push(spread.area.ln());
    }
    let range = quantile(&mut brightness.clone(), 0.9) - quantile(&mut brightness, 0.1);
    let fit = linear_fit(&rows, &values)?;
    let (slope, sigma) = (fit.coefficients[0], fit.sigmas[0]);
    let change = slope * range;
    (change.abs() > MAX_WIDENING && slope.abs() > MIN_CURVE_SIGMAS * sigma).then(|| {
        Concern::new(
            Severity::Refuse,
            &photo.name,
            format!(
                "is not linear in light: lights {:.1} times as bright as others cover an area {:.0} % {}",
                range.exp(),
                100.0 * change.exp_m1().abs(),
                if change > 0.0 { "larger" } else { "smaller" }
            ),
            "give the raw file, or state the transfer function of the picture; if it is linear, expose less",
        )
    })
}

/// Returns the second moments of `lights` in every channel of `photo`.
fn blurs(photo: &Photograph, lights: &[&MeasuredLight]) -> Vec<Vec<Blur>> {
    let of = |light: &&MeasuredLight, channel: usize| {
        Some(Blur {
            at: light.place(),
            covariance: covariance(light, channel)?,
        })
    };
    (0..photo.channels.len())
        .map(|channel| lights.iter().filter_map(|l| of(l, channel)).collect())
        .collect()
}

/// Returns the widths of `lights`.
fn widths(lights: &[&MeasuredLight]) -> Vec<Width> {
    let of = |light: &&MeasuredLight| {
        let [xx, _, yy] = covariance(light, light.reference)?;
        Some(Width {
            at: light.place(),
            normal: [0.0; 2],
            variance_px2: (xx + yy) / 2.0,
        })
    };
    lights.iter().filter_map(of).collect()
}

/// Returns the concerns about every photograph by itself, and about pairs at one distance.
pub(super) fn concerns(set: &LightSet, found: &[Found]) -> Vec<Concern> {
    let lights_of = |index: usize| -> Vec<&MeasuredLight> {
        set.lights
            .iter()
            .filter(|l| l.photograph == index)
            .collect()
    };
    let mut all = Vec::new();
    for (index, photo) in set.photographs.iter().enumerate() {
        let (found, lights) = (&found[index], lights_of(index));
        let reference = photo.reference_channel();
        all.extend(processed(photo, found));
        all.extend(greens::check(photo));
        all.extend(black_level::check(photo, &found.backgrounds[reference]));
        all.extend(overexposed(set, index, lights.len()));
        if lights.len() >= MIN_LIGHTS {
            all.extend(not_linear(photo, &lights, found.extent_px));
            all.extend(direction::check(photo, "lights", &blurs(photo, &lights)));
        }
    }
    let own = (0..set.photographs.len()).map(|index| widths(&lights_of(index)));
    let own: Vec<Vec<Width>> = own.collect();
    all.extend(two_lenses::check_all(&set.photographs, &own, "lights"));
    all
}

/// Returns whether much of the photograph was lost to clipping or to lights that overlap.
fn overexposed(set: &LightSet, index: usize, kept: usize) -> Option<Concern> {
    let count = |why: Reason| {
        let all = set.left_out.iter();
        all.filter(|l| l.photograph == index && l.why == why)
            .count()
    };
    let (clipped, double) = (count(Reason::Clipped), count(Reason::Double));
    let note = |problem: String, remedy: &str| {
        Some(Concern::new(
            Severity::Note,
            &set.photographs[index].name,
            problem,
            remedy,
        ))
    };
    if clipped as f64 > MANY * (kept + clipped) as f64 {
        return note(
            format!("is overexposed in part: {clipped} lights clip, {kept} were kept"),
            "expose less; where lights are missing the lens is a guess",
        );
    }
    if double > 2 * kept {
        return note(
            format!("has {double} lights that overlap others, {kept} were kept"),
            "put the lights farther apart, or the lens nearer to focus",
        );
    }
    None
}
