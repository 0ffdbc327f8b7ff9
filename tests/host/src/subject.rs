//! What is tested: a binary, a plugin in it, and what is to be known of that kind of plugin.

use std::path::PathBuf;

use crate::host::effect::Setting;

/// A value of a parameter, as tables hold it.
#[derive(Clone, Copy, Debug)]
pub enum Knob {
    /// An int, a choice or a boolean.
    Int(i32),
    /// A double.
    Double(f64),
    /// Two doubles.
    Pair(f64, f64),
    /// A string.
    Text(&'static str),
}

impl Knob {
    /// The value of a parameter.
    #[must_use]
    pub fn setting(&self) -> Setting {
        match self {
            Self::Int(v) => Setting::Ints(vec![*v]),
            Self::Double(v) => Setting::Doubles(vec![*v]),
            Self::Pair(x, y) => Setting::Doubles(vec![*x, *y]),
            Self::Text(v) => Setting::Text((*v).to_owned()),
        }
    }
}

/// Parameters and what they are set to.
pub type Knobs = &'static [(&'static str, Knob)];

/// A parameter that names a file.
#[derive(Debug)]
pub struct FileKnob {
    /// Its name.
    pub name: &'static str,
    /// What makes the plugin read the file.
    pub in_use: Knobs,
    /// What makes it need no file.
    pub without: Knobs,
}

/// What the checks know of a kind of plugin.
#[derive(Debug)]
pub struct Kind {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What makes it blur by a few pixels.
    pub blur: Knobs,
    /// Settings, each of which makes it change nothing.
    pub identities: &'static [Knobs],
    /// Other modes, each set on top of what blurs.
    pub variants: &'static [Knobs],
    /// What makes it look at Depth, if it does.
    pub depth: Option<Knobs>,
    /// What makes it look at Mask, if it does.
    pub mask: Option<Knobs>,
    /// A file it reads.
    pub file: Option<FileKnob>,
    /// How far the picture at half scale may be from the mean of four pixels of the whole, as a share of its range.
    pub half_scale: f32,
    /// How far from one half the width of the blur may be where pixels are twice as wide.
    pub half_width: f64,
    /// Whether it asks whether to stop so often that this can be counted on a small picture.
    pub polls: bool,
}

/// Kinds known by name.
#[must_use]
pub fn kinds() -> Vec<&'static Kind> {
    vec![
        &crate::subjects::any::KIND,
        &crate::subjects::box_blur::KIND,
        &crate::subjects::seidel::KIND,
    ]
}

/// One plugin to be tested.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its binary or bundle.
    pub file: PathBuf,
    /// Which of the plugins in it; nothing: the first.
    pub id: Option<String>,
    /// What is known of it.
    pub kind: &'static Kind,
}
