//! Selection of the colour, alpha and depth channels of an OpenEXR file.

use super::image::{ChannelId, ChannelInfo, ExrImage};
use crate::error::{FileError, Result};

/// The colour and alpha channels of one layer, all of one part.
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
}

impl ColourChannels {
    /// Returns the colour and alpha channels.
    pub(crate) fn all(&self) -> Vec<ChannelId> {
        let alphas = self.alpha.iter().chain(&self.channel_alphas);
        self.colour.iter().chain(alphas).copied().collect()
    }
}

/// Names of depth channels, the preferred first; case does not matter.
const DEPTH_NAMES: [&str; 4] = ["Z", "depth.Z", "depth", "depth.V"];

/// Names of the main part of a multi-part file.
const MAIN_PARTS: [&str; 5] = ["rgba", "rgb", "beauty", "main", "C"];

impl ExrImage {
    /// Returns the colour channels: the root `R`, `G`, `B` (with `A`), or `Y` of a monochrome image.
    ///
    /// With `layer` those of the part of that name, those whose names begin with `layer` and a dot, or the single
    /// channel of that full name.
    ///
    /// # Errors
    /// No such channels; the message lists the existing ones.
    pub fn colour(&self, layer: Option<&str>) -> Result<ColourChannels> {
        let channels = self.channels();
        let found = match layer {
            None => {
                let mut parts: Vec<usize> = (0..self.parts()).collect();
                // A stable sort, so that the first part wins otherwise.
                parts.sort_by_key(|&part| !self.is_main(part));
                parts
                    .iter()
                    .find_map(|&part| find_colour(&channels, part, ""))
            }
            Some(layer) => self.layer_group(&channels, layer),
        };
        found.ok_or_else(|| {
            let (what, remedy) = match layer {
                None => (
                    "has neither R, G, B nor Y".to_owned(),
                    "name the layer to blur with --layer",
                ),
                Some(layer) => (
                    format!("has no R, G, B or Y in a layer `{layer}`"),
                    "name one of its layers with --layer",
                ),
            };
            FileError::new(
                self.path(),
                "channels",
                format!("{what}; it has {}", self.channel_list()),
                remedy,
            )
        })
    }

    /// Returns the colour channels with an alpha channel for each: `alpha.R` and so on in the part and layer of `A`.
    /// Missing ones are added as copies of `A`.
    ///
    /// # Errors
    /// Those of [`ExrImage::colour`], and colour without alpha.
    pub fn colour_with_channel_alphas(&mut self, layer: Option<&str>) -> Result<ColourChannels> {
        let group = self.colour(layer)?;
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
        let prefix = &name[..name.len() - 1];
        let of_colour = |colour: &String| format!("{prefix}alpha.{colour}");
        let names: Vec<String> = group.names.iter().map(of_colour).collect();
        self.duplicate_channel(alpha, &names);
        // Channels were added, so old ids are invalid.
        let mut group = self.colour(layer)?;
        let channels = self.channels();
        let find = |name: &String| {
            let of_part = |c: &&ChannelInfo| c.id.part() == alpha.part() && c.name == *name;
            channels.iter().find(of_part).map(|c| c.id)
        };
        group.channel_alphas = names.iter().filter_map(find).collect();
        Ok(group)
    }

    fn is_main(&self, part: usize) -> bool {
        self.part_name(part)
            .is_some_and(|name| MAIN_PARTS.iter().any(|m| m.eq_ignore_ascii_case(&name)))
    }

    fn layer_group(&self, channels: &[ChannelInfo], layer: &str) -> Option<ColourChannels> {
        let dotted = format!("{layer}.");
        let by_part = (0..self.parts())
            .filter(|&part| self.part_name(part).as_deref() == Some(layer))
            .find_map(|part| {
                find_colour(channels, part, "").or_else(|| find_colour(channels, part, &dotted))
            });
        by_part
            .or_else(|| (0..self.parts()).find_map(|part| find_colour(channels, part, &dotted)))
            .or_else(|| {
                let single = channels.iter().find(|c| c.name == layer)?;
                Some(ColourChannels {
                    names: vec!["Y".to_owned()],
                    colour: vec![single.id],
                    alpha: None,
                    channel_alphas: Vec::new(),
                })
            })
    }

    /// Returns the depth channel: the one called `name`, or else the first of `Z`, `depth.Z`, `depth`, `depth.V` in any
    /// case, or the only channel of a part called `depth`.
    ///
    /// # Errors
    /// No such channel; the message lists the existing ones.
    pub fn depth_channel(&self, name: Option<&str>) -> Result<ChannelId> {
        let channels = self.channels();
        let found = match name {
            Some(name) => find_named(&channels, name),
            None => DEPTH_NAMES
                .iter()
                .find_map(|wanted| find_named(&channels, wanted))
                .or_else(|| only_channel_of_depth_part(&channels)),
        };
        found.ok_or_else(|| {
            let problem = match name {
                Some(name) => format!("has no channel `{name}`"),
                None => "has no channel with a name of depth (Z, depth.Z, depth)".to_owned(),
            };
            FileError::new(
                self.path(),
                "depth",
                format!("{problem}; it has {}", self.channel_list()),
                "name the depth channel after the file and a colon, such as plate.exr:depth.Z",
            )
        })
    }
}

/// Finds a channel by its full name, `part:channel` or `part.channel`: exactly, else in any case.
fn find_named(channels: &[ChannelInfo], name: &str) -> Option<ChannelId> {
    let same = |matches: fn(&str, &str) -> bool| {
        channels.iter().find(|c| {
            matches(&c.name, name)
                || c.part.as_ref().is_some_and(|part| {
                    matches(&format!("{part}:{}", c.name), name)
                        || matches(&format!("{part}.{}", c.name), name)
                })
        })
    };
    same(|a, b| a == b)
        .or_else(|| same(str::eq_ignore_ascii_case))
        .map(|c| c.id)
}

fn only_channel_of_depth_part(channels: &[ChannelInfo]) -> Option<ChannelId> {
    let depth: Vec<&ChannelInfo> = channels
        .iter()
        .filter(|c| {
            c.part
                .as_ref()
                .is_some_and(|p| p.eq_ignore_ascii_case("depth"))
        })
        .collect();
    match depth.as_slice() {
        [only] => Some(only.id),
        _ => None,
    }
}

/// Finds R, G, B (and A), or Y, in one part under one prefix. Luminance with chroma is not monochrome.
fn find_colour(channels: &[ChannelInfo], part: usize, prefix: &str) -> Option<ColourChannels> {
    let find = |name: &str| {
        let of_part = || channels.iter().filter(|c| c.id.part() == part);
        let stripped = |c: &&ChannelInfo| c.name.strip_prefix(prefix).map(str::to_owned);
        of_part()
            .find(|c| stripped(c).as_deref() == Some(name))
            .or_else(|| {
                of_part().find(|c| stripped(c).is_some_and(|n| n.eq_ignore_ascii_case(name)))
            })
            .map(|c| c.id)
    };
    let alpha = find("A");
    let named = |names: &[&str]| -> Option<ColourChannels> {
        Some(ColourChannels {
            names: names.iter().map(|&n| n.to_owned()).collect(),
            colour: names.iter().map(|n| find(n)).collect::<Option<_>>()?,
            alpha,
            channel_alphas: Vec::new(),
        })
    };
    named(&["R", "G", "B"])
        .or_else(|| {
            named(&["red", "green", "blue"]).map(|g| ColourChannels {
                names: ["R", "G", "B"].map(str::to_owned).to_vec(),
                ..g
            })
        })
        .or_else(|| {
            let has_chroma = find("RY").or_else(|| find("BY")).is_some();
            if has_chroma { None } else { named(&["Y"]) }
        })
}
