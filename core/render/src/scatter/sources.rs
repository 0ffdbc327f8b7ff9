//! Blur and displacement of single source points, in plate pixels, and runs of neighbours that share a kernel.

use crate::depth::distance_span;
use crate::{DisplacedBlur, Displacement, Plane, Scene};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{Frame, ImagePoint, Meridian};
use seidel_optics::psf::{LocalBlur, PsfModel};

/// Largest variance that a displaced kernel needs, plate px².
///
/// Undisplaced centroids lie on pixel centres; displaced ones drift past them. A kernel much narrower than a pixel is
/// sampled on one pixel until its centroid passes half way, and then on the next. Where displacement shrinks the
/// picture two sources land on one pixel, where it stretches one pixel gets none: even surfaces show bright and dark
/// lines. With variance v the light passes from pixel to pixel at most 1 / (4 v) times as fast as the centroid moves,
/// so the lines have at most 1.5 times the contrast of the displacement's own gradient (1 % of distortion: 1.5 %).
const DISPLACED_VARIANCE_PX2: f64 = 0.1;

/// Largest standard deviation and displacement drawn, plate px: beyond any use, yet one kernel still fits in memory.
const LARGEST_SIGMA_PX: f64 = 512.0;
const LARGEST_DISPLACEMENT_PX: f64 = 4096.0;

/// The kernel of a source point in one channel, ready to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Source {
    pub(crate) blur: LocalBlur,
    /// Offset of the centroid from the source point, px.
    pub(crate) shift_px: (f64, f64),
}

impl Source {
    /// Returns the source whose meridian lies in the quadrant of positive x and y, and the axes along which it mirrors this one.
    ///
    /// Sources of a lens with mirror symmetry, opposite to each other across its axes, have the same one to the bit. Without rays, or with
    /// rays that cannot be mirrored, it is the source itself.
    pub(crate) fn unmirrored(&self) -> (Self, [bool; 2]) {
        let along = [self.blur.meridian.cos < 0.0, self.blur.meridian.sin < 0.0];
        let mirrored = (self.blur.pupil.as_ref())
            .filter(|_| along != [false; 2])
            .and_then(|pupil| pupil.mirrored(along));
        let Some(pupil) = mirrored else {
            return (self.clone(), [false; 2]);
        };
        let sign = |mirrored: bool| if mirrored { -1.0 } else { 1.0 };
        let [x, y] = along.map(sign);
        let blur = LocalBlur {
            moments: self.blur.moments.mirrored(along),
            meridian: Meridian {
                cos: x * self.blur.meridian.cos,
                sin: y * self.blur.meridian.sin,
            },
            pupil: Some(pupil),
            ..self.blur
        };
        let shift_px = (x * self.shift_px.0, y * self.shift_px.1);
        (Self { blur, shift_px }, along)
    }
}

/// Returns the least variance of a kernel displaced by `shift_px` along an axis, px²: that of linear interpolation between the two
/// nearest pixels, zero for whole pixels, up to [`DISPLACED_VARIANCE_PX2`].
fn interpolation_variance(shift_px: f64) -> f64 {
    let part = (shift_px - shift_px.round()).abs();
    (part * (1.0 - part)).min(DISPLACED_VARIANCE_PX2)
}

/// Evaluates a scene's lens at points of its plate.
pub(crate) struct Sources<'a> {
    scene: &'a Scene<'a>,
    frame: Frame,
    channel_count: usize,
}

impl<'a> Sources<'a> {
    pub(crate) fn new(scene: &'a Scene<'a>) -> Self {
        Self {
            scene,
            frame: scene.lens.frame(),
            channel_count: scene.lens.channel_count(),
        }
    }

    /// Writes the sources of the `wanted` channels at plate point `at` to `out`; `at` is in px from the plate's outer
    /// corner.
    ///
    /// # Errors
    /// A blur or displacement that is not finite or too large to draw.
    pub(crate) fn at(
        &self,
        at: (f64, f64),
        vergence: f64,
        wanted: impl Fn(usize) -> bool,
        out: &mut Vec<Option<Source>>,
    ) -> Result<()> {
        out.clear();
        let mean_needed = self.scene.displacement == Displacement::Lateral;
        let mut mean = (0.0, 0.0);
        for channel in 0..self.channel_count {
            if !mean_needed && !wanted(channel) {
                out.push(None);
                continue;
            }
            let blur = self.blur_at(channel, at, vergence)?;
            mean.0 += blur.displacement_px.0 / self.channel_count as f64;
            mean.1 += blur.displacement_px.1 / self.channel_count as f64;
            out.push(Some(Source {
                blur: blur.blur,
                shift_px: blur.displacement_px,
            }));
        }
        for (channel, slot) in out.iter_mut().enumerate() {
            if !wanted(channel) {
                *slot = None;
            }
            if let Some(source) = slot {
                self.keep_displacement(source, mean);
            }
        }
        Ok(())
    }

    /// Writes the sources of plate row `row` with light in any of `planes`: columns and kernels for each channel.
    ///
    /// # Errors
    /// Those of [`Sources::at`].
    pub(crate) fn of_row(
        &self,
        planes: &[Plane],
        row: usize,
        sources: &mut [Vec<(usize, Source)>],
    ) -> Result<()> {
        sources.iter_mut().for_each(Vec::clear);
        let width = self.scene.width;
        let mut found = Vec::new();
        for column in 0..width {
            let index = row * width + column;
            let has_light = |channel: usize| {
                let mut planes = planes.iter();
                planes.any(|plane| plane.weights[channel] != 0.0 && plane.samples[index] != 0.0)
            };
            if !(0..sources.len()).any(has_light) {
                continue;
            }
            let at = (column as f64 + 0.5, row as f64 + 0.5);
            let vergence = self.scene.vergence_at(index);
            self.at(at, vergence, has_light, &mut found)?;
            for (found, sources) in found.iter_mut().zip(&mut *sources) {
                sources.extend(found.take().map(|source| (column, source)));
            }
        }
        Ok(())
    }

    /// Reduces the displacement to what the scene keeps of it, and widens displaced kernels.
    fn keep_displacement(&self, source: &mut Source, mean: (f64, f64)) {
        let (x, y) = source.shift_px;
        source.shift_px = match self.scene.displacement {
            Displacement::None => (0.0, 0.0),
            Displacement::Lateral => (x - mean.0, y - mean.1),
            Displacement::Full => (x, y),
        };
        let (x, y) = source.shift_px;
        let variance = interpolation_variance(x).max(interpolation_variance(y));
        if variance > 0.0 {
            source.blur = source.blur.with_least_variance(variance);
        }
    }

    /// Returns the blur and displacement of one channel at a plate point, plate px.
    fn blur_at(&self, channel: usize, at: (f64, f64), vergence: f64) -> Result<DisplacedBlur> {
        let (x, y) = at;
        let map = self.scene.map;
        let scale = map.scale;
        let at = self.frame.field_point(ImagePoint::new(
            map.origin.x_px + x / scale,
            map.origin.y_px + y / scale,
        ));
        let DisplacedBlur {
            blur,
            displacement_px,
        } = self.scene.lens.blur_at(channel, at, vergence);
        let displaced = DisplacedBlur {
            blur: blur.rescaled(scale),
            displacement_px: (displacement_px.0 * scale, displacement_px.1 * scale),
        };
        let moments = displaced.blur.moments;
        let small = |moment: f64| moment.abs() <= LARGEST_SIGMA_PX * LARGEST_SIGMA_PX;
        let drawable = [moments.mu20, moments.mu11, moments.mu02]
            .into_iter()
            .all(small)
            && moments.to_array().iter().all(|moment| moment.is_finite());
        let near = |shift: f64| shift.abs() <= LARGEST_DISPLACEMENT_PX;
        if drawable && near(displaced.displacement_px.0) && near(displaced.displacement_px.1) {
            return Ok(displaced);
        }
        Err(Error::new(
            format!(
                "lens channel {channel} at plate pixel ({}, {})",
                x.floor(),
                y.floor()
            ),
            format!(
                "needs a blur of {:.0} px in standard deviation and a displacement of ({:.0}, {:.0}) px, too large to draw",
                moments.mu20.max(moments.mu02).sqrt(),
                displaced.displacement_px.0,
                displaced.displacement_px.1
            ),
            format!(
                "check the lens, and the depth, which is {} there; blurs are drawn up to a standard \
                 deviation of {LARGEST_SIGMA_PX} px, displacements up to {LARGEST_DISPLACEMENT_PX} px",
                distance_span(1.0 / vergence, 1.0 / vergence)
            ),
        ))
    }
}

/// Cuts a row of one channel's sources into runs that share the kernel of their middle source.
///
/// The kernels of a run are equal, or differ by less than can be seen ([`PsfModel::can_share_kernel`]).
pub(crate) fn runs<'a>(
    model: &'a dyn PsfModel,
    mut rest: &'a [(usize, Source)],
) -> impl Iterator<Item = (&'a [(usize, Source)], &'a Source)> {
    std::iter::from_fn(move || {
        let (_, first) = rest.first()?;
        let alike = |(_, source): &&(usize, Source)| {
            model.can_share_kernel(&first.blur, first.shift_px, &source.blur, source.shift_px)
        };
        let count = 1 + rest[1..].iter().take_while(alike).count();
        let (run, others) = rest.split_at(count);
        rest = others;
        Some((run, &run[count / 2].1))
    })
}
