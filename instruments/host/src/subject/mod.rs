//! The plugin under test, and what the checks know of its parameters.

mod any;
mod box_blur;
mod seidel;

use std::path::PathBuf;

use crate::host::effect::ParameterValue;

/// A parameter value in a static table.
#[derive(Clone, Copy, Debug)]
pub enum StaticValue {
    /// An integer, choice or boolean.
    Int(i32),
    /// A double.
    Double(f64),
    /// A string.
    Text(&'static str),
}

impl StaticValue {
    /// Converts it to a parameter value.
    #[must_use]
    pub fn value(&self) -> ParameterValue {
        match self {
            Self::Int(v) => ParameterValue::Ints(vec![*v]),
            Self::Double(v) => ParameterValue::Doubles(vec![*v]),
            Self::Text(v) => ParameterValue::Text((*v).to_owned()),
        }
    }
}

/// Parameters by name, with their values.
pub type Settings = &'static [(&'static str, StaticValue)];

/// A parameter that names a file.
#[derive(Debug)]
pub struct FileParameter {
    /// Its name.
    pub name: &'static str,
    /// Settings with which the plugin reads the file.
    pub in_use: Settings,
    /// Settings with which it needs no file.
    pub not_in_use: Settings,
}

/// A number that changes the blur.
#[derive(Debug)]
pub struct Animated {
    /// The name of the parameter.
    pub name: &'static str,
    /// Its values over a shot.
    pub range: (f64, f64),
    /// Settings with which it has an effect.
    pub in_use: Settings,
}

/// A kind of plugin, as far as the checks need it.
#[derive(Debug)]
pub struct PluginKind {
    /// Its name on the command line.
    pub name: &'static str,
    /// Settings with which it blurs by a few pixels.
    pub blur: Settings,
    /// Settings on top of `blur`, each of which makes it the identity.
    pub identities: &'static [Settings],
    /// Other modes: settings on top of `blur`.
    pub variants: &'static [Settings],
    /// Other modes that need all inputs.
    pub connected_variants: &'static [Settings],
    /// Settings with which it uses Depth, if it has this clip.
    pub depth: Option<Settings>,
    /// Settings with which it uses Mask, if it has this clip.
    pub mask: Option<Settings>,
    /// A file that it reads.
    pub file: Option<FileParameter>,
    /// Settings on top of `blur` with parameters of files that name something that is no file.
    pub references: &'static [Settings],
    /// A number that changes the blur.
    pub animated: Option<Animated>,
    /// Largest difference, for samples of 0 to 1, between a render at half scale and the downsampled full one.
    pub half_scale_tolerance: f32,
    /// Largest difference of the blur width, in pixels twice as wide, from half that in square pixels.
    pub pixel_aspect_tolerance: f64,
    /// Whether it calls `abort` even during the render of a small picture.
    pub polls_abort: bool,
}

/// All kinds of plugins.
pub const KINDS: [&PluginKind; 3] = [&any::KIND, &box_blur::KIND, &seidel::KIND];

/// A plugin to be tested.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its binary or bundle.
    pub file: PathBuf,
    /// Its identifier, if it is not the first plugin of the binary.
    pub id: Option<String>,
    /// Its kind.
    pub kind: &'static PluginKind,
}

impl Subject {
    /// Creates a subject of the kind with this name.
    ///
    /// # Errors
    /// If there is no such kind.
    pub fn new(file: PathBuf, kind: &str, id: Option<String>) -> Result<Self, String> {
        let kind = KINDS.into_iter().find(|k| k.name == kind).ok_or_else(|| {
            let names = KINDS.map(|k| k.name);
            format!("--kind {kind}: give one of {}", names.join(", "))
        })?;
        Ok(Self { file, id, kind })
    }
}
