//! The depth of a plate, and of a holdout, as vergences.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_render::{AveragedDepth, AveragedQuantity, DepthConvention, DepthReading, VergencePass};

use crate::margins::Margins;
use crate::plate::{Depth, DepthPass, HoldoutMatte, PlateGeometry};
use crate::session::LensSession;

/// Radius of the disc over which a distance is picked, plate pixels: wider than noise and gaps of hair, and narrower than a
/// face in a wide shot.
const PICK_RADIUS_PX: usize = 3;

/// The depth of a plate as vergences, 1/m.
#[derive(Debug, Clone)]
pub struct PreparedDepth {
    source: Depth,
    vergence: PlateVergence,
    /// Pixels of the pass that were averages, where the plate's meaning asks to divide them.
    averaged: Option<AveragedDepth>,
}

#[derive(Debug, Clone)]
enum PlateVergence {
    Constant(f64),
    PerPixel(DepthReading),
}

impl PreparedDepth {
    /// Reads the `depth` of a plate of `geometry` for the lens of `session`.
    ///
    /// # Errors
    /// A depth pass where the lens was measured at one distance, an unknown distance where its blur depends on it, and
    /// samples that are not depths, by pixel.
    pub fn new(session: &LensSession, geometry: &PlateGeometry, depth: Depth) -> Result<Self> {
        let mut averaged = None;
        let vergence = match &depth {
            Depth::Distance(distance) => {
                PlateVergence::Constant(session.predictor().vergence(*distance)?)
            }
            Depth::Pass(_) if !session.predictor().depends_on_depth() => {
                return Err(Error::new(
                    "depth",
                    "is a pass, but the lens was fitted at one object distance and cannot follow it",
                    "fit the lens to sets at three or more distances, or give no depth",
                )
                .with_kind(ErrorKind::Unsupported));
            }
            Depth::Pass(pass) => {
                let mut reading = read(session, geometry, pass)?;
                averaged = repair_averages(&mut reading, session.place(geometry)?.width, pass)?;
                PlateVergence::PerPixel(reading)
            }
        };
        Ok(Self {
            source: depth,
            vergence,
            averaged,
        })
    }

    /// Vergences and statistics of the depth pass, where there is one.
    pub fn reading(&self) -> Option<&DepthReading> {
        match &self.vergence {
            PlateVergence::Constant(_) => None,
            PlateVergence::PerPixel(reading) => Some(reading),
        }
    }

    /// The depth pass, where there is one.
    pub fn pass(&self) -> Option<&DepthPass> {
        match &self.source {
            Depth::Pass(pass) => Some(pass),
            Depth::Distance(_) => None,
        }
    }

    /// Returns the object distance at a pixel: the median over a small disc around it, so that noise and fine gaps do not count. The
    /// plate is `width` columns wide and holds the pixel.
    pub fn distance_at(&self, column: usize, row: usize, width: usize) -> ObjectDistance {
        let PlateVergence::PerPixel(reading) = &self.vergence else {
            return match self.source {
                Depth::Distance(distance) => distance,
                Depth::Pass(_) => ObjectDistance::Unknown,
            };
        };
        let height = reading.vergence.len() / width.max(1);
        let around = |at: usize, count: usize| {
            at.saturating_sub(PICK_RADIUS_PX)..(at + PICK_RADIUS_PX + 1).min(count)
        };
        let mut picked = Vec::new();
        for y in around(row, height) {
            let is_in_disc = |x: &usize| {
                x.abs_diff(column).pow(2) + y.abs_diff(row).pow(2) <= PICK_RADIUS_PX.pow(2)
            };
            let columns = around(column, width).filter(is_in_disc);
            picked.extend(columns.map(|x| reading.vergence[y * width + x]));
        }
        picked.sort_by(f32::total_cmp);
        let median = picked.get(picked.len() / 2).copied().map_or(0.0, f64::from);
        ObjectDistance::metres(1.0 / median).unwrap_or(ObjectDistance::Infinity)
    }

    /// Returns the depth of a plate `width` columns wide with `margins` about it, which have the depth of the nearest pixel.
    pub(crate) fn padded(&self, margins: Margins, width: usize) -> Self {
        let vergence = match &self.vergence {
            PlateVergence::Constant(vergence) => PlateVergence::Constant(*vergence),
            PlateVergence::PerPixel(reading) => PlateVergence::PerPixel(DepthReading {
                vergence: margins.padded(&reading.vergence, width, |v| v),
                ..*reading
            }),
        };
        let source = match &self.source {
            Depth::Distance(distance) => Depth::Distance(*distance),
            Depth::Pass(pass) => Depth::Pass(DepthPass {
                samples: margins.padded(&pass.samples, width, |v| v),
                meaning: pass.meaning,
            }),
        };
        Self {
            source,
            vergence,
            averaged: (self.averaged.as_ref()).map(|averaged| averaged.padded(margins.sides())),
        }
    }

    /// The pixels that were averages of two sides, where they were divided.
    pub(crate) fn averaged(&self) -> Option<&AveragedDepth> {
        self.averaged.as_ref()
    }

    pub(crate) fn source(&self) -> &Depth {
        &self.source
    }

    pub(crate) fn vergence(&self) -> VergencePass<'_> {
        match &self.vergence {
            PlateVergence::Constant(vergence) => VergencePass::Constant(*vergence),
            PlateVergence::PerPixel(reading) => VergencePass::PerPixel(&reading.vergence),
        }
    }
}

/// A holdout matte, and the vergence of the object that it cuts out.
#[derive(Debug, Clone)]
pub struct PreparedHoldout {
    matte: Vec<f32>,
    vergence: Option<Vec<f32>>,
}

impl PreparedHoldout {
    /// Reads the `matte` of a plate of `geometry` for the lens of `session`.
    ///
    /// # Errors
    /// Those of [`HoldoutMatte::check`], and depth samples that are not depths, by pixel.
    pub fn new(
        session: &LensSession,
        geometry: &PlateGeometry,
        matte: HoldoutMatte,
    ) -> Result<Self> {
        matte.check(geometry.data.width)?;
        let reading = (matte.depth.as_ref()).map(|pass| read(session, geometry, pass));
        let reading = reading.transpose().map_err(|e| e.within("depth"))?;
        Ok(Self {
            matte: matte.samples,
            vergence: reading.map(|reading| reading.vergence),
        })
    }

    /// Returns the holdout of a plate `width` columns wide with `margins` about it, which repeat the nearest pixel.
    pub(crate) fn padded(&self, margins: Margins, width: usize) -> Self {
        let padded = |samples: &Vec<f32>| margins.padded(samples, width, |v| v);
        Self {
            matte: padded(&self.matte),
            vergence: self.vergence.as_ref().map(padded),
        }
    }

    pub(crate) fn matte(&self) -> &[f32] {
        &self.matte
    }

    pub(crate) fn vergence(&self) -> Option<VergencePass<'_>> {
        self.vergence.as_deref().map(VergencePass::PerPixel)
    }
}

fn read(session: &LensSession, geometry: &PlateGeometry, pass: &DepthPass) -> Result<DepthReading> {
    let placement = session.place(geometry)?;
    let axis = session.axis(&placement);
    pass.read(placement.width, axis, placement.pixel_aspect)
}

/// Longest edge that may be an average, px: longer ones would be other surfaces.
const MOST_AVERAGED_PX: f64 = 256.0;

/// Gives the pixels of `pass` that are averages of two sides the vergence of one of them, where its meaning asks for that.
fn repair_averages(
    reading: &mut DepthReading,
    width: usize,
    pass: &DepthPass,
) -> Result<Option<AveragedDepth>> {
    let most_px = pass.meaning.averaged_px;
    if !(0.0..=MOST_AVERAGED_PX).contains(&most_px) {
        return Err(Error::new(
            "width of averaged depth",
            format!("is {most_px} px"),
            format!("give 0 to {MOST_AVERAGED_PX} px"),
        ));
    }
    let quantity = match pass.meaning.convention {
        DepthConvention::Inverse { .. } => AveragedQuantity::Vergence,
        _ => AveragedQuantity::Distance,
    };
    let repair = || AveragedDepth::repair(&mut reading.vergence, width, most_px, quantity);
    Ok((most_px > 0.0).then(repair).flatten())
}
