//! The settings of a call: the attributes of `seidel.Settings`, as those of the core.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use seidel_core::{AlphaKind, ChannelScale, Knob, KnobKind, LensScale, Saturation, Settings};

use crate::error::{Failure, Result};
use crate::look::put_look;

/// The attributes of `seidel.Settings`, which documents them, that are no knobs of the core's table or more than a number.
#[derive(FromPyObject)]
struct OwnArgs<'py> {
    psf_model: Option<String>,
    channel_scales: BTreeMap<String, f64>,
    axis_offset_px: (f64, f64),
    noise: Option<OneOrMore>,
    clip: Clip,
    alpha: String,
    scrub: bool,
    pixel_aspect: f64,
    display_window: Option<(i32, i32, usize, usize)>,
    threads: u32,
    look: Bound<'py, PyAny>,
}

/// The knobs that the package has in another form, or not at all.
const OTHER_KNOBS: [&str; 4] = ["noise", "clip", "clip-level", "expand"];

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
        let settings = match settings {
            Some(settings) => settings.clone(),
            None => {
                let module = py.import("seidel._settings")?;
                module.getattr("Settings")?.call0()?
            }
        };
        let own: OwnArgs = settings.extract()?;
        let mut core = Settings::default();
        own.put(&mut core)?;
        put_knobs(&settings, "settings", &mut core, |knob| !knob.is_of_look())?;
        let kinds = [
            ("premultiplied", AlphaKind::Premultiplied),
            ("unpremultiplied", AlphaKind::Unpremultiplied),
        ];
        Ok(Self {
            alpha: choose("alpha", &own.alpha, &kinds)?,
            replaces_non_finite: own.scrub,
            lens_scale: core.lens_scale,
            core,
            pixel_aspect: own.pixel_aspect,
            display_window: own.display_window,
            threads: own.threads,
        })
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

impl OwnArgs<'_> {
    /// Writes the attributes to `core`.
    ///
    /// # Errors
    /// Unknown words, and values that the core refuses.
    fn put(&self, core: &mut Settings) -> Result<()> {
        put_look(&self.look, core)?;
        core.psf_model = self.psf_model.clone();
        let scales = self.channel_scales.iter();
        core.channel_scales = scales
            .map(|(channel, scale)| ChannelScale {
                channel: channel.clone(),
                scale: *scale,
            })
            .collect();
        core.axis_offset_px = self.axis_offset_px;
        core.removal.noise = match &self.noise {
            None => Vec::new(),
            Some(OneOrMore::One(noise)) => vec![*noise],
            Some(OneOrMore::More(noise)) => noise.clone(),
        };
        core.removal.saturation = match &self.clip {
            Clip::Level(level) => Saturation::Level(*level),
            Clip::Word(word) => choose(
                "clip",
                word,
                &[("auto", Saturation::Auto), ("none", Saturation::Never)],
            )?,
        };
        Ok(())
    }
}

/// Writes the knobs of the core's table that are attributes of `object`, an argument called `name`, to `core`. They are those of
/// a look, or all others.
///
/// # Errors
/// Values of another type or out of range, unknown words, and two attributes of which only one may be given.
pub(crate) fn put_knobs(
    object: &Bound<'_, PyAny>,
    name: &str,
    core: &mut Settings,
    is_wanted: impl Fn(&Knob) -> bool,
) -> Result<()> {
    let knobs = Knob::all().filter(|knob| !OTHER_KNOBS.contains(&knob.name));
    for knob in knobs.filter(|knob| is_wanted(knob)) {
        let identifier = knob.identifier();
        let attribute = object.getattr(identifier.as_str())?;
        let path = format!("{name}.{identifier}");
        let in_attribute = |e: seidel_core::Error| Failure::argument(&path, e.problem, e.remedy);
        match &knob.kind {
            KnobKind::Number(number) => {
                let value: Option<f64> = if number.default.is_none() {
                    attribute.extract()?
                } else {
                    Some(attribute.extract()?)
                };
                let Some(value) = value else {
                    continue;
                };
                let is_given = |other: &Knob| {
                    let other = object.getattr(other.identifier().as_str());
                    other.is_ok_and(|value| !value.is_none())
                };
                knob.check_alone(is_given).map_err(in_attribute)?;
                knob.put_number(value, core).map_err(in_attribute)?;
            }
            KnobKind::Switch(_) => {
                let is_on: bool = attribute.extract()?;
                knob.put_index(usize::from(is_on), core)
                    .map_err(in_attribute)?;
            }
            KnobKind::Choice(choice) => {
                let word: String = attribute.extract()?;
                let index = choice.index_of(&word).ok_or_else(|| {
                    let words: Vec<_> = (choice.options.iter())
                        .map(|option| format!("{:?}", option.word))
                        .collect();
                    let remedy = format!("give one of {}", words.join(", "));
                    Failure::argument(&path, format!("is {word:?}"), remedy)
                })?;
                knob.put_index(index, core).map_err(in_attribute)?;
            }
        }
    }
    Ok(())
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
