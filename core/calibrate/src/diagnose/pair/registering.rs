//! Registration of the sharp picture to the plate in the frame of the lens.

use std::sync::atomic::{AtomicBool, AtomicUsize};

use super::depth::DepthPlane;
use super::estimate::Plans;
use super::geometry::{self, Movement, Tolerance};
use super::lens_view::{LensView, Positions};
use super::patch::Window;
use super::{Job, PairGeometry, PairImage, PairSettings, placement, windows};
use crate::registration::Similarity;
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Rounds of measuring and moving the sharp picture.
const REGISTRATION_ROUNDS: usize = 3;

/// The registration of a sharp picture to a plate in the frame.
pub(super) struct Registering<'a> {
    /// The lens, as for an undistorted plate.
    pub(super) view: LensView<'a>,
    /// Index of the channel whose offsets are measured.
    pub(super) reference: usize,
    pub(super) settings: &'a PairSettings,
    pub(super) progress: &'a Progress<'a>,
    pub(super) plate: PairImage<'a>,
}

/// A sharp picture moved to ideal positions of the frame.
pub(super) struct RegisteredSharp {
    pub(super) sharp: Vec<Vec<f32>>,
    pub(super) positions: Positions,
    /// From pixels of the picture as given.
    pub(super) transform: Similarity,
    /// The part of it that was measured by windows.
    pub(super) movement: Movement,
}

impl<'a> Registering<'a> {
    pub(super) fn job<'b>(&'b self, sharp: PairImage<'b>, windows: &[Window]) -> Job<'b> {
        Job {
            plans: Plans::new(self.settings.side, windows[0].square()),
            sharp,
            plate: self.plate,
            settings: self.settings,
            progress: self.progress,
            done: AtomicUsize::new(0),
            cancelled: AtomicBool::new(false),
        }
    }

    /// Returns the depth of the scene, moved with `sharp` by `transform`; `None` where it is at one distance.
    pub(super) fn depth(
        &self,
        sharp: &PairImage<'_>,
        transform: &Similarity,
    ) -> Result<Option<DepthPlane>> {
        let LensView {
            channels, frame, ..
        } = &self.view;
        let vergence = self.settings.vergence.as_deref();
        let plane = vergence.map(|v| DepthPlane::new(channels, frame, sharp, v, transform));
        plane.transpose()
    }

    /// Moves `sharp` by `placed` into the frame, and measures what is left until nothing is.
    ///
    /// The sharp picture is resampled, never the plate: light between its pixels is then where a renderer, which blurs pixel by
    /// pixel, would have it. PSFs drawn between the pixels of a picture that is not moved would add the aliases of its texture.
    pub(super) fn register(
        &self,
        sharp: &PairImage<'_>,
        placed: Similarity,
    ) -> Result<RegisteredSharp> {
        let (view, clip) = (&self.view, self.settings.clip);
        let wanted = match self.settings.geometry {
            PairGeometry::Measured => None,
            PairGeometry::Undistorted => Some(Positions::Undistorted),
            PairGeometry::Distorted => Some(Positions::Lens),
        };
        let (mut transform, mut movement) = (placed, Movement::default());
        let mut tolerance = Tolerance::ALIGNED;
        let mut round = 1;
        loop {
            let planes = placement::planes_in_frame(&view.frame, sharp, &transform, clip);
            let image = PairImage {
                planes: &planes,
                ..self.plate
            };
            let depth = self.depth(sharp, &transform)?;
            let (side, most) = (self.settings.side, self.settings.most_patches);
            let windows = windows::choose(&image, side, most, clip, depth.as_ref())?.windows;
            let job = self.job(image, &windows);
            let offsets = job.offsets(view, &windows, self.reference)?;
            let found = geometry::decide(view, &offsets, wanted, tolerance);
            if found.movement.is_none() || round > REGISTRATION_ROUNDS {
                return Ok(RegisteredSharp {
                    sharp: planes,
                    positions: found.positions,
                    transform,
                    movement,
                });
            }
            movement.add(&found.movement);
            transform = found.movement.transform(&view.frame).after(&transform);
            tolerance = Tolerance::MOVED;
            round += 1;
        }
    }
}
