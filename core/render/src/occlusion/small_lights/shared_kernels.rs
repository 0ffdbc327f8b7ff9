//! The kernels of small lights. Neighbours at nearly one depth share them.

use crate::scatter::{Source, Sources, weighted_sum};
use crate::{LocalKernel, Scene};
use seidel_optics::error::Result;
use std::sync::Arc;

/// A kernel with the sources that it draws, one a lens channel.
struct DrawnKernel<'a> {
    weights: &'a [f64],
    sources: Vec<Option<Source>>,
    kernel: Arc<LocalKernel>,
}

/// The kernels drawn for some neighbouring lights.
pub(super) struct SharedKernels<'a> {
    scene: &'a Scene<'a>,
    sources: Sources<'a>,
    drawn: Vec<DrawnKernel<'a>>,
}

impl<'a> SharedKernels<'a> {
    pub(super) fn new(scene: &'a Scene<'a>) -> Self {
        Self {
            scene,
            sources: Sources::new(scene),
            drawn: Vec::new(),
        }
    }

    /// Returns the kernel of a light at plate point `at` and a vergence, in a plane with these channel `weights`: a known one, if the
    /// light's own differs by less than can be seen ([`seidel_optics::psf::PsfModel::can_share_kernel`]).
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    pub(super) fn at(
        &mut self,
        at: (f64, f64),
        vergence: f64,
        weights: &'a [f64],
    ) -> Result<Arc<LocalKernel>> {
        let mut sources = Vec::new();
        let is_used = |channel: usize| weights[channel] != 0.0;
        self.sources.at(at, vergence, is_used, &mut sources)?;
        // The last one is the most probable.
        let known = self
            .drawn
            .iter()
            .rev()
            .find(|drawn| drawn.weights == weights && self.can_share(&drawn.sources, &sources));
        if let Some(known) = known {
            return Ok(Arc::clone(&known.kernel));
        }
        let kernel = Arc::new(weighted_sum(self.scene, &sources, weights));
        self.drawn.push(DrawnKernel {
            weights,
            sources,
            kernel: Arc::clone(&kernel),
        });
        Ok(kernel)
    }

    fn can_share(&self, drawn: &[Option<Source>], wanted: &[Option<Source>]) -> bool {
        drawn.iter().zip(wanted).all(|pair| match pair {
            (Some(a), Some(b)) => {
                let model = self.scene.model;
                model.can_share_kernel(&a.blur, a.shift_px, &b.blur, b.shift_px)
            }
            (None, None) => true,
            _ => false,
        })
    }
}
