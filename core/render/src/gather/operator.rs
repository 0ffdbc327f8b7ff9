//! The fast renderer as a linear operator with its adjoint.

use super::gather_pass::GatherPass;
use super::image::View;
use super::lens_probe::LensProbe;
use super::plan::LitBlocks;
use super::{ChannelMixes, Job, Quality};
use crate::scatter::Sources;
use crate::{Plane, RenderWindow, Scene, VergencePass};
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

/// The linear operator A that blurs planes of one plate; [`Operator::adjoint`] is A^T.
///
/// Its stencils are computed once and applied to any light. It is the fast renderer without the parts that depend on
/// the light: highlights are not scattered exactly, and small plates are not rendered exactly. The result is the same
/// to the bit for any number of threads.
pub struct Operator {
    pass: GatherPass,
}

impl Operator {
    /// Prepares the operator of `scene`, at one vergence, for planes with these channel `weights`.
    ///
    /// # Errors
    /// An invalid scene or weights, a lens that cannot be drawn, and a vergence that varies.
    pub fn new(scene: &Scene, weights: &[Vec<f64>], quality: Quality) -> Result<Self> {
        let lit = vec![1.0; scene.pixel_count()];
        let planes: Vec<Plane> = weights
            .iter()
            .map(|weights| Plane {
                samples: &lit,
                weights,
            })
            .collect();
        scene.check(&planes)?;
        let VergencePass::Constant(vergence) = scene.vergence else {
            return Err(Error::new(
                "vergence",
                "varies over the plate",
                "make an operator for each of its layers",
            ));
        };
        let sources = Sources::new(scene);
        let mixes = ChannelMixes::new(weights.iter().map(Vec::as_slice));
        let job = Job {
            scene,
            lens: LensProbe {
                sources: &sources,
                model: scene.model,
                vergence,
                mixes: &mixes.weights,
                tolerance: &quality.tolerance(),
                kernels: None,
                progress: &|_| true,
            },
            mix_of: mixes.mix_of.clone(),
            window: RenderWindow::whole(scene),
            progress: &|_| true,
        };
        let sides = job.lens.probed_sides(job.size())?;
        let sides = sides.in_window(RenderWindow::whole(scene));
        Ok(Self {
            pass: job.pass(&LitBlocks::all(job.size()), &sides)?,
        })
    }

    /// Returns the number of samples of a plane.
    pub fn pixel_count(&self) -> usize {
        self.pass.size.width * self.pass.size.height
    }

    /// Applies A: blurs `planes`, one for each of the channel weights, [`Operator::pixel_count`] samples each,
    /// row-major.
    ///
    /// # Errors
    /// The wrong number or size of planes.
    pub fn apply(&self, planes: &[Vec<f32>]) -> Result<Vec<Vec<f32>>> {
        self.check(planes)?;
        let size = self.pass.size;
        let views: Vec<_> = planes
            .iter()
            .map(|plane| View::whole(size, plane))
            .collect();
        let window = RenderWindow::from_size(size.width, size.height);
        self.pass.forward(&views, window, &|_| true)
    }

    /// Applies A^T: spreads the light of blurred planes back over the sources that contribute to it.
    ///
    /// # Errors
    /// The wrong number or size of planes.
    pub fn adjoint(&self, planes: &[Vec<f32>]) -> Result<Vec<Vec<f32>>> {
        self.check(planes)?;
        let planes = planes.par_iter().enumerate();
        Ok(planes
            .map(|(index, plane)| self.pass.adjoint(plane, index))
            .collect())
    }

    fn check(&self, planes: &[Vec<f32>]) -> Result<()> {
        let (count, size) = (self.pass.mix_of.len(), self.pixel_count());
        if planes.len() == count && planes.iter().all(|plane| plane.len() == size) {
            return Ok(());
        }
        Err(Error::new(
            "planes",
            format!(
                "are {} of {:?} samples",
                planes.len(),
                planes.iter().map(Vec::len).collect::<Vec<_>>()
            ),
            format!("give {count} of {size} samples each"),
        ))
    }
}
