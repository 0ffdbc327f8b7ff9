//! The choice of channels: which part, layer and view of an OpenEXR file are the colour, alpha and depth of a plate.
//!
//! The choice needs the names in the header alone, so that a description of the file and its use agree.

mod colour;
mod depth;
mod pass_names;
mod passes;

pub use self::colour::ViewChoice;
pub(crate) use self::colour::{ColourChoice, NoColour};
pub(crate) use self::depth::{DepthChoice, NoDepth};
pub(crate) use self::passes::{ChannelPlace, PartNames};

use self::depth::DepthContext;
use self::passes::Pass;

/// The passes of a file, to choose from.
#[derive(Debug, Clone)]
pub(crate) struct Selection {
    passes: Vec<Pass>,
}

impl Selection {
    pub(crate) fn new(parts: &[PartNames]) -> Self {
        Self {
            passes: passes::passes(parts),
        }
    }

    /// Chooses the colour channels of each view: those of `layer`, or else of the finished picture.
    pub(crate) fn colour(
        &self,
        layer: Option<&str>,
        view: &ViewChoice,
    ) -> Result<Vec<ColourChoice>, NoColour> {
        colour::choose(&self.passes, layer, view)
    }

    /// Returns the names of the views that have colour, in the order of the file.
    pub(crate) fn views(&self) -> Vec<String> {
        colour::views(&self.passes)
    }

    /// Chooses the depth channel that belongs to `colour`, or to `view` in a file of its own. `is_equal` tells whether two
    /// channels hold the same samples.
    pub(crate) fn depth(
        &self,
        colour: Option<ChannelPlace>,
        view: Option<&str>,
        is_equal: &dyn Fn(ChannelPlace, ChannelPlace) -> bool,
    ) -> Result<DepthChoice, NoDepth> {
        let colour = colour.and_then(|place| self.pass_of(place));
        let view = colour.map_or(view, |pass| pass.view.as_deref());
        depth::choose(&self.passes, DepthContext { colour, view }, is_equal)
    }

    /// Chooses the channel called `name`; among several of that name the one that belongs to `colour` or `view`.
    pub(crate) fn named_depth(
        &self,
        name: &str,
        colour: Option<ChannelPlace>,
        view: Option<&str>,
        is_equal: &dyn Fn(ChannelPlace, ChannelPlace) -> bool,
    ) -> Result<ChannelPlace, NoDepth> {
        let named = depth::named(&self.passes, name);
        let [first, others @ ..] = named.as_slice() else {
            return Err(NoDepth::NotNamed);
        };
        if others.iter().all(|&other| is_equal(*first, other)) {
            return Ok(*first);
        }
        let view = colour
            .and_then(|place| self.pass_of(place))
            .map_or(view, |pass| pass.view.as_deref());
        let of_view = named.iter().filter(|&&place| {
            view.is_some()
                && self
                    .pass_of(place)
                    .is_some_and(|pass| pass.view.as_deref() == view)
        });
        if let [only] = of_view.collect::<Vec<_>>()[..] {
            return Ok(*only);
        }
        match self.depth(colour, view, is_equal) {
            Ok(choice) if named.contains(&choice.place) => Ok(choice.place),
            _ => Err(NoDepth::Several(named)),
        }
    }

    fn pass_of(&self, place: ChannelPlace) -> Option<&Pass> {
        self.passes.iter().find(|pass| {
            let mut channels = pass.components.iter();
            pass.part == place.part && channels.any(|(_, channel)| *channel == place.channel)
        })
    }
}

#[cfg(test)]
mod tests;
