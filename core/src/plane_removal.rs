//! The removal of blur from the planes of a plate: from all of the plate at once, or from its foreground and background.

use seidel_optics::Progress;
use seidel_optics::error::{Error, Result};
use seidel_render::remove::{Deconvolver, DepthSplit, SharpPlane, SplitPlane, find_lights};
use seidel_render::{Plane, Scene};

/// The amplification of noise by a removal: a measurement takes as long again as the removal itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseGain {
    /// Not measured.
    #[default]
    Skip,
    /// Measured for each pixel of each colour.
    Measure,
}

/// The planes of a plate, colours first, each with the settings of its removal.
pub(crate) struct RemovalPlanes<'a> {
    pub(crate) planes: Vec<(Deconvolver, Plane<'a>)>,
    pub(crate) colour_count: usize,
}

/// The solution of each plane.
#[derive(Debug, Clone, Default)]
pub(crate) struct SolvedPlanes {
    pub(crate) sharp: Vec<SharpPlane>,
    /// Amplification of noise in each colour, if it was measured.
    pub(crate) noise_gain: Vec<Vec<f32>>,
    /// Whether foreground and background were solved by themselves.
    pub(crate) is_split: bool,
}

impl RemovalPlanes<'_> {
    /// Removes the blur of `scene`'s lens. The lights of all colours are found together.
    ///
    /// # Errors
    /// Those of [`Deconvolver::remove`].
    pub(crate) fn solve(
        &self,
        scene: &Scene,
        noise_gain: NoiseGain,
        progress: &Progress,
    ) -> Result<SolvedPlanes> {
        let measures = noise_gain == NoiseGain::Measure;
        let (colours, others) = self.planes.split_at(self.colour_count);
        let steps = 1 + self.planes.len() + if measures { colours.len() } else { 0 };
        let share = |done: usize, part: f64| progress((done as f64 + part) / steps as f64);
        let lights = find_lights(scene, colours, &|part| share(0, part))?;
        let mut done = 1;
        let mut found = SolvedPlanes::default();
        for ((deconvolver, plane), lights) in colours.iter().zip(&lights) {
            let in_part = |part| share(done, part);
            let sharp = deconvolver.remove_around(lights, scene, plane, &in_part)?;
            done += 1;
            if measures {
                let in_part = |part| share(done, part);
                let gain = deconvolver.noise_gain(lights, scene, plane, &sharp, &in_part)?;
                found.noise_gain.push(gain);
                done += 1;
            }
            found.sharp.push(sharp);
        }
        for (deconvolver, plane) in others {
            let in_part = |part| share(done, part);
            found
                .sharp
                .extend(deconvolver.remove(scene, &[*plane], &in_part)?);
            done += 1;
        }
        Ok(found)
    }

    /// Removes the blur of foreground and background of `split` by themselves; `clean` are the same planes of the clean
    /// plate.
    ///
    /// # Errors
    /// Those of [`Self::solve`], and another number of planes.
    pub(crate) fn solve_split(
        &self,
        split: &DepthSplit,
        clean: &[Vec<f32>],
        noise_gain: NoiseGain,
        progress: &Progress,
    ) -> Result<SolvedPlanes> {
        if clean.len() != self.planes.len() {
            return Err(Error::new(
                "background",
                format!(
                    "has {} planes, the plate {}",
                    clean.len(),
                    self.planes.len()
                ),
                "give one with the channels of the plate",
            ));
        }
        let parts: Vec<SplitPlane> = (self.planes.iter().zip(clean))
            .map(|((deconvolver, plane), clean)| split.split(deconvolver, plane, clean))
            .collect::<Result<_>>()?;
        let of = |part: fn(&SplitPlane) -> &(Deconvolver, Vec<f32>)| RemovalPlanes {
            planes: (parts.iter().zip(&self.planes))
                .map(|(split, (_, plane))| {
                    let (deconvolver, samples) = part(split);
                    (*deconvolver, Plane { samples, ..*plane })
                })
                .collect(),
            colour_count: self.colour_count,
        };
        let half = |done: f64| move |share: f64| progress(0.5 * (done + share));
        let foreground = of(|plane| &plane.foreground);
        let foreground = foreground.solve(&split.foreground_scene(), noise_gain, &half(0.0))?;
        let background = of(|plane| &plane.background);
        let background = background.solve(&split.background_scene(), noise_gain, &half(1.0))?;
        let sharp = (parts.iter().zip(&foreground.sharp).zip(&background.sharp))
            .map(|((plane, front), back)| split.join(plane, front, back));
        let noise_gain = (foreground.noise_gain.iter().zip(&background.noise_gain))
            .map(|(front, back)| split.join_maps(front, back));
        Ok(SolvedPlanes {
            sharp: sharp.collect(),
            noise_gain: noise_gain.collect(),
            is_split: true,
        })
    }
}
