//! The fast renderer as a linear operator, made once and laid over light as often as needed, and its adjoint.

use super::optics::Optics;
use super::pass::Pass;
use super::plan::Lit;
use super::{Job, Quality, mixes};
use crate::scatter::Sources;
use crate::{Plane, RenderWindow, Scene, VergencePass};
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

/// What a lens does to planes of light on one plate: A, of which [`Operator::adjoint`] is A^T.
///
/// It is the fast renderer without what depends on the light: small lights are not scattered apart, and no
/// plate is rendered exactly for being too small. The same to the bit for any number of threads.
pub struct Operator {
    pass: Pass,
}

impl Operator {
    /// The operator of `scene`, at one vergence, for planes with these channel `weights`.
    ///
    /// # Errors
    /// A scene or weights that cannot be, a lens that cannot be drawn, and a vergence that varies.
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
        let (mixes, mix_of) = mixes(&planes);
        let tolerance = quality.tolerance();
        let job = Job {
            scene,
            optics: Optics {
                sources: &sources,
                model: scene.model,
                vergence,
                mixes: &mixes,
                tolerance: &tolerance,
                progress: &|_| true,
            },
            mix_of,
            window: RenderWindow::whole(scene),
            progress: &|_| true,
        };
        let sides = job.optics.sides((scene.width, scene.height))?;
        let lit = Lit::all_of((scene.width, scene.height));
        Ok(Self {
            pass: job.pass(&lit, &sides)?,
        })
    }

    /// Samples of a plane.
    pub fn pixel_count(&self) -> usize {
        self.pass.size.0 * self.pass.size.1
    }

    /// A: the planes blurred; one a weight given, each of [`Operator::pixel_count`] samples, row-major.
    ///
    /// # Errors
    /// Planes of another number or size.
    pub fn apply(&self, planes: &[Vec<f32>]) -> Result<Vec<Vec<f32>>> {
        self.check(planes)?;
        let views: Vec<_> = planes.iter().map(|plane| self.pass.view(plane)).collect();
        let window = RenderWindow::from_size(self.pass.size.0, self.pass.size.1);
        self.pass.forward(&views, window, &|_| true)
    }

    /// A^T: the light of blurred planes taken back to the sources that it could have come from.
    ///
    /// # Errors
    /// Planes of another number or size.
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
