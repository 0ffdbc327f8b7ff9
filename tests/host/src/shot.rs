//! One picture that a plugin renders of files, set up as a user would.

use std::path::PathBuf;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::param::*;

use crate::drive::{Instance, Library, Loaded, Request};
use crate::files;
use crate::host::Host;
use crate::host::effect::{Parameter, Setting};
use crate::host::profiles;
use crate::host::suites::Stroke;
use crate::picture::Picture;
use crate::scene::{Input, Scene};

/// What is to be rendered.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The plugin's binary or bundle.
    pub plugin: PathBuf,
    /// Which of the plugins in it; nothing: the first.
    pub id: Option<String>,
    /// The kind of host, by name.
    pub host: String,
    /// Clips, the files they are fed with, and the channels of those; nothing: their colour.
    pub feeds: Vec<(String, PathBuf, Option<String>)>,
    /// Parameters and what they are set to, as words: numbers parted by commas, names of choices, texts;
    /// buttons are pressed.
    pub settings: Vec<(String, String)>,
    /// The time.
    pub time: f64,
    /// Whether what the overlay draws goes over the picture.
    pub overlay: bool,
}

impl Default for Shot {
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

impl Shot {
    /// Renders it, clips fed by files going before those of `scene`.
    ///
    /// # Errors
    /// Files, clips and parameters that are not there; what the plugin does wrong, or says.
    pub fn taken(&self) -> Result<Picture, String> {
        let profile = (profiles::all().into_iter())
            .find(|profile| profile.name == self.host)
            .ok_or_else(|| {
                let names: Vec<_> = profiles::all().iter().map(|p| p.name).collect();
                format!("--host {}: is not one of {}", self.host, names.join(", "))
            })?;
        let scene = self.scene()?;
        let library = Library::open(&self.plugin)?;
        let plugin = library.find(self.id.as_deref())?;
        let host = Host::enter(profile);
        let loaded = Loaded::new(&host, &plugin)?;
        let picture = self.rendered(&loaded, &scene);
        let unloaded = loaded.unload();
        let faults = host.take_misuse();
        let picture = picture?;
        unloaded?;
        if let Some(fault) = faults.first() {
            return Err(fault.clone());
        }
        drop(host);
        library.close()?;
        Ok(picture)
    }

    fn scene(&self) -> Result<Scene, String> {
        let mut scene = Scene::default();
        for (clip, file, channel) in &self.feeds {
            let read = files::read(file, channel.as_deref())?;
            if clip == "Source" {
                scene.project = read.frame;
                scene.par = read.par;
            }
            scene = scene.and(clip, Input::still(read.picture));
        }
        if scene.inputs.contains_key("Source") {
            Ok(scene)
        } else {
            Err("--feed Source=FILE: is missing".to_owned())
        }
    }

    fn rendered(&self, loaded: &Loaded<'_>, scene: &Scene) -> Result<Picture, String> {
        let context = loaded.context(scene.inputs.len() > 1)?;
        let instance = Instance::new(loaded, &context, scene)?;
        for (clip, ..) in &self.feeds {
            if instance.effect.clip(clip).is_none() {
                let all: Vec<_> = (instance.effect.clips().iter())
                    .map(|clip| clip.name.clone())
                    .collect();
                return Err(format!("--feed {clip}: is not one of {}", all.join(", ")));
            }
        }
        for (name, words) in &self.settings {
            let parameter = (instance.effect.parameters.get(name)).ok_or_else(|| {
                let all: Vec<_> = (instance.effect.parameters.all().iter())
                    .filter(|one| one.value() != Setting::None)
                    .map(|one| one.name.clone())
                    .collect();
                format!("--set {name}: is not one of {}", all.join(", "))
            })?;
            if parameter.kind.as_c_str() == kOfxParamTypePushButton {
                instance.changed(kOfxTypeParameter, name, kOfxChangeUserEdited)?;
            } else {
                instance.change(name, &setting(&parameter, words)?)?;
            }
        }
        instance.preferences()?;
        let request = Request {
            time: self.time,
            ..Request::default()
        };
        let mut picture = instance.render(&request)?.good()?.picture;
        if self.overlay {
            let strokes = (instance.overlay_alone()?)
                .ok_or("--overlay: the plugin has none that draws through the draw suite")?;
            for stroke in &strokes.strokes {
                over(&mut picture, stroke, scene.par);
            }
        }
        instance.destroy()?;
        Ok(picture)
    }
}

/// What a parameter is set to by words.
fn setting(parameter: &Parameter, words: &str) -> Result<Setting, String> {
    let name = &parameter.name;
    let wrong = |what: &str| format!("--set {name}={words}: {what}");
    let numbers = |words: &str| -> Result<Vec<f64>, String> {
        (words.split(','))
            .map(|word| word.trim().parse().map_err(|_| wrong("is not a number")))
            .collect()
    };
    let made = match parameter.value() {
        Setting::None => return Err(wrong("it holds no value")),
        Setting::Text(_) => Setting::Text(words.to_owned()),
        Setting::Doubles(_) => Setting::Doubles(numbers(words)?),
        Setting::Ints(_) if parameter.kind.as_c_str() == kOfxParamTypeChoice => {
            let options = parameter.properties.texts(kOfxParamPropChoiceOption);
            let at = (options.iter()).position(|option| option.eq_ignore_ascii_case(words));
            let at = at.ok_or_else(|| wrong(&format!("is not one of {}", options.join(", "))))?;
            Setting::Ints(vec![at as i32])
        }
        Setting::Ints(_) => {
            let words = match words {
                "on" | "true" => "1",
                "off" | "false" => "0",
                other => other,
            };
            Setting::Ints(numbers(words)?.iter().map(|v| *v as i32).collect())
        }
    };
    let counts = match (&made, parameter.value()) {
        (Setting::Ints(a), Setting::Ints(b)) => a.len() == b.len(),
        (Setting::Doubles(a), Setting::Doubles(b)) => a.len() == b.len(),
        _ => true,
    };
    if counts {
        Ok(made)
    } else {
        Err(wrong("is not as many numbers as it has"))
    }
}

/// Draws a stroke of an overlay over a picture, its points canonical.
fn over(picture: &mut Picture, stroke: &Stroke, par: f64) {
    let pixels: Vec<(f64, f64)> = stroke.points.iter().map(|(x, y)| (x / par, *y)).collect();
    for (from, to) in stroke.ends() {
        let (a, b) = (pixels[from], pixels[to]);
        let steps = ((b.0 - a.0).abs().max((b.1 - a.1).abs()).ceil() as usize).clamp(1, 1 << 16);
        for k in 0..=steps {
            let t = k as f64 / steps as f64;
            let x = (a.0 + t * (b.0 - a.0)).floor() as i32;
            let y = (a.1 + t * (b.1 - a.1)).floor() as i32;
            if let Some(at) = picture.at(x, y) {
                let colours = picture.channels.min(3);
                picture.samples[at..at + colours].copy_from_slice(&stroke.colour[..colours]);
            }
        }
    }
}
