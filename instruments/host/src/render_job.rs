//! Rendering one image from files, with a plugin set up as a user would.

use std::path::PathBuf;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::kOfxImageEffectContextGeneral;
use openfx::sys::image_effect_v1::param::*;

use crate::drive::{Instance, Library, LoadedPlugin, RenderRequest};
use crate::files;
use crate::host::Host;
use crate::host::effect::{Parameter, ParameterValue};
use crate::host::profiles;
use crate::host::suites::Shape;
use crate::panel::{Row, panel};
use crate::picture::Picture;
use crate::scene::{Input, Scene};

/// A clip connected to a file.
#[derive(Clone, Debug)]
pub struct ClipFile {
    /// The name of the clip.
    pub clip: String,
    /// An OpenEXR file.
    pub file: PathBuf,
    /// One channel of the file; its colour by default.
    pub channel: Option<String>,
}

/// An image to render.
#[derive(Clone, Debug)]
pub struct RenderJob {
    /// The plugin's binary or bundle.
    pub plugin: PathBuf,
    /// The plugin's identifier, if it is not the first of the binary.
    pub id: Option<String>,
    /// The name of the host profile.
    pub host: String,
    /// The connected clips.
    pub feeds: Vec<ClipFile>,
    /// Parameters and their values as text: numbers separated by commas, menu options, strings. Buttons are pressed.
    pub settings: Vec<(String, String)>,
    /// The time.
    pub time: f64,
    /// Whether to draw the plugin's overlay over the image.
    pub overlay: bool,
}

impl Default for RenderJob {
    fn default() -> Self {
        Self {
            plugin: PathBuf::new(),
            id: None,
            host: "complete".to_owned(),
            feeds: Vec::new(),
            settings: Vec::new(),
            time: 0.0,
            overlay: false,
        }
    }
}

impl RenderJob {
    /// Renders the image.
    ///
    /// # Errors
    /// If a file, clip or parameter does not exist, or the plugin fails or misuses the host.
    pub fn run(&self) -> Result<Picture, String> {
        let scene = self.scene()?;
        self.with_plugin(|loaded| self.render(loaded, &scene))
    }

    /// Returns the panel of the plugin's parameters.
    ///
    /// # Errors
    /// If the plugin fails or misuses the host.
    pub fn panel(&self) -> Result<Vec<Row>, String> {
        self.with_plugin(|loaded| {
            let context = loaded.context_like(kOfxImageEffectContextGeneral)?;
            let descriptor = loaded.describe_in(&context)?;
            let rows = panel(&descriptor, &loaded.host.profile);
            descriptor.invalidate(loaded.host);
            Ok(rows)
        })
    }

    /// Runs `work` on the plugin, loaded in the host.
    fn with_plugin<T>(
        &self,
        work: impl FnOnce(&LoadedPlugin<'_>) -> Result<T, String>,
    ) -> Result<T, String> {
        let profile = (profiles::all().into_iter())
            .find(|profile| profile.name == self.host)
            .ok_or_else(|| {
                let names: Vec<_> = profiles::all().iter().map(|p| p.name).collect();
                format!("--host {}: give one of {}", self.host, names.join(", "))
            })?;
        let library = Library::open(&self.plugin)?;
        let plugin = library.find(self.id.as_deref())?;
        let host = Host::activate(profile);
        let loaded = LoadedPlugin::load(&host, &plugin)?;
        let result = work(&loaded);
        let unloaded = loaded.unload();
        let misuse = host.take_misuse();
        let result = result?;
        unloaded?;
        if let Some(misuse) = misuse.into_iter().next() {
            return Err(misuse);
        }
        drop(host);
        library.close()?;
        Ok(result)
    }

    fn scene(&self) -> Result<Scene, String> {
        let mut scene = Scene::default();
        for feed in &self.feeds {
            let read = files::read(&feed.file, feed.channel.as_deref())?;
            if feed.clip == "Source" {
                scene.project = read.frame;
                scene.par = read.par;
            }
            scene = scene.connect(&feed.clip, Input::still(read.picture));
        }
        if scene.inputs.contains_key("Source") {
            Ok(scene)
        } else {
            Err("no input; give --feed Source=FILE".to_owned())
        }
    }

    fn render(&self, loaded: &LoadedPlugin<'_>, scene: &Scene) -> Result<Picture, String> {
        let context = loaded.context(scene)?;
        let instance = Instance::new(loaded, &context, scene)?;
        for feed in &self.feeds {
            if instance.effect.clip(&feed.clip).is_none() {
                let clips = instance.effect.clips();
                let names: Vec<_> = clips.iter().map(|clip| clip.name.as_str()).collect();
                return Err(format!(
                    "--feed {}: give one of {}",
                    feed.clip,
                    names.join(", ")
                ));
            }
        }
        for feed in &self.feeds {
            instance.notify_connected(&feed.clip)?;
        }
        for (name, text) in &self.settings {
            let parameter = (instance.effect.parameters.get(name)).ok_or_else(|| {
                let names: Vec<_> = (instance.effect.parameters.all().iter())
                    .filter(|one| one.value() != ParameterValue::None)
                    .map(|one| one.name.clone())
                    .collect();
                format!("--set {name}: give one of {}", names.join(", "))
            })?;
            if parameter.kind.as_c_str() == kOfxParamTypePushButton {
                instance.notify_changed(kOfxTypeParameter, name, kOfxChangeUserEdited)?;
            } else {
                instance.edit(name, &parse_value(&parameter, text)?)?;
            }
        }
        instance.save_and_open();
        instance.update_clip_preferences()?;
        let request = RenderRequest {
            time: self.time,
            ..RenderRequest::default()
        };
        let mut picture = instance.render_checked(&request)?.picture;
        if self.overlay {
            let drawing = (instance.draw_overlay()?)
                .ok_or("--overlay: the plugin has no overlay that uses the draw suite")?;
            for shape in &drawing.shapes {
                draw_shape(&mut picture, shape, scene.par);
            }
        }
        instance.destroy()?;
        Ok(picture)
    }
}

/// Parses the value of a parameter.
fn parse_value(parameter: &Parameter, text: &str) -> Result<ParameterValue, String> {
    let name = &parameter.name;
    let error = |problem: &str| format!("--set {name}={text}: {problem}");
    let numbers = |text: &str| -> Result<Vec<f64>, String> {
        (text.split(','))
            .map(|word| word.trim().parse().map_err(|_| error("give a number")))
            .collect()
    };
    let old = parameter.value();
    let new = match &old {
        ParameterValue::None => return Err(error("the parameter has no value")),
        ParameterValue::Text(_) => ParameterValue::Text(text.to_owned()),
        ParameterValue::Doubles(_) => ParameterValue::Doubles(numbers(text)?),
        ParameterValue::Ints(_) if parameter.kind.as_c_str() == kOfxParamTypeChoice => {
            let options = parameter.properties.texts(kOfxParamPropChoiceOption);
            let index = (options.iter())
                .position(|option| option.eq_ignore_ascii_case(text))
                .ok_or_else(|| error(&format!("give one of {}", options.join(", "))))?;
            ParameterValue::Ints(vec![index as i32])
        }
        ParameterValue::Ints(_) => {
            let text = match text {
                "on" | "true" => "1",
                "off" | "false" => "0",
                other => other,
            };
            ParameterValue::Ints(numbers(text)?.iter().map(|v| *v as i32).collect())
        }
    };
    if new.has_type_of(&old) {
        Ok(new)
    } else {
        Err(error("the parameter has another number of components"))
    }
}

/// Draws the lines of a shape over a picture.
fn draw_shape(picture: &mut Picture, shape: &Shape, par: f64) {
    let pixels: Vec<(f64, f64)> = shape.points.iter().map(|(x, y)| (x / par, *y)).collect();
    for (from, to) in shape.lines() {
        let (a, b) = (pixels[from], pixels[to]);
        let steps = ((b.0 - a.0).abs().max((b.1 - a.1).abs()).ceil() as usize).clamp(1, 1 << 16);
        for k in 0..=steps {
            let t = k as f64 / steps as f64;
            let x = (a.0 + t * (b.0 - a.0)).floor() as i32;
            let y = (a.1 + t * (b.1 - a.1)).floor() as i32;
            if let Some(index) = picture.index(x, y) {
                let colours = picture.channels.min(3);
                picture.samples[index..index + colours].copy_from_slice(&shape.colour[..colours]);
            }
        }
    }
}
