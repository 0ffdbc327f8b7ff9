//! What the clips of an instance are connected to.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::image_effect_v1::image_effect::*;

use crate::picture::{Picture, Rect, Region};

/// What a clip gives when it is asked for an image.
#[derive(Clone, Debug, Default)]
pub enum Feed {
    /// It is not connected.
    #[default]
    Unconnected,
    /// Pictures, one a frame, over and over.
    Pictures(Vec<Arc<Picture>>),
    /// It is connected, and asking for an image fails.
    Fails,
    /// It is connected, and asking succeeds without an image.
    NullHandle,
    /// It is connected, and its images have no data.
    NullData,
}

/// What one clip is connected to.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// What it gives.
    pub feed: Feed,
    /// How its samples stand to its alpha; nothing: premultiplied.
    pub premultiplication: Option<&'static CStr>,
}

impl Input {
    /// The same picture at all times.
    #[must_use]
    pub fn still(picture: Picture) -> Self {
        Self::of(Feed::Pictures(vec![Arc::new(picture)]))
    }

    /// A feed.
    #[must_use]
    pub fn of(feed: Feed) -> Self {
        Self {
            feed,
            premultiplication: None,
        }
    }

    /// The picture at a time.
    pub(crate) fn picture(&self, time: f64) -> Option<Arc<Picture>> {
        match &self.feed {
            Feed::Pictures(all) if !all.is_empty() => {
                let at = (time.round() as i64).rem_euclid(all.len() as i64);
                all.get(at as usize).cloned()
            }
            _ => None,
        }
    }
}

/// Clips and the project they are in.
#[derive(Clone, Debug)]
pub struct Scene {
    /// By the name of the clip.
    pub inputs: BTreeMap<String, Input>,
    /// The project's frame.
    pub project: Region,
    /// Width of a pixel over its height.
    pub par: f64,
    /// Means of how many pixels a side the pictures are: 2 at half scale.
    pub reduced: i32,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            inputs: BTreeMap::new(),
            project: Region::new(0.0, 0.0, 1.0, 1.0),
            par: 1.0,
            reduced: 1,
        }
    }
}

impl Scene {
    /// One picture as Source, which fills the project.
    #[must_use]
    pub fn of(source: Picture) -> Self {
        Self::with_par(source, 1.0)
    }

    /// The same of pixels that are not square.
    #[must_use]
    pub fn with_par(source: Picture, par: f64) -> Self {
        let project = Region::of(&source.bounds, (1.0, 1.0), par);
        Self {
            inputs: BTreeMap::from([("Source".to_owned(), Input::still(source))]),
            project,
            par,
            reduced: 1,
        }
    }

    /// With a clip connected otherwise.
    #[must_use]
    pub fn and(mut self, clip: &str, input: Input) -> Self {
        self.inputs.insert(clip.to_owned(), input);
        self
    }

    /// What a clip is connected to.
    pub(crate) fn input(&self, clip: &str) -> Input {
        self.inputs.get(clip).cloned().unwrap_or_default()
    }

    /// Where a clip has pixels, in pixels at full scale.
    pub(crate) fn bounds(&self, clip: &str, time: f64) -> Option<Rect> {
        self.input(clip).picture(time).map(|p| p.bounds)
    }

    /// Where a clip has pixels.
    #[must_use]
    pub fn region(&self, clip: &str, time: f64) -> Option<Region> {
        self.bounds(clip, time)
            .map(|bounds| Region::of(&bounds, (1.0, 1.0), self.par))
    }

    /// Components of so many channels.
    pub(crate) fn components(channels: usize) -> &'static CStr {
        match channels {
            1 => kOfxImageComponentAlpha,
            3 => kOfxImageComponentRGB,
            4 => kOfxImageComponentRGBA,
            _ => kOfxImageComponentNone,
        }
    }
}
