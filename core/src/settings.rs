//! The settings of [`apply`](crate::apply), [`remove`](crate::remove) and [`relens`](crate::relens).

use seidel_optics::profile::{Controls, Look};
use seidel_render::remove::Saturation;
use seidel_render::{Bloom, Displacement, FocusControls, Gather, KernelStore, Renderer, Scatter};

use crate::plate::LensScale;

/// Settings of the lens and of a render. The defaults use the lens as measured.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Focus distance, f-number and sensor shift; as measured where left out.
    pub controls: Controls,
    /// Controls of the lens that a plate was taken with, where they differ from `controls`, in
    /// [`relens`](crate::relens()).
    pub from_controls: Controls,
    /// Controls of the lens whose blur the plate gets, where they differ from `controls`, in
    /// [`relens`](crate::relens()).
    pub to_controls: Controls,
    /// Artistic changes of the lens as `controls` set it: that of [`apply`](crate::apply), and the new one of
    /// [`relens`](crate::relens).
    pub look: Look,
    /// Weight of the blurred plate against its own pixels, 0 to 1, in [`apply`](crate::apply); times that of
    /// [`Plate::mask`](crate::Plate::mask).
    pub mix: f64,
    /// The quantity that [`Plate::mask`](crate::Plate::mask) scales.
    pub mask_scales: MaskScales,
    /// Whether [`apply`](crate::apply) renders the colour error of the lens alone, without the blur that its channels share; see
    /// [`ChromaticLens`](seidel_render::ChromaticLens).
    pub only_chroma: bool,
    /// Light above a level that spreads before it meets the lens, in [`apply`](crate::apply) and [`relens`](crate::relens).
    pub bloom: Option<Bloom>,
    /// Identifier of the PSF model, such as `pupil`; the most faithful one for the lens if `None`.
    pub psf_model: Option<String>,
    /// Strength of blur and displacement, 0 (none) to 16; 1 is as measured.
    pub amount: f64,
    /// Strength of the blur of single channels, on top of `amount`; the last entry of a channel counts.
    pub channel_scales: Vec<ChannelScale>,
    /// Offset of the optical axis, plate pixels right and down.
    pub axis_offset_px: (f64, f64),
    /// Scale of the lens's frame on the plate, for callers that place plates by it.
    pub lens_scale: LensScale,
    /// Displacement that is rendered: none, lateral colour, or lateral colour and distortion.
    pub displacement: Displacement,
    /// Range in focus, growth of blur before and behind it, and the largest kernel. The focus distance of `controls`,
    /// where there is one, replaces its focus plane.
    pub focus: FocusControls,
    /// Accuracy against the exact renderer.
    pub quality: Quality,
    /// Light beyond the edges of the plate; `None` chooses by the alpha along the plate's border, see [`Edges::of_plate`].
    pub edges: Option<Edges>,
    /// Sides on which the plate is expanded by [`PreparedPlate::expanded`](crate::PreparedPlate::expanded).
    pub expand: Expand,
    /// Occlusion of far surfaces by near ones where depth varies. `None` adds the light of all depths, and keeps its sum.
    pub occlusion: Option<OcclusionSettings>,
    /// Noise and clipping of the plate, strength and grain, for [`remove`](crate::remove) and [`relens`](crate::relens).
    pub removal: RemovalSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            controls: Controls::default(),
            from_controls: Controls::default(),
            to_controls: Controls::default(),
            look: Look::default(),
            mix: 1.0,
            mask_scales: MaskScales::Mix,
            only_chroma: false,
            bloom: None,
            psf_model: None,
            amount: 1.0,
            channel_scales: Vec::new(),
            axis_offset_px: (0.0, 0.0),
            lens_scale: LensScale::default(),
            displacement: Displacement::Lateral,
            focus: FocusControls::default(),
            quality: Quality::Final,
            edges: None,
            expand: Expand::Auto,
            occlusion: Some(OcclusionSettings::default()),
            removal: RemovalSettings::default(),
        }
    }
}

impl Settings {
    /// Returns the settings for the lens that a plate was taken with: without look and bloom.
    pub fn of_measured_lens(&self) -> Self {
        Self {
            look: Look::default(),
            only_chroma: false,
            bloom: None,
            ..self.clone()
        }
    }

    /// Returns the settings for one lens of [`relens`](crate::relens()), with the controls of its side.
    pub fn of_side(&self, side: RelensSide) -> Self {
        let (own, settings) = match side {
            RelensSide::From => (self.from_controls, self.of_measured_lens()),
            RelensSide::To => (self.to_controls, self.clone()),
        };
        Self {
            controls: own.or(self.controls),
            // Sessions of equal lenses are equal, whichever side they are of.
            from_controls: Controls::default(),
            to_controls: Controls::default(),
            only_chroma: false,
            ..settings
        }
    }
}

/// A lens of [`relens`](crate::relens()).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RelensSide {
    /// The lens that the plate was taken with.
    From,
    /// The lens whose blur the plate gets.
    To,
}

/// The quantity that a mask scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MaskScales {
    /// The weight of the blurred plate against its own pixels.
    #[default]
    Mix,
    /// The distance of each pixel from the range in focus, in 1/m, before it is rendered: 0 is as sharp as the focus plane.
    Blur,
}

/// Strength of the blur of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelScale {
    /// Name of the lens channel, such as `R`.
    pub channel: String,
    /// Factor above 0 and up to 16; 1 is as measured.
    pub scale: f64,
}

/// Accuracy of a render, as peak signal-to-noise ratio against the exact renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// 45 dB: for previews.
    Draft,
    /// 60 dB; 75 dB where no blur is above 6 px, 50 dB for lenses drawn ray by ray: for delivery.
    #[default]
    Final,
    /// Every source pixel scattered with its own kernel: slow.
    Exact,
}

impl Quality {
    /// Returns the renderer of this quality, without occlusion, which uses the `kernels` of earlier renders.
    pub(crate) fn renderer(self, kernels: &KernelStore) -> Box<dyn Renderer + '_> {
        let gather = |quality| {
            Box::new(Gather {
                quality,
                kernels: Some(kernels),
            })
        };
        match self {
            Self::Draft => gather(seidel_render::Quality::Draft),
            Self::Final => gather(seidel_render::Quality::Final),
            Self::Exact => Box::new(Scatter),
        }
    }
}

/// Least alpha of an opaque pixel: 1, with room for half floats and filters of a renderer.
const OPAQUE: f32 = 0.999;

/// Light beyond the edges of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// The mirrored plate: no light is lost.
    Mirror,
    /// Black: light that leaves the plate is lost.
    Black,
    /// The nearest pixel of the plate, with its depth and blur.
    Extend,
}

impl Edges {
    /// Returns the edges for a plate whose `alpha` is a plane of `width` columns: those of a full frame where there is no
    /// alpha or the border is opaque, black where the border is transparent, and the nearest pixel where an element is cut by
    /// the border.
    pub fn of_plate(alpha: Option<&[f32]>, width: usize) -> Self {
        let Some(alpha) = alpha.filter(|alpha| !alpha.is_empty()) else {
            return Self::Mirror;
        };
        let last_row = alpha.len() - width;
        let columns = [0, width - 1].into_iter();
        let columns = columns.flat_map(|first| alpha[first..].iter().step_by(width));
        let border = (alpha[..width].iter())
            .chain(&alpha[last_row..])
            .chain(columns);
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for sample in border {
            (least, most) = (least.min(*sample), most.max(*sample));
        }
        if least >= OPAQUE {
            Self::Mirror
        } else if most <= 0.0 {
            Self::Black
        } else {
            Self::Extend
        }
    }

    /// The edges that the inner renderer uses; [`Edges::Extend`] pads the plate before it.
    pub(crate) fn of_renderer(self) -> seidel_render::Edges {
        match self {
            Self::Mirror => seidel_render::Edges::Mirror,
            Self::Black | Self::Extend => seidel_render::Edges::Black,
        }
    }
}

/// Expansion of a plate by the reach of the blur, so that light that leaves the plate is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Expand {
    /// Sides where the plate is transparent; see
    /// [`PreparedPlate::expansion`](crate::PreparedPlate::expansion).
    #[default]
    Auto,
    /// All sides.
    Always,
    /// No side.
    Never,
}

/// Occlusion of far surfaces by near ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OcclusionSettings {
    /// Whether background that a blurred foreground uncovers is filled from the background beside it, rather than from
    /// the foreground's own light.
    pub fill_foreground: bool,
    /// Whether a blurred foreground becomes transparent inside its own outline, rather than blurring outwards only.
    pub blur_inside: bool,
}

impl Default for OcclusionSettings {
    fn default() -> Self {
        Self {
            fill_foreground: true,
            blur_inside: true,
        }
    }
}

/// Settings of a removal: noise and clipping of the plate, strength and grain of the sharp image.
#[derive(Debug, Clone, PartialEq)]
pub struct RemovalSettings {
    /// Standard deviation of the noise in scene-linear values: one for all colours or one for each; estimated from the
    /// plate if empty.
    pub noise: Vec<f64>,
    /// Level at which samples are clipped.
    pub saturation: Saturation,
    /// Weight of the sharp image against the plate, 0 to 1.
    pub strength: f64,
    /// Grain of the sharp image.
    pub grain: Grain,
}

impl Default for RemovalSettings {
    fn default() -> Self {
        Self {
            noise: Vec::new(),
            saturation: Saturation::default(),
            strength: 1.0,
            grain: Grain::Keep,
        }
    }
}

/// Grain of an image whose blur was removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Grain {
    /// The plate's own grain is added to the solution.
    #[default]
    Keep,
    /// The solution as it is, nearly without grain.
    Solved,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_chosen_by_the_alpha_of_the_border() {
        let mut alpha = vec![1.0; 4 * 3];
        assert_eq!(Edges::of_plate(None, 4), Edges::Mirror);
        assert_eq!(Edges::of_plate(Some(&alpha), 4), Edges::Mirror);
        alpha[5] = 0.0;
        assert_eq!(Edges::of_plate(Some(&alpha), 4), Edges::Mirror);
        for index in [0, 3, 4, 7, 11] {
            let mut cut = alpha.clone();
            cut[index] = 0.5;
            assert_eq!(Edges::of_plate(Some(&cut), 4), Edges::Extend, "{index}");
        }
        let mut element = vec![0.0; 4 * 3];
        element[6] = 1.0;
        assert_eq!(Edges::of_plate(Some(&element), 4), Edges::Black);
    }
}
