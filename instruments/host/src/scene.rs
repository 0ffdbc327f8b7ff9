//! The scene of an instance: what its clips are connected to, and the project.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::image_effect_v1::image_effect::*;

use crate::host::sample_type::SampleType;
use crate::picture::{Picture, Rect, Region};

/// The source of a clip's images.
#[derive(Clone, Debug, Default)]
pub enum Feed {
    /// Nothing: it is not connected.
    #[default]
    Unconnected,
    /// A cycle of pictures, one per frame.
    Pictures(Vec<Arc<Picture>>),
    /// An error, although it is connected.
    Fails,
    /// Success with a NULL handle, although it is connected.
    NullHandle,
    /// Images with NULL data, although it is connected.
    NullData,
}

/// The connection of one clip.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// The source of its images.
    pub feed: Feed,
    /// Premultiplication that it reports; by default opaque for RGB and premultiplied otherwise.
    pub premultiplication: Option<&'static CStr>,
}

impl Input {
    /// Creates an input with the same picture at all times.
    #[must_use]
    pub fn still(picture: Picture) -> Self {
        Self::new(Feed::Pictures(vec![Arc::new(picture)]))
    }

    /// Creates an input with default premultiplication.
    #[must_use]
    pub fn new(feed: Feed) -> Self {
        Self {
            feed,
            premultiplication: None,
        }
    }

    /// Returns the picture at a time.
    pub(crate) fn picture(&self, time: f64) -> Option<Arc<Picture>> {
        match &self.feed {
            Feed::Pictures(all) if !all.is_empty() => {
                let frame = (time.round() as i64).rem_euclid(all.len() as i64);
                all.get(frame as usize).cloned()
            }
            _ => None,
        }
    }

    /// Returns the premultiplication that images with so many channels report.
    pub(crate) fn premultiplication(&self, channels: usize) -> &'static CStr {
        let default = if channels == 3 {
            kOfxImageOpaque
        } else {
            kOfxImagePreMultiplied
        };
        self.premultiplication.unwrap_or(default)
    }
}

/// The connections of all clips, and the project.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Inputs by clip name.
    pub inputs: BTreeMap<String, Input>,
    /// The project's frame.
    pub project: Region,
    /// Pixel aspect ratio of all clips.
    pub par: f64,
    /// Number of channels of Output; `None` for that of Source.
    pub(crate) output: Option<usize>,
    /// Sample type of all images. An instance sets it by what its plugin supports.
    pub(crate) samples: SampleType,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            inputs: BTreeMap::new(),
            project: Region::new(0.0, 0.0, 1.0, 1.0),
            par: 1.0,
            output: None,
            samples: SampleType::default(),
        }
    }
}

impl Scene {
    /// Creates a scene of square pixels with one picture as Source, which fills the project.
    #[must_use]
    pub fn new(source: Picture) -> Self {
        Self::with_par(source, 1.0)
    }

    /// Creates such a scene with another pixel aspect ratio.
    #[must_use]
    pub fn with_par(source: Picture, par: f64) -> Self {
        Self {
            project: Region::from_pixels(&source.bounds, (1.0, 1.0), par),
            inputs: BTreeMap::from([("Source".to_owned(), Input::still(source))]),
            par,
            output: None,
            samples: SampleType::default(),
        }
    }

    /// Connects a clip.
    #[must_use]
    pub fn connect(mut self, clip: &str, input: Input) -> Self {
        self.inputs.insert(clip.to_owned(), input);
        self
    }

    /// Returns the input of a clip.
    pub(crate) fn input(&self, clip: &str) -> Input {
        self.inputs.get(clip).cloned().unwrap_or_default()
    }

    /// Returns the number of channels of a clip; 4 if it has no picture.
    pub(crate) fn channels(&self, clip: &str) -> usize {
        self.input(clip).picture(0.0).map_or(4, |p| p.channels)
    }

    /// Returns the number of channels of Output.
    pub(crate) fn output_channels(&self) -> usize {
        self.output.unwrap_or_else(|| self.channels("Source"))
    }

    /// Returns the bounds of a clip in pixels at full scale, if it has a picture.
    pub(crate) fn bounds(&self, clip: &str, time: f64) -> Option<Rect> {
        self.input(clip).picture(time).map(|p| p.bounds)
    }

    /// Returns the region of definition of a clip, if it has a picture.
    #[must_use]
    pub fn region(&self, clip: &str, time: f64) -> Option<Region> {
        self.bounds(clip, time)
            .map(|bounds| Region::from_pixels(&bounds, (1.0, 1.0), self.par))
    }
}

/// Returns the OpenFX components with so many channels.
pub(crate) fn components(channels: usize) -> &'static CStr {
    match channels {
        1 => kOfxImageComponentAlpha,
        3 => kOfxImageComponentRGB,
        4 => kOfxImageComponentRGBA,
        _ => kOfxImageComponentNone,
    }
}
