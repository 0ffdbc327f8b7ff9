//! A plate prepared for rendering through a lens.

use std::sync::Arc;

use seidel_optics::error::{Error, Result};
use seidel_render::{
    Background, ChromaticLens, ClampedLens, DividedLight, Holdout, Occlusion, Plane, RenderWindow,
    Scene, VergencePass,
};

use crate::channel_weights::channel_weights;
use crate::image::Image;
use crate::light_scale::LightScale;
use crate::margins::Margins;
use crate::placement::PlatePlacement;
use crate::planes::PremultipliedPlanes;
use crate::plate::{HoldoutMatte, LensScale, Plate, PlateGeometry};
use crate::prepared_background::PreparedBackground;
use crate::prepared_depth::{PreparedDepth, PreparedHoldout};
use crate::prepared_mask::{MixWeights, PreparedMask};
use crate::rendering::Rendering;
use crate::session::{FocusedVergence, LensSession, PlateOptics, refocus};
use crate::settings::Edges;
use seidel_optics::Progress;

/// Diagonal of a picture over that of the frame of the lens that needs no warning: room for other aspect ratios.
const MOST_DIAGONAL_SHARE: f64 = 1.05;

/// A plate prepared for rendering through a lens: premultiplied planes, channel weights and vergences.
///
/// Made by [`LensSession::prepare`]. The free functions [`apply`](crate::apply), [`remove`](crate::remove) and
/// [`relens`](crate::relens) do the same in one call; this type serves callers that render windows of a plate, several
/// frames through one lens, or need the planes in between.
pub struct PreparedPlate {
    session: Arc<LensSession>,
    geometry: PlateGeometry,
    placement: PlatePlacement,
    planes: PremultipliedPlanes,
    weights: Vec<Vec<f64>>,
    depth: PreparedDepth,
    holdout: Option<PreparedHoldout>,
    mask: Option<PreparedMask>,
    background: Option<PreparedBackground>,
    /// The pixels of the plate before it was expanded; the lens beyond them is that of the nearest one.
    own: Option<RenderWindow>,
}

impl LensSession {
    /// Prepares `plate` for rendering: premultiplied planes, channel weights, vergences.
    ///
    /// # Errors
    /// Planes of wrong size or with samples that are not finite, a colour for which the lens has no channel, a depth pass
    /// where the lens was measured at one distance, and a depth pass or matte that cannot be read.
    pub fn prepare(self: &Arc<Self>, plate: Plate) -> Result<PreparedPlate> {
        let geometry = plate.geometry;
        let depth = PreparedDepth::new(self, &geometry, plate.depth)?;
        let holdout = (plate.holdout).map(|matte| PreparedHoldout::new(self, &geometry, matte));
        let holdout = holdout.transpose().map_err(|e| e.within("holdout"))?;
        let mut prepared = self.prepare_parts(plate.image, geometry, depth, holdout)?;
        if let Some(mask) = plate.mask {
            prepared.set_mask(mask)?;
        }
        if let Some(background) = plate.background {
            let background = PreparedBackground::new(self, &geometry, background);
            prepared.set_background(background.map_err(|e| e.within("background"))?)?;
        }
        Ok(prepared)
    }

    /// As [`LensSession::prepare`], of parts whose depth and holdout were prepared before.
    ///
    /// # Errors
    /// Planes of wrong size or with samples that are not finite, and a colour for which the lens has no channel.
    pub fn prepare_parts(
        self: &Arc<Self>,
        image: Image,
        geometry: PlateGeometry,
        depth: PreparedDepth,
        holdout: Option<PreparedHoldout>,
    ) -> Result<PreparedPlate> {
        let placement = self.place(&geometry)?;
        if (image.width(), image.height()) != (placement.width, placement.height) {
            return Err(Error::new(
                "image",
                format!("is {} x {}", image.width(), image.height()),
                format!(
                    "give one of the size of the data window, {} x {}",
                    placement.width, placement.height
                ),
            ));
        }
        let planes = PremultipliedPlanes::new(image)?;
        Ok(PreparedPlate {
            weights: channel_weights(planes.layout(), self.predictor())?,
            session: Arc::clone(self),
            geometry,
            placement,
            planes,
            depth,
            holdout,
            mask: None,
            background: None,
            own: None,
        })
    }
}

impl PreparedPlate {
    /// The lens and its settings.
    pub fn session(&self) -> &Arc<LensSession> {
        &self.session
    }

    /// Data and display windows of the plate.
    pub fn geometry(&self) -> &PlateGeometry {
        &self.geometry
    }

    /// The place of the plate in the frame of the lens.
    pub fn placement(&self) -> &PlatePlacement {
        &self.placement
    }

    /// Returns the most bytes that rendering needs beside the plate, see [`apply_bytes`](crate::apply_bytes).
    pub fn apply_bytes(&self) -> u64 {
        let varies = matches!(self.vergence(), VergencePass::PerPixel(_));
        let occlusion = varies && self.session.settings().occlusion.is_some();
        let pixels = self.placement.width as u64 * self.placement.height as u64;
        let bytes = if occlusion {
            crate::layered_apply_bytes
        } else {
            crate::apply_bytes
        };
        bytes(pixels, self.planes().len() as u64)
    }

    /// The premultiplied planes, named as [`Self::names`]: colours, then alpha, then the alphas of single colours.
    pub fn planes(&self) -> &[Vec<f32>] {
        self.planes.planes()
    }

    /// The names of the planes: R, G, B or Y, then A, then alpha.R and so on.
    pub fn names(&self) -> Vec<String> {
        self.planes.names()
    }

    /// Number of colour planes, which come first.
    pub fn colour_count(&self) -> usize {
        self.planes.colour_count()
    }

    /// The alpha plane, where there is one.
    pub(crate) fn alpha(&self) -> Option<&[f32]> {
        let has_alpha = self.planes.layout().has_alpha;
        has_alpha.then(|| self.planes.planes()[self.colour_count()].as_slice())
    }

    /// The edges that the plate is rendered with: those of the settings, or of its border.
    pub fn edges(&self) -> Edges {
        let chosen = self.session.settings().edges;
        chosen.unwrap_or_else(|| Edges::of_plate(self.alpha(), self.placement.width))
    }

    /// Largest magnitude of a colour sample.
    pub fn peak(&self) -> f64 {
        self.planes.peak()
    }

    /// The depth of the plate.
    pub fn depth(&self) -> &PreparedDepth {
        &self.depth
    }

    /// The background, where there is one.
    pub(crate) fn background(&self) -> Option<&PreparedBackground> {
        self.background.as_ref()
    }

    /// Replaces the session by another one of the same lens, such as one with a smaller amount.
    pub fn set_session(&mut self, session: Arc<LensSession>) {
        self.session = session;
    }

    /// Adds a holdout matte.
    ///
    /// # Errors
    /// Those of [`PreparedHoldout::new`].
    pub fn set_holdout(&mut self, matte: HoldoutMatte) -> Result<()> {
        let holdout = PreparedHoldout::new(&self.session, &self.geometry, matte)?;
        self.holdout = Some(holdout);
        Ok(())
    }

    /// Adds a mask, which scales what the settings say: [`Settings::mask_scales`](crate::Settings::mask_scales).
    ///
    /// # Errors
    /// A mask of another size, the first sample that is not from 0 to 1, by its pixel, and a mask of the blur of a lens without a
    /// focus.
    pub fn set_mask(&mut self, mask: Vec<f32>) -> Result<()> {
        let mask = PreparedMask::new(&self.session, &self.placement, &self.depth, mask)?;
        self.mask = Some(mask);
        Ok(())
    }

    /// Adds a background.
    ///
    /// # Errors
    /// A background without a colour of the plate.
    pub fn set_background(&mut self, background: PreparedBackground) -> Result<()> {
        let ordered = background.with_layout(self.planes.layout());
        self.background = Some(ordered.map_err(|e| e.within("background"))?);
        Ok(())
    }

    /// Returns the plate with `margins` of transparent black about it, whose depth and lens are those of the nearest pixel.
    /// Its data window grows alike.
    ///
    /// # Errors
    /// Those of [`LensSession::place`].
    pub fn expanded(&self, margins: Margins) -> Result<Self> {
        let geometry = PlateGeometry {
            data: margins.around(self.geometry.data),
            ..self.geometry
        };
        let width = self.placement.width;
        let own = RenderWindow {
            column: margins.left,
            row: margins.top,
            width,
            height: self.placement.height,
        };
        Ok(Self {
            session: Arc::clone(&self.session),
            placement: PlatePlacement {
                extent: self.placement.extent,
                ..self.session.place(&geometry)?
            },
            planes: self.planes.padded(margins),
            weights: self.weights.clone(),
            depth: self.depth.padded(margins, width),
            holdout: (self.holdout.as_ref()).map(|holdout| holdout.padded(margins, width)),
            mask: (self.mask.as_ref()).map(|mask| mask.padded(margins, width)),
            background: (self.background.as_ref())
                .map(|background| background.padded(margins, width)),
            own: Some(own),
            geometry,
        })
    }

    /// Returns premultiplied `planes` of the plate's size as an image in the plate's own relation of colour and alpha.
    ///
    /// # Errors
    /// The first sample that is not finite, by channel and pixel of the plate before it was expanded: the computation overflowed.
    pub fn to_image(&self, planes: Vec<Vec<f32>>) -> Result<Image> {
        self.to_image_of_size(self.placement.width, self.placement.height, planes)
    }

    /// As [`Self::to_image`], of planes of `width` x `height` pixels, centred on the plate.
    ///
    /// # Errors
    /// Those of [`Self::to_image`].
    pub fn to_image_of_size(
        &self,
        width: usize,
        height: usize,
        planes: Vec<Vec<f32>>,
    ) -> Result<Image> {
        let margin = |size: usize, own: usize| (size as i64 - own as i64) / 2;
        let first = [
            -margin(width, self.placement.width),
            -margin(height, self.placement.height),
        ];
        let first = self.before_expansion(first);
        self.planes.to_image(first, width, height, planes)
    }

    /// As [`Self::to_image`], of planes of a `window` of the plate, as [`Self::apply_window`] returns.
    ///
    /// # Errors
    /// Those of [`Self::to_image`].
    pub fn to_image_of_window(&self, window: RenderWindow, planes: Vec<Vec<f32>>) -> Result<Image> {
        let first = self.before_expansion([window.column as i64, window.row as i64]);
        let (width, height) = (window.width, window.height);
        self.planes.to_image(first, width, height, planes)
    }

    /// Returns a pixel of the plate as counted before it was expanded.
    fn before_expansion(&self, [column, row]: [i64; 2]) -> [i64; 2] {
        let (left, above) = self.own.map_or((0, 0), |own| (own.column, own.row));
        [column - left as i64, row - above as i64]
    }

    /// Renders the plate through its lens; returns premultiplied planes as the lens's sensor records them.
    ///
    /// # Errors
    /// A lens that cannot be drawn somewhere on the plate, and cancellation by `progress`.
    pub fn apply(&self, progress: &Progress) -> Result<Vec<Vec<f32>>> {
        if self.session.is_neutral() {
            return Ok(self.planes.planes().to_vec());
        }
        self.apply_with(|rendering| Ok(rendering.render(None, progress)?.planes))
    }

    /// Renders the `window` of the plate alone: to the bit what [`Self::apply`] gives there.
    ///
    /// # Errors
    /// Those of [`Self::apply`], and a window that is empty or not wholly on the plate.
    pub fn apply_window(&self, window: RenderWindow, progress: &Progress) -> Result<Vec<Vec<f32>>> {
        self.apply_part(window, |rendering| {
            Ok(rendering.render(Some(window), progress)?.planes)
        })
    }

    /// As [`Self::apply`], with the light rendered by `render`: to read the statistics of a render, or to measure it
    /// against other renderers.
    ///
    /// # Errors
    /// Focus settings that cannot be followed, and those of `render`.
    pub fn apply_with(
        &self,
        render: impl FnOnce(&Rendering) -> Result<Vec<Vec<f32>>>,
    ) -> Result<Vec<Vec<f32>>> {
        let PlatePlacement { width, height, .. } = self.placement;
        let whole = RenderWindow {
            column: 0,
            row: 0,
            width,
            height,
        };
        self.apply_part(whole, render)
    }

    /// As [`Self::apply_with`], with the light of a `part` of the plate.
    fn apply_part(
        &self,
        part: RenderWindow,
        render: impl FnOnce(&Rendering) -> Result<Vec<Vec<f32>>>,
    ) -> Result<Vec<Vec<f32>>> {
        let bloomed = self.bloomed();
        let planes = bloomed.as_ref().unwrap_or(&self.planes);
        let background = self.background.as_ref();
        let peak = background.map_or(0.0, PreparedBackground::peak);
        let scale = LightScale::for_peak(self.peak().max(peak));
        let reduced = scale.map(|scale| {
            let background = background.map(|background| background.reduced_by(scale));
            (planes.reduced_by(scale), background)
        });
        let light = match &reduced {
            Some((planes, background)) => (planes, background.as_ref()),
            None => (planes, background),
        };
        self.with_rendering(light.0, light.1, |rendering| {
            let mut planes = render(rendering)?;
            if let Some(scale) = scale {
                let colours = planes.iter_mut().take(self.colour_count());
                colours.for_each(|plane| scale.restore(plane));
            }
            if self.averages_light() {
                self.planes.limit_coverage(&mut planes);
            }
            self.develop(&mut planes);
            if let Some(weights) = MixWeights::new(&self.session, self.mask.as_ref()) {
                weights.mix(part, self.placement.width, self.planes(), &mut planes);
            }
            Ok(planes)
        })
    }

    /// Whether surfaces hide each other. Each pixel is then a weighted mean of the light that reaches it, so its alpha is
    /// at most one. Otherwise light is summed, and alpha may exceed one.
    fn averages_light(&self) -> bool {
        let varies = matches!(self.vergence(), VergencePass::PerPixel(_));
        varies && self.session.settings().occlusion.is_some()
    }

    /// Returns the planes with the bloom of the settings; `None` where nothing spreads.
    fn bloomed(&self) -> Option<PremultipliedPlanes> {
        let bloom = self.session.settings().bloom?;
        if bloom.is_neutral() {
            return None;
        }
        let frame_px = self.session.frame_px(&self.placement);
        let mut planes = self.planes.planes().to_vec();
        for plane in planes.iter_mut().take(self.colour_count()) {
            bloom.spread(plane, self.placement.width, frame_px);
        }
        Some(self.planes.with_planes(planes))
    }

    /// Renders one more plane, such as a mask, with the mean of the colours' weights; the sensor's tone is left out.
    ///
    /// # Errors
    /// Those of [`Self::apply`], and a plane of the wrong size.
    pub fn render_mask(&self, samples: &[f32], progress: &Progress) -> Result<Vec<f32>> {
        let weights = self.mean_colour_weights();
        let planes = [Plane {
            samples,
            weights: &weights,
        }];
        // Neither the background nor another side has such a plane.
        self.with_rendering(&self.planes, None, |rendering| {
            let alone = |occlusion| Occlusion {
                other_sides: None,
                ..occlusion
            };
            let rendering = Rendering {
                planes: &planes,
                occlusion: rendering.occlusion.map(alone),
                ..*rendering
            };
            Ok(rendering.render(None, progress)?.planes.swap_remove(0))
        })
    }

    fn with_rendering<T>(
        &self,
        light: &PremultipliedPlanes,
        background: Option<&PreparedBackground>,
        then: impl FnOnce(&Rendering) -> Result<T>,
    ) -> Result<T> {
        let settings = self.session.settings();
        self.session
            .with_optics(&self.placement, self.vergence(), |optics| {
                let refocus = |vergence| refocus(optics.focus_remap, vergence);
                let holdout = self.holdout.as_ref();
                let holdout_vergence = holdout.and_then(PreparedHoldout::vergence).map(refocus);
                let holdout = holdout.map(|holdout| Holdout {
                    matte: holdout.matte(),
                    vergence: holdout_vergence.as_ref().map(FocusedVergence::pass),
                });
                let behind = background.map(|own| (own.planes(), refocus(own.vergence())));
                let background = behind.as_ref().map(|(planes, vergence)| Background {
                    planes,
                    vergence: vergence.pass(),
                });
                let planes = light.weighted(&self.weights);
                // A mask of the blur changes the vergence of each pixel, not that of its other side.
                let is_divided = settings.occlusion.is_some() && self.masked_vergence().is_none();
                let averaged = self.depth.averaged().filter(|_| is_divided);
                let divided = averaged.map(|averaged| averaged.divide(&planes));
                let other_planes = divided.as_ref().map(DividedLight::others);
                let other_planes = other_planes.unwrap_or_default();
                let other_vergence = averaged.map(|averaged| refocus(averaged.other_vergence()));
                let other_sides = averaged.zip(other_vergence.as_ref());
                let other_sides = other_sides
                    .and_then(|(averaged, of)| averaged.other_sides(&other_planes, of.pass()));
                let occlusion = settings.occlusion.map(|occlusion| Occlusion {
                    other_sides,
                    fill_foreground: occlusion.fill_foreground,
                    blur_inside: occlusion.blur_inside,
                    holdout,
                    background,
                    own: self.own,
                    light_planes: Some(self.colour_count()),
                });
                let edges = self.edges();
                let chromatic = ChromaticLens::new(optics.scene.lens);
                let mut scene = Scene {
                    edges: edges.of_renderer(),
                    ..optics.scene
                };
                if settings.only_chroma {
                    scene.lens = &chromatic;
                }
                let clamped = (self.own).map(|own| ClampedLens::new(&scene, own));
                if let Some(lens) = &clamped {
                    scene.lens = lens;
                }
                let kernels = self.session.lens().kernels();
                kernels.begin_render();
                then(&Rendering {
                    scene: &scene,
                    planes: &divided
                        .as_ref()
                        .map_or(planes.clone(), |d| d.own_sides(&planes)),
                    occlusion,
                    edges,
                    renderer: &*settings.quality.renderer(kernels),
                    quality: settings.quality,
                })
            })
    }

    /// Returns a warning if the maximum size of the focus settings is smaller than kernels in focus, which bound it.
    ///
    /// # Errors
    /// Focus settings that cannot be followed.
    pub fn focus_warning(&self) -> Result<Option<String>> {
        let Some(maximum) = self.session.settings().focus.maximum_px else {
            return Ok(None);
        };
        // The warning depends on the lens and the place of the plate, not on its depth.
        let anywhere = VergencePass::Constant(0.0);
        self.session
            .with_optics(&self.placement, anywhere, |optics| {
                let in_focus = optics.focus_remap.and_then(|r| r.unreachable_maximum_px());
                Ok(in_focus.map(|in_focus| {
                    format!(
                        "maximum size: {maximum} px is below the kernels of {in_focus:.3} px that the lens has in focus; everything is drawn as in focus"
                    )
                }))
            })
    }

    /// Returns a warning if a film back or a lens scale makes the display window larger than the frame of the lens.
    pub fn frame_warning(&self) -> Option<String> {
        let lens = self.session.lens().frame();
        let share = self.placement.diagonal_share(lens, &self.geometry);
        let is_chosen = self.geometry.lens_scale != LensScale::FrameWidth;
        (is_chosen && share > MOST_DIAGONAL_SHARE).then(|| {
            format!(
                "the picture's diagonal is {share:.2} times that of the lens's frame; blur beyond the frame is extrapolated"
            )
        })
    }

    /// Returns how far the light of lit pixels reaches along x and along y, plate pixels.
    pub(crate) fn reach_of_light(&self) -> Result<(f64, f64)> {
        let lit_vergences: Vec<f32>;
        let vergence = match self.vergence() {
            VergencePass::PerPixel(pass) => {
                let is_lit = |index: usize| self.planes().iter().any(|plane| plane[index] != 0.0);
                let lit = pass.iter().enumerate().filter(|(index, _)| is_lit(*index));
                lit_vergences = lit.map(|(_, vergence)| *vergence).collect();
                VergencePass::PerPixel(&lit_vergences)
            }
            constant => constant,
        };
        let reach =
            |optics: &PlateOptics| Ok(self.session.reach_of(&self.placement, &optics.scene));
        self.session.with_optics(&self.placement, vergence, reach)
    }

    pub(crate) fn with_optics<T>(&self, then: impl FnOnce(&PlateOptics) -> Result<T>) -> Result<T> {
        self.session
            .with_optics(&self.placement, self.vergence(), then)
    }

    /// The vergences to render, before the focus settings change them.
    fn vergence(&self) -> VergencePass<'_> {
        let masked = self.masked_vergence();
        masked.unwrap_or_else(|| self.depth.vergence())
    }

    fn masked_vergence(&self) -> Option<VergencePass<'_>> {
        self.mask.as_ref().and_then(PreparedMask::vergence)
    }

    pub(crate) fn weights(&self) -> &[Vec<f64>] {
        &self.weights
    }

    pub(crate) fn premultiplied(&self) -> &PremultipliedPlanes {
        &self.planes
    }

    pub(crate) fn develop(&self, planes: &mut [Vec<f32>]) {
        let lens = self.session.predictor();
        self.planes.develop(lens, &self.weights, planes);
    }

    /// The planes as the light that the sensor recorded.
    pub(crate) fn undeveloped(&self) -> PremultipliedPlanes {
        let mut planes = self.planes.clone();
        planes.undevelop(self.session.predictor(), &self.weights);
        planes
    }

    /// Returns the same plate, without its holdout, mask and background, prepared for the lens of another `session`.
    ///
    /// # Errors
    /// Those of [`LensSession::prepare`].
    pub fn for_session(&self, session: &Arc<LensSession>) -> Result<Self> {
        Ok(Self {
            weights: channel_weights(self.planes.layout(), session.predictor())?,
            depth: PreparedDepth::new(session, &self.geometry, self.depth.source().clone())?,
            placement: session.place(&self.geometry)?,
            planes: self.planes.clone(),
            session: Arc::clone(session),
            geometry: self.geometry,
            holdout: None,
            mask: None,
            background: None,
            own: self.own,
        })
    }

    /// Weights of the lens channels on a plane seen by all colours.
    pub(crate) fn mean_colour_weights(&self) -> Vec<f64> {
        let colours = &self.weights[..self.colour_count()];
        let channels = colours.first().map_or(0, Vec::len);
        let count = colours.len() as f64;
        let mean = |k: usize| colours.iter().map(|w| w[k]).sum::<f64>() / count;
        (0..channels).map(mean).collect()
    }
}
