//! What is drawn of each source pixel: the blur and the shift of its light in each channel, and which
//! neighbours share a kernel.

use super::{Displacement, PlacedBlur, Plane, Scene};
use crate::error::{Error, Result};
use crate::field::Frame;
use crate::psf::{LocalBlur, PsfModel};

/// Least variance of a displaced kernel, plate px². Undisplaced centroids lie on pixel centres;
/// displaced ones drift past them. A kernel much narrower than a pixel, seen only at pixel centres,
/// is all on one pixel until its centroid passes half way and then all on the next: where
/// displacement shrinks the picture two sources land on one pixel, where it stretches one pixel gets
/// none, and an even surface shows bright and dark lines. With variance v the light passes from pixel
/// to pixel at most 1 / (4 v) times as fast as the centroid moves, so the lines have at most 1.5
/// times the contrast of the displacement's own gradient (1 % of distortion: 1.5 %).
const DISPLACED_VARIANCE_PX2: f64 = 0.1;

/// Largest standard deviation and displacement that are drawn, plate px: beyond any use, and short of
/// filling the machine's memory with one kernel.
const LARGEST_SIGMA_PX: f64 = 512.0;
const LARGEST_DISPLACEMENT_PX: f64 = 4096.0;

/// A source pixel's light in one channel, ready to be drawn.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Source {
    pub(super) blur: LocalBlur,
    pub(super) shift_px: (f64, f64),
}

/// The sources of a scene, row by row.
pub(super) struct Sources<'a> {
    scene: &'a Scene<'a>,
    frame: Frame,
    channel_count: usize,
}

impl<'a> Sources<'a> {
    pub(super) fn new(scene: &'a Scene<'a>) -> Self {
        Self {
            scene,
            frame: scene.lens.frame(),
            channel_count: scene.lens.channel_count(),
        }
    }

    /// The light to draw of plate row `row`: for each channel, columns and kernels.
    pub(super) fn of_row(
        &self,
        planes: &[Plane],
        row: usize,
        sources: &mut [Vec<(usize, Source)>],
    ) -> Result<()> {
        sources.iter_mut().for_each(Vec::clear);
        let width = self.scene.width;
        let mut placed = vec![None; self.channel_count];
        for column in 0..width {
            let index = row * width + column;
            let has_light = |channel: usize| {
                planes
                    .iter()
                    .any(|plane| plane.weights[channel] != 0.0 && plane.samples[index] != 0.0)
            };
            if !(0..self.channel_count).any(has_light) {
                continue;
            }
            let mean_needed = self.scene.displacement == Displacement::Lateral;
            for (channel, placed) in placed.iter_mut().enumerate() {
                *placed = if mean_needed || has_light(channel) {
                    Some(self.placed(channel, column, row)?)
                } else {
                    None
                };
            }
            let mean = mean_needed.then(|| mean_displacement(&placed));
            for (channel, (placed, sources)) in placed.iter().zip(&mut *sources).enumerate() {
                if let Some(placed) = placed
                    && has_light(channel)
                {
                    sources.push((column, self.source(placed, mean)));
                }
            }
        }
        Ok(())
    }

    /// What is to be drawn of plate pixel (`column`, `row`) in one channel.
    pub(super) fn at(&self, channel: usize, column: usize, row: usize) -> Result<Source> {
        if self.scene.displacement != Displacement::Lateral {
            return Ok(self.source(&self.placed(channel, column, row)?, None));
        }
        let all = (0..self.channel_count)
            .map(|channel| self.placed(channel, column, row).map(Some))
            .collect::<Result<Vec<_>>>()?;
        let own = all[channel].as_ref().expect("every channel is placed");
        Ok(self.source(own, Some(mean_displacement(&all))))
    }

    /// What the lens does to a pixel in one channel, in plate pixels.
    fn placed(&self, channel: usize, column: usize, row: usize) -> Result<PlacedBlur> {
        let scene = self.scene;
        let scale = scene.map.scale;
        let at = self.frame.field_point(scene.map.frame_point(column, row));
        let vergence = scene.vergence_at(row * scene.width + column);
        let PlacedBlur {
            blur,
            displacement_px: (x, y),
        } = scene.lens.blur_at(channel, at, vergence);
        let placed = PlacedBlur {
            blur: blur.rescaled(scale),
            displacement_px: (x * scale, y * scale),
        };
        let moments = placed.blur.moments;
        let small = |moment: f64| moment.abs() <= LARGEST_SIGMA_PX * LARGEST_SIGMA_PX;
        let drawable = [moments.mu20, moments.mu11, moments.mu02]
            .into_iter()
            .all(small)
            && moments.to_array().iter().all(|moment| moment.is_finite());
        let near = |shift: f64| shift.abs() <= LARGEST_DISPLACEMENT_PX;
        if drawable && near(placed.displacement_px.0) && near(placed.displacement_px.1) {
            return Ok(placed);
        }
        Err(Error::new(
            format!("lens channel {channel} at plate pixel ({column}, {row})"),
            format!(
                "blurs with central moments {:?} (px², px³) and displaces by ({}, {}) px",
                moments.to_array(),
                placed.displacement_px.0,
                placed.displacement_px.1
            ),
            format!(
                "check lens and depth (vergence {vergence} m^-1); the largest blur drawn has a \
                 standard deviation of {LARGEST_SIGMA_PX} px, the largest displacement is \
                 {LARGEST_DISPLACEMENT_PX} px"
            ),
        ))
    }

    /// The kernel to draw, given the mean displacement of all channels where that is taken off.
    fn source(&self, placed: &PlacedBlur, mean: Option<(f64, f64)>) -> Source {
        let (x, y) = placed.displacement_px;
        let (shift_px, floor) = match (self.scene.displacement, mean) {
            (Displacement::None, _) => {
                return Source {
                    blur: placed.blur,
                    shift_px: (0.0, 0.0),
                };
            }
            (_, Some(mean)) => ((x - mean.0, y - mean.1), DISPLACED_VARIANCE_PX2),
            (_, None) => ((x, y), DISPLACED_VARIANCE_PX2),
        };
        Source {
            blur: placed.blur.with_least_variance(floor),
            shift_px,
        }
    }
}

/// Cuts a row of one channel's sources into runs that share a kernel, that of the source in their
/// middle: neighbours to which the lens does the same, or so nearly that the model says it cannot be
/// seen.
pub(super) fn runs<'a>(
    model: &'a dyn PsfModel,
    mut rest: &'a [(usize, Source)],
) -> impl Iterator<Item = (&'a [(usize, Source)], Source)> {
    std::iter::from_fn(move || {
        let (_, first) = rest.first()?;
        let alike = |&&(_, source): &&(usize, Source)| {
            model.alike(
                (&first.blur, first.shift_px),
                (&source.blur, source.shift_px),
            )
        };
        let count = 1 + rest[1..].iter().take_while(alike).count();
        let (run, others) = rest.split_at(count);
        rest = others;
        Some((run, run[count / 2].1))
    })
}

fn mean_displacement(placed: &[Option<PlacedBlur>]) -> (f64, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    for placed in placed.iter().flatten() {
        x += placed.displacement_px.0;
        y += placed.displacement_px.1;
    }
    let count = placed.len() as f64;
    (x / count, y / count)
}
