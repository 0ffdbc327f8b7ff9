//! The settings of a call: the attributes of `seidel.Settings`, as those of the core.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use seidel_core::{
    AlphaKind, Bloom, ChannelScale, Controls, Displacement, Edges, FocusControls, Grain,
    LensScale, OcclusionSettings, Quality, RemovalSettings, Saturation, Settings,
};

use crate::depth::object_distance;
use crate::error::{Failure, Result};
use crate::look::LookArgs;

/// The attributes of `seidel.Settings`, which documents them.
#[derive(FromPyObject)]
struct SettingsArgs<'py> {
    amount: f64,
    psf_model: Option<String>,
    channel_scales: BTreeMap<String, f64>,
    axis_offset_px: (f64, f64),
    geometry: String,
    focus_distance: Option<f64>,
    f_number: Option<f64>,
    sensor_shift_um: Option<f64>,
    focal_length_mm: Option<f64>,
    depth_of_field: f64,
    front_multiplier: f64,
    back_multiplier: f64,
    maximum_size: Option<f64>,
    quality: String,
    edges: String,
    occlusion: bool,
    fill_foreground: bool,
    blur_inside: bool,
    noise: Option<OneOrMore>,
    clip: Clip,
    strength: f64,
    grain: String,
    alpha: String,
    scrub: bool,
    lens_scale: Option<f64>,
    film_back_mm: Option<f64>,
    pixel_aspect: f64,
    display_window: Option<(i32, i32, usize, usize)>,
    threads: u32,
    look: LookArgs<'py>,
    bloom: f64,
    bloom_level: f64,
    bloom_radius: f64,
}

/// One number for all colours, or one for each.
#[derive(FromPyObject)]
enum OneOrMore {
    One(f64),
    More(Vec<f64>),
}

/// The level of clipping: a number, or a word.
#[derive(FromPyObject)]
enum Clip {
    Level(f64),
    Word(String),
}

/// The settings of a call.
pub(crate) struct CallSettings {
    /// Settings of the core.
    pub(crate) core: Settings,
    /// Relation of colour and alpha.
    pub(crate) alpha: AlphaKind,
    /// Whether samples that are not finite count as zero.
    pub(crate) replaces_non_finite: bool,
    /// Scale of the lens's frame on the image.
    pub(crate) lens_scale: LensScale,
    /// Width of a plate pixel over its height.
    pub(crate) pixel_aspect: f64,
    /// Display window (x, y, width, height) in pixels of the image; the image if `None`.
    pub(crate) display_window: Option<(i32, i32, usize, usize)>,
    /// Most threads; 0 for one each core.
    pub(crate) threads: u32,
}

impl CallSettings {
    /// Reads the argument `settings`; `None` stands for the defaults.
    ///
    /// # Errors
    /// Attributes of another type, and unknown choices. Ranges are checked by the core.
    pub(crate) fn read(py: Python<'_>, settings: Option<&Bound<'_, PyAny>>) -> Result<Self> {
        let args: SettingsArgs = match settings {
            Some(settings) => settings.extract()?,
            None => {
                let defaults = py
                    .import("seidel._settings")?
                    .getattr("Settings")?
                    .call0()?;
                defaults.extract()?
            }
        };
        args.into_call_settings()
    }

    /// Checks that occlusion is on, for the argument `name`.
    ///
    /// # Errors
    /// Settings without occlusion.
    pub(crate) fn check_occlusion(&self, name: &str) -> Result<()> {
        if self.core.occlusion.is_some() {
            return Ok(());
        }
        Err(Failure::argument(
            name,
            "needs occlusion, which settings.occlusion turns off",
            "leave one of the two out",
        ))
    }

    /// Checks that what a foreground uncovers is filled from the background, for the argument `name`.
    ///
    /// # Errors
    /// Settings without occlusion, and those that fill it with the foreground's own light.
    pub(crate) fn check_fill(&self, name: &str) -> Result<()> {
        self.check_occlusion(name)?;
        if self.core.occlusion.is_some_and(|o| o.fill_foreground) {
            return Ok(());
        }
        Err(Failure::argument(
            name,
            "is not used where settings.fill_foreground is False",
            "leave one of the two out",
        ))
    }
}

impl SettingsArgs<'_> {
    fn into_call_settings(self) -> Result<CallSettings> {
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(Failure::argument(
                "settings.strength",
                format!("is {}", self.strength),
                "give a number from 0 to 1",
            ));
        }
        let alpha = choose(
            "alpha",
            &self.alpha,
            &[
                ("premultiplied", AlphaKind::Premultiplied),
                ("unpremultiplied", AlphaKind::Unpremultiplied),
            ],
        )?;
        let mut core = Settings::default();
        self.put_lens(&mut core)?;
        self.put_rendering(&mut core)?;
        core.removal = self.removal()?;
        Ok(CallSettings {
            core,
            alpha,
            replaces_non_finite: self.scrub,
            lens_scale: self.lens_scale()?,
            pixel_aspect: self.pixel_aspect,
            display_window: self.display_window,
            threads: self.threads,
        })
    }

    /// Returns the scale of the lens's frame on the image.
    ///
    /// # Errors
    /// A film back beside a lens scale.
    fn lens_scale(&self) -> Result<LensScale> {
        match (self.film_back_mm, self.lens_scale) {
            (Some(_), Some(_)) => Err(Failure::argument(
                "settings.film_back_mm",
                "is given beside lens_scale",
                "leave one of the two out",
            )),
            (Some(width_mm), None) => Ok(LensScale::FilmBack(width_mm)),
            (None, Some(ratio)) => Ok(LensScale::PixelRatio(ratio)),
            (None, None) => Ok(LensScale::FrameWidth),
        }
    }

    /// Sets the use of the lens.
    fn put_lens(&self, core: &mut Settings) -> Result<()> {
        let focus_distance = self
            .focus_distance
            .map(|metres| object_distance(Some(metres)));
        core.controls = Controls {
            focus_distance: focus_distance.transpose()?,
            f_number: self.f_number,
            sensor_shift_um: self.sensor_shift_um,
            focal_length_mm: self.focal_length_mm,
        };
        core.look = self.look.look()?;
        core.bloom = (self.bloom != 0.0).then_some(Bloom {
            share: self.bloom,
            level: self.bloom_level,
            radius: self.bloom_radius / 100.0,
        });
        core.psf_model = self.psf_model.clone();
        core.amount = self.amount;
        let scales = self.channel_scales.iter();
        core.channel_scales = scales
            .map(|(channel, scale)| ChannelScale {
                channel: channel.clone(),
                scale: *scale,
            })
            .collect();
        core.axis_offset_px = self.axis_offset_px;
        core.displacement = choose(
            "geometry",
            &self.geometry,
            &[
                ("none", Displacement::None),
                ("lateral", Displacement::Lateral),
                ("full", Displacement::Full),
            ],
        )?;
        core.focus = FocusControls {
            focus_per_m: None,
            depth_of_field_m: self.depth_of_field,
            front: self.front_multiplier,
            back: self.back_multiplier,
            maximum_px: self.maximum_size,
        };
        Ok(())
    }

    /// Sets accuracy, edges and occlusion.
    fn put_rendering(&self, core: &mut Settings) -> Result<()> {
        core.quality = choose(
            "quality",
            &self.quality,
            &[
                ("draft", Quality::Draft),
                ("final", Quality::Final),
                ("exact", Quality::Exact),
            ],
        )?;
        core.edges = choose(
            "edges",
            &self.edges,
            &[
                ("auto", None),
                ("mirror", Some(Edges::Mirror)),
                ("black", Some(Edges::Black)),
                ("extend", Some(Edges::Extend)),
            ],
        )?;
        core.occlusion = self.occlusion.then_some(OcclusionSettings {
            fill_foreground: self.fill_foreground,
            blur_inside: self.blur_inside,
        });
        Ok(())
    }

    fn removal(&self) -> Result<RemovalSettings> {
        let noise = match &self.noise {
            None => Vec::new(),
            Some(OneOrMore::One(noise)) => vec![*noise],
            Some(OneOrMore::More(noise)) => noise.clone(),
        };
        if let Some(bad) = noise
            .iter()
            .find(|noise| !(noise.is_finite() && **noise >= 0.0))
        {
            return Err(Failure::argument(
                "settings.noise",
                format!("is {bad}"),
                "give a standard deviation of zero or more, such as 0.004",
            ));
        }
        let saturation = match &self.clip {
            Clip::Level(level) => Saturation::Level(*level),
            Clip::Word(word) => choose(
                "clip",
                word,
                &[("auto", Saturation::Auto), ("none", Saturation::Never)],
            )?,
        };
        let grain = choose(
            "grain",
            &self.grain,
            &[("keep", Grain::Keep), ("solved", Grain::Solved)],
        )?;
        Ok(RemovalSettings {
            noise,
            saturation,
            strength: self.strength,
            grain,
        })
    }
}

/// Returns the value of the choice that `word`, the setting `name`, names.
fn choose<T: Copy>(name: &str, word: &str, choices: &[(&str, T)]) -> Result<T> {
    let choice = choices.iter().find(|(choice, _)| *choice == word);
    choice.map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<String> = choices
            .iter()
            .map(|(choice, _)| format!("{choice:?}"))
            .collect();
        Failure::argument(
            &format!("settings.{name}"),
            format!("is {word:?}"),
            format!("give one of {}", words.join(", ")),
        )
    })
}
