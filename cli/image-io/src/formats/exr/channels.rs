//! The colour, alpha and depth channels of an OpenEXR file in memory.

use super::image::{ChannelId, ChannelInfo, ExrImage};
use super::selection::{
    ChannelPlace, ColourChoice, DepthChoice, NoColour, NoDepth, PartNames, Selection, ViewChoice,
};
use crate::error::{FileError, Result};

/// The colour and alpha channels of one layer and view, all of one part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColourChannels {
    /// Names of the colour channels without layer, as in a lens: R, G, B, or Y alone.
    pub names: Vec<String>,
    /// The colour channels, in the order of `names`.
    pub colour: Vec<ChannelId>,
    /// The alpha channel of the layer, if it has one.
    pub alpha: Option<ChannelId>,
    /// One alpha channel for each colour channel, in the order of `names`; empty unless requested.
    pub channel_alphas: Vec<ChannelId>,
    /// The view, such as an eye, if the file states it.
    pub view: Option<String>,
    /// Why these channels were chosen, where others could have been.
    pub reason: Option<String>,
}

impl ColourChannels {
    fn new(choice: ColourChoice) -> Self {
        Self {
            names: choice.names.iter().map(|&name| name.to_owned()).collect(),
            colour: choice.colour.into_iter().map(ChannelId::from).collect(),
            alpha: choice.alpha.map(ChannelId::from),
            channel_alphas: Vec::new(),
            view: choice.view,
            reason: choice.reason,
        }
    }

    /// Returns the colour and alpha channels.
    pub(crate) fn all(&self) -> Vec<ChannelId> {
        let alphas = self.alpha.iter().chain(&self.channel_alphas);
        self.colour.iter().chain(alphas).copied().collect()
    }
}

/// The colour that a depth channel belongs to.
#[derive(Debug, Clone, Copy, Default)]
pub enum DepthOwner<'a> {
    /// The colour of the same file, by its first channel.
    Colour(ChannelId),
    /// The colour of another file, by its view.
    View(&'a str),
    /// A colour whose view is not known.
    #[default]
    Unknown,
}

impl<'a> DepthOwner<'a> {
    fn parts(self) -> (Option<ChannelPlace>, Option<&'a str>) {
        match self {
            Self::Colour(id) => (Some(id.place()), None),
            Self::View(view) => (None, Some(view)),
            Self::Unknown => (None, None),
        }
    }
}

impl ExrImage {
    fn selection(&self) -> Selection {
        let mut parts: Vec<PartNames> = (self.part_attributes())
            .map(|attributes| PartNames::new(attributes, Vec::new()))
            .collect();
        for channel in self.channels() {
            parts[channel.id.part()].channels.push(channel.name);
        }
        Selection::new(&parts)
    }

    /// Returns the colour channels of the first view: the root `R`, `G`, `B` (with `A`), those of a layer or part with the name
    /// of a beauty pass, or `Y` of a monochrome image.
    ///
    /// With `layer` those of the part of that name, those whose names begin with `layer` and a dot, or the single
    /// channel of that full name.
    ///
    /// # Errors
    /// No such channels, or several that could be meant; the message lists them.
    pub fn colour(&self, layer: Option<&str>) -> Result<ColourChannels> {
        Ok(self.colour_views(layer, &ViewChoice::All)?.remove(0))
    }

    /// Returns the colour channels of each chosen view, at least one.
    ///
    /// # Errors
    /// Those of [`ExrImage::colour`], and a view that does not exist.
    pub fn colour_views(
        &self,
        layer: Option<&str>,
        view: &ViewChoice,
    ) -> Result<Vec<ColourChannels>> {
        let found = self.selection().colour(layer, view);
        let found = found.map_err(|problem| self.no_colour(layer, view, problem))?;
        Ok(found.into_iter().map(ColourChannels::new).collect())
    }

    /// Returns the names of the views that have colour, in the order of the file.
    pub(crate) fn view_names(&self) -> Vec<String> {
        self.selection().views()
    }

    fn no_colour(&self, layer: Option<&str>, view: &ViewChoice, problem: NoColour) -> FileError {
        let (problem, remedy) = match problem {
            NoColour::Missing => {
                let (what, remedy) = match layer {
                    None => (
                        "has neither R, G, B nor Y of a known name".to_owned(),
                        "name the layer to blur with --layer",
                    ),
                    Some(layer) => (
                        format!("has no R, G, B or Y in a layer `{layer}`"),
                        "name one of its layers with --layer",
                    ),
                };
                (
                    format!("{what}; it has {}", self.channel_list()),
                    remedy.to_owned(),
                )
            }
            NoColour::Several(channels) => (
                format!("may be the plate: {}", self.full_names(&channels)),
                "name the part or layer to blur with --layer".to_owned(),
            ),
            NoColour::NoView(views) => {
                let name = match view {
                    ViewChoice::Named(name) => name,
                    ViewChoice::All => "all",
                };
                let has = match views.as_slice() {
                    [] => "names no views".to_owned(),
                    views => format!("has the views {}", views.join(", ")),
                };
                (
                    format!("has no view `{name}`; it {has}"),
                    "give --view one of these names, or leave it out".to_owned(),
                )
            }
        };
        FileError::new(self.path(), "channels", problem, remedy)
    }

    /// Returns the colour channels of each view with an alpha channel for each colour: `alpha.R` and so on in the part and layer
    /// of `A`. Missing ones are added as copies of `A`.
    ///
    /// # Errors
    /// Those of [`ExrImage::colour_views`], and colour without alpha.
    pub fn colour_with_channel_alphas(
        &mut self,
        layer: Option<&str>,
        view: &ViewChoice,
    ) -> Result<Vec<ColourChannels>> {
        let count = self.colour_views(layer, view)?.len();
        let mut alphas = Vec::new();
        for index in 0..count {
            // Channels were added for the views before, so old ids are invalid.
            let group = self.colour_views(layer, view)?.remove(index);
            let Some(alpha) = group.alpha else {
                return Err(FileError::new(
                    self.path(),
                    "channel A",
                    "is not in the plate, so the colours can have no alpha channels of their own",
                    "leave out --alpha-per-channel, or render the plate with alpha",
                ));
            };
            let name = self.channel_name(alpha);
            // Without the final A.
            let prefix = &name[..name.rfind('.').map_or(0, |dot| dot + 1)];
            let of_colour = |colour: &String| format!("{prefix}alpha.{colour}");
            let names: Vec<String> = group.names.iter().map(of_colour).collect();
            self.duplicate_channel(alpha, &names);
            alphas.push((alpha.part(), names));
        }
        let mut groups = self.colour_views(layer, view)?;
        let channels = self.channels();
        for (group, (part, names)) in groups.iter_mut().zip(alphas) {
            let find = |name: &String| {
                let of_part = |c: &&ChannelInfo| c.id.part() == part && c.name == *name;
                channels.iter().find(of_part).map(|c| c.id)
            };
            group.channel_alphas = names.iter().filter_map(find).collect();
        }
        Ok(groups)
    }

    /// Returns the depth channel that belongs to `owner`: the one called `name`, or else the one that its name, its layer or its
    /// part shows to be depth, of the same part, view or prefix first.
    ///
    /// # Errors
    /// No such channel, or several that could be meant; the message lists them.
    pub fn depth_channel(&self, name: Option<&str>, owner: DepthOwner) -> Result<ChannelId> {
        let (colour, view) = owner.parts();
        let selection = self.selection();
        let is_equal = |a: ChannelPlace, b: ChannelPlace| {
            let bits = |place: ChannelPlace| self.samples(place.into());
            self.data_window(a.into()) == self.data_window(b.into())
                && (bits(a).iter().zip(&bits(b))).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        let found = match name {
            Some(name) => selection.named_depth(name, colour, view, &is_equal),
            None => selection
                .depth(colour, view, &is_equal)
                .map(|choice| choice.place),
        };
        found
            .map(ChannelId::from)
            .map_err(|problem| self.no_depth(name, problem))
    }

    /// Returns the names of channels that may be depth of the colour too, and differ from the depth channel that belongs to it.
    pub(crate) fn other_depths(&self, colour: ChannelId) -> String {
        let choice = self
            .selection()
            .depth(Some(colour.place()), None, &|_, _| true);
        let Ok(DepthChoice { place, others }) = choice else {
            return String::new();
        };
        let chosen = self.samples(place.into());
        let differs = |other: &ChannelPlace| self.samples((*other).into()) != chosen;
        let others: Vec<ChannelPlace> = others.into_iter().filter(differs).collect();
        self.full_names(&others)
    }

    fn no_depth(&self, name: Option<&str>, problem: NoDepth) -> FileError {
        let list = || format!("it has {}", self.channel_list());
        let problem = match (problem, name) {
            (NoDepth::Several(channels), Some(name)) => format!(
                "has several channels `{name}`, which differ: {}",
                self.full_names(&channels)
            ),
            (NoDepth::Several(channels), None) => {
                format!("may be any of {}, which differ", self.full_names(&channels))
            }
            (NoDepth::OtherViews(view), _) => {
                format!("has no depth of the view `{view}`; {}", list())
            }
            (NoDepth::NotNamed | NoDepth::Missing, Some(name)) => {
                format!("has no channel `{name}`; {}", list())
            }
            (NoDepth::NotNamed | NoDepth::Missing, None) => format!(
                "has no channel, layer or part with a name of depth (such as Z, depth.Z, depth); {}",
                list()
            ),
        };
        FileError::new(
            self.path(),
            "depth",
            problem,
            "name the depth channel after the file and a colon, such as plate.exr:depth.Z",
        )
    }

    fn full_names(&self, places: &[ChannelPlace]) -> String {
        let channels = self.channels();
        let of_place = |place: &ChannelPlace| {
            let id = ChannelId::from(*place);
            let own = channels.iter().find(|own| own.id == id).cloned();
            own.map(|own| self.full_name(own))
        };
        let names: Vec<String> = places.iter().filter_map(of_place).collect();
        names.join(", ")
    }
}
