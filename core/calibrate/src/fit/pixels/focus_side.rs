//! The side of focus on which each distance lies, by the data of the camera.
//!
//! Discs on both sides of focus are alike where the other aberrations are small. A fit may then take the wrong side and imitate
//! the difference by other parts. Focal length, f-number and focus distance decide.

use super::context::{FitContext, FittedLens, INITIAL_BLUR_PX2};
use super::defocus_starts;
use super::metric::Metric;
use super::parameters::Quantity;
use super::part_trial::all_misfit;
use crate::fit::initial::InitialEstimate;
use seidel_optics::distance::ObjectDistance;

/// Defocus by the camera's data below which they do not tell the side, px.
const MIN_DEFOCUS_PX: f64 = 2.0;

/// Increase of the mean log misfit up to which the side of the camera's data is taken.
const MAX_LOSS: f64 = 0.1;

/// The defocus of the camera's data, which put some distances on another side of focus than a fit does.
pub(super) struct FocusSide<'a> {
    context: &'a FitContext<'a>,
    camera: InitialEstimate,
    distances: Vec<ObjectDistance>,
}

impl<'a> FocusSide<'a> {
    /// Returns `None` where the camera's data are missing or agree with `fit`.
    pub(super) fn of_camera_if_other(
        context: &'a FitContext<'a>,
        fit: &FittedLens,
    ) -> Option<Self> {
        let camera = defocus_starts::of_camera(&context.sets[0])?;
        if context.vergences.len() < 2 {
            return None;
        }
        let is_other = |v: &f64| {
            let expected = camera.reduced(*v).alpha;
            let found = fit.layout.value(&fit.theta, Quantity::Alpha, 0, *v);
            expected.abs() > MIN_DEFOCUS_PX && found.is_some_and(|found| found * expected < 0.0)
        };
        let other = context.vergences.iter().filter(|v| is_other(v));
        let distance = |v: &f64| {
            let mut measured = context.measured.iter().map(|m| m.distance);
            measured.find(|d| d.vergence_per_m() == Some(*v))
        };
        let distances: Vec<ObjectDistance> = other.filter_map(distance).collect();
        (!distances.is_empty()).then_some(Self {
            context,
            camera,
            distances,
        })
    }

    /// Returns the reduced lens whose defocus is held at that of the camera's data.
    pub(super) fn held(&self) -> FittedLens {
        let context = self.context;
        let mut structure = context.reduced_layout().structure;
        for freedom in &mut structure.polynomials {
            freedom.fixed |= freedom.quantity == Quantity::Alpha;
        }
        let layout = context.layout(structure);
        let mut theta = vec![0.0; layout.parameters.len()];
        layout.set_constant_in_all(&mut theta, Quantity::Blur, INITIAL_BLUR_PX2);
        for channel in 0..context.channel_names().len() {
            layout.set_initial(&mut theta, channel, &self.camera);
        }
        context.refine_between(&layout, theta, Metric::NaturalSpectrum)
    }

    fn places(&self) -> String {
        let distances: Vec<String> = self.distances.iter().map(ToString::to_string).collect();
        distances.join(", ")
    }
}

/// Returns the reduced lens `fit` on the side of focus that the camera's data tell, if it describes the tiles as well there.
pub(super) fn settled(context: &FitContext, fit: FittedLens) -> FittedLens {
    let Some(side) = FocusSide::of_camera_if_other(context, &fit) else {
        return fit;
    };
    let theirs = freed(context, side.held());
    let theirs = context.refine(&theirs.layout, theirs.theta, fit.metric);
    let is_theirs = is_as_good(all_misfit(context, &theirs), all_misfit(context, &fit));
    if is_theirs { theirs } else { fit }
}

/// Returns whether the camera's side, with the mean log misfit `theirs`, is taken rather than that with `ours`.
pub(super) fn is_as_good(theirs: f64, ours: f64) -> bool {
    theirs < ours + MAX_LOSS
}

/// Returns in words whether `fit` follows the camera's data, where it or `by_moments`, the first fit, contradicts them.
pub(super) fn remark(
    context: &FitContext,
    by_moments: &FittedLens,
    fit: &FittedLens,
) -> Option<String> {
    const DATA: &str = "focal length, f-number and focus distance of the set put";
    if let Some(refused) = FocusSide::of_camera_if_other(context, fit) {
        return Some(format!(
            "{DATA} {} on the other side of focus than the lens does, which describes the PSFs better. Check these three fields of the manifest",
            refused.places()
        ));
    }
    let taken = FocusSide::of_camera_if_other(context, by_moments)?;
    Some(format!(
        "{DATA} {} on the other side of focus than moments alone do. That side was taken: the lens describes the PSFs as well there, or better",
        taken.places()
    ))
}

/// Returns `fit` with its defocus free again.
pub(super) fn freed(context: &FitContext, fit: FittedLens) -> FittedLens {
    let mut structure = fit.layout.structure.clone();
    for freedom in &mut structure.polynomials {
        freedom.fixed &= freedom.quantity != Quantity::Alpha;
    }
    let layout = context.layout(structure);
    let theta = layout.transfer(&fit.layout, &fit.theta);
    context.refine_between(&layout, theta, fit.metric)
}
