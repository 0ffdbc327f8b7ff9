//! Ringing beside lights and edges, and noise in flat areas, before removal and after it by each treatment of lights.

use crate::case::{self, WEIGHTS, blurred, lens_of_size, median, psnr_db, timed};
use crate::noise::Noise;
use crate::scenes::{LAMP_RADIUS, LAMPS, RingingScene, all, lamp_centre};
use crate::{Options, SIDE, pictures};
use seidel_optics::error::Result;
use seidel_render::remove::{Deconvolver, Lights, find_lights};
use seidel_render::{Gather, Plane, Renderer, Scene};

/// Distance from edges up to which light or its absence is an over- or undershoot, px.
const RING: usize = 24;
/// Pixels next to an edge that are left out, px: a result one pixel too soft is no ring.
const SOFT: usize = 2;
/// Distance from edges from which an area is flat, px.
const FLAT: usize = 40;
/// Border that is left out, px.
const BORDER: usize = 32;
/// Steps between neighbours that count as edges, as a share of the darker.
const EDGE: f32 = 0.2;

/// Prints the table of the scenes that the options name.
pub(crate) fn print(
    scene: &Scene,
    options: &Options,
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    println!(
        "| scene | lights | undershoot % | overshoot % | flat noise / plate noise | reported gain | light within 1.5 px % | gain dB | blurs |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for ringing in all().into_iter().filter(|s| s.name.contains(&options.only)) {
        eprintln!("{}", ringing.name);
        // Two plates that differ in their noise.
        let [plate, other] = [0, 1].map(|seed| plate(scene, &ringing, seed));
        let (plate, other) = (plate?, other?);
        let lens = lens_of_size(ringing.too_wide)?;
        let scene = &case::scene(&lens);
        let near = distances(&ringing.truth);
        for (name, lights) in [
            ("keep blur", Lights::KeepBlur),
            ("separate", Lights::Separate),
        ] {
            let deconvolver = Deconvolver {
                lights,
                ..Deconvolver::default()
            };
            let planes = [Plane {
                samples: &plate,
                weights: &WEIGHTS,
            }];
            let remove = || deconvolver.remove(scene, &planes, &|_| true);
            let other = [Plane {
                samples: &other,
                ..planes[0]
            }];
            let other = deconvolver.remove(scene, &other, &|_| true)?;
            let other = other[0].canvas.crop(&other[0].sharp);
            let removed = remove()?;
            let plane = &planes[0];
            let found = find_lights(scene, &[(deconvolver, *plane)], &|_| true)?;
            let reported =
                deconvolver.noise_gain(&found[0], scene, plane, &removed[0], &|_| true)?;
            let sharp = removed[0].canvas.crop(&removed[0].sharp);
            let (mut blurs, mut removals) = (Vec::new(), Vec::new());
            for _ in 0..options.rounds {
                let fast = Gather::default();
                blurs.push(timed(|| fast.render(scene, &planes, &|_| true))?);
                removals.push(timed(remove)?);
            }
            if let Some(folder) = &options.out {
                let file = format!("{}-{name}.f32", ringing.name).replace(' ', "-");
                pictures::write(&folder.join(file), &sharp)?;
            }
            let case = Case {
                ringing: &ringing,
                plate: &plate,
                sharp: &sharp,
                other: &other,
                reported: &reported,
                near: &near,
            };
            case.print(name, median(removals) / median(blurs));
        }
    }
    Ok(())
}

fn plate(scene: &Scene, ringing: &RingingScene, seed: u64) -> Result<Vec<f32>> {
    let blurred = blurred(scene, &ringing.truth)?;
    let mut plate = Noise::White.add_to(&blurred, ringing.noise, seed);
    for sample in &mut plate {
        *sample = sample.min(ringing.clip);
        if let Some(bits) = ringing.bits {
            let levels = ((1_u32 << bits) - 1) as f32;
            *sample = (*sample * levels).round() / levels;
        }
    }
    Ok(plate)
}

/// Returns the distance of each pixel from the nearest edge along rows and columns (Chebyshev), up to [`FLAT`].
fn distances(truth: &[f32]) -> Vec<usize> {
    let at = |x: usize, y: usize| truth[y * SIDE + x];
    let is_edge = |k: usize| {
        let (x, y) = (k % SIDE, k / SIDE);
        [(x + 1, y), (x, y + 1)].iter().any(|(nx, ny)| {
            let inside = *nx < SIDE && *ny < SIDE;
            inside && (at(*nx, *ny) - at(x, y)).abs() > EDGE * at(*nx, *ny).min(at(x, y))
        })
    };
    let mut distance: Vec<usize> = (0..SIDE * SIDE)
        .map(|k| if is_edge(k) { 0 } else { FLAT })
        .collect();
    for step in 1..FLAT {
        let last = distance.clone();
        for k in 0..SIDE * SIDE {
            let (x, y) = (k % SIDE, k / SIDE);
            let touches = (y.saturating_sub(1)..(y + 2).min(SIDE)).any(|y| {
                (x.saturating_sub(1)..(x + 2).min(SIDE)).any(|x| last[y * SIDE + x] < step)
            });
            if touches && last[k] == FLAT {
                distance[k] = step;
            }
        }
    }
    distance
}

/// A result, with what it is compared to.
struct Case<'a> {
    ringing: &'a RingingScene,
    plate: &'a [f32],
    sharp: &'a [f32],
    /// The result for the plate with other noise.
    other: &'a [f32],
    reported: &'a [f32],
    near: &'a [usize],
}

/// Over- and undershoot, % of the local light.
struct Shoots {
    under: f64,
    over: f64,
}

impl Case<'_> {
    fn print(&self, lights: &str, blurs: f64) {
        let all = self.shoots(|_, _| true);
        let (flat, reported) = self.flat_noise();
        println!(
            "| {} | {lights} | {:.1} | {:.1} | {flat:.2} | {reported:.2} | | {:+.2} | {blurs:.1} |",
            self.ringing.name,
            all.under,
            all.over,
            psnr_db(self.sharp, &self.ringing.truth) - psnr_db(self.plate, &self.ringing.truth),
        );
        if !self.ringing.name.contains("lamps") {
            return;
        }
        for (index, light) in LAMPS.iter().enumerate() {
            let (cx, cy) = lamp_centre(index);
            let far = |x: usize, y: usize| (x as f64 - cx).hypot(y as f64 - cy);
            let shoots = self.shoots(|x, y| far(x, y) < 60.0);
            let within = |plane: &[f32], radius: f64| {
                let inside = (0..SIDE * SIDE).filter(|k| far(k % SIDE, k / SIDE) < radius);
                let light = inside.map(|k| f64::from(plane[k] - crate::scenes::GROUND));
                light.sum::<f64>()
            };
            let share = |plane: &[f32]| {
                100.0 * within(plane, LAMP_RADIUS + 1.5) / within(&self.ringing.truth, 20.0)
            };
            println!(
                "| - lamp of {light} | {lights} | {:.1} | {:.1} | | | {:.0} -> {:.0} | | |",
                shoots.under,
                shoots.over,
                share(self.plate),
                share(self.sharp),
            );
        }
    }

    /// Returns the largest shoots of means over 3 x 3 px beside edges, among the `chosen` pixels.
    fn shoots(&self, chosen: impl Fn(usize, usize) -> bool) -> Shoots {
        let mut shoots = Shoots {
            under: 0.0,
            over: 0.0,
        };
        for y in BORDER..SIDE - BORDER {
            for x in BORDER..SIDE - BORDER {
                let distance = self.near[y * SIDE + x];
                if !(SOFT + 1..RING).contains(&distance) || !chosen(x, y) {
                    continue;
                }
                let mean = |plane: &[f32]| {
                    let rows = (y - 1..y + 2).map(|y| &plane[y * SIDE + x - 1..y * SIDE + x + 2]);
                    rows.flatten().map(|v| f64::from(*v)).sum::<f64>() / 9.0
                };
                let truth = mean(&self.ringing.truth);
                if truth > f64::from(self.ringing.clip) {
                    continue;
                }
                let excess = 100.0 * (mean(self.sharp) / truth - 1.0);
                shoots.over = shoots.over.max(excess);
                shoots.under = shoots.under.max(-excess);
            }
        }
        shoots
    }

    /// Returns the noise in flat areas over that of the plate, from two results, and the noise gain reported for them, as
    /// root mean squares.
    fn flat_noise(&self) -> (f64, f64) {
        let (mut errors, mut reported, mut count) = (0.0, 0.0, 0.0);
        for y in BORDER..SIDE - BORDER {
            for x in BORDER..SIDE - BORDER {
                let k = y * SIDE + x;
                if self.near[k] >= FLAT {
                    errors += f64::from(self.sharp[k] - self.other[k]).powi(2) / 2.0;
                    reported += f64::from(self.reported[k]).powi(2);
                    count += 1.0;
                }
            }
        }
        let noise = match self.ringing.bits {
            Some(bits) => self
                .ringing
                .noise
                .hypot(1.0 / f64::from((1_u32 << bits) - 1) / 12.0_f64.sqrt()),
            None => self.ringing.noise,
        };
        ((errors / count).sqrt() / noise, (reported / count).sqrt())
    }
}
