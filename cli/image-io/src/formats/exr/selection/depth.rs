//! The choice of the depth channel that belongs to the colour of a plate.

use super::pass_names::{beauty_source, depth_source, is_other, resembles_depth};
use super::passes::{ChannelPlace, Pass};

/// The reason why no depth channel was chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum NoDepth {
    /// No channel that could be depth.
    Missing,
    /// Depth exists in other views than this one.
    OtherViews(String),
    /// Several channels that differ are equally likely.
    Several(Vec<ChannelPlace>),
    /// No channel has the name that was given.
    NotNamed,
}

/// A depth channel, and why it was chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DepthChoice {
    pub(crate) place: ChannelPlace,
    /// The other channels of the file that may be depth of the same view.
    pub(crate) others: Vec<ChannelPlace>,
}

/// The colour whose depth is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct DepthContext<'a> {
    /// The pass of the colour; `None` in a file of depth alone.
    pub(super) colour: Option<&'a Pass>,
    /// The view of the plate.
    pub(super) view: Option<&'a str>,
}

/// Closeness of a depth channel to the colour, the closest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Closeness {
    /// In the same part and layer.
    SamePass,
    /// In a layer of the colour's own.
    Child,
    /// In a layer beside that of the colour.
    Sibling,
    /// In another layer that is named depth.
    Elsewhere,
    /// In a layer whose name contains "depth".
    Resembling,
}

/// A channel that may be depth.
struct Candidate {
    place: ChannelPlace,
    view: Option<String>,
    closeness: Closeness,
}

/// Chooses the depth channel of `context`. `is_equal` tells whether two channels hold the same samples.
pub(super) fn choose(
    passes: &[Pass],
    context: DepthContext,
    is_equal: &dyn Fn(ChannelPlace, ChannelPlace) -> bool,
) -> Result<DepthChoice, NoDepth> {
    let candidates = passes.iter().flat_map(|pass| candidates(pass, context));
    let candidates: Vec<Candidate> = candidates.collect();
    let candidates = of_view(passes, candidates, context.view)?;
    let Some(best) = candidates.iter().map(|own| own.closeness).min() else {
        return Err(NoDepth::Missing);
    };
    let (equal, others): (Vec<_>, Vec<_>) = candidates
        .into_iter()
        .partition(|own| own.closeness == best);
    let places: Vec<ChannelPlace> = equal.into_iter().map(|own| own.place).collect();
    if places[1..].iter().any(|&other| !is_equal(places[0], other)) {
        return Err(NoDepth::Several(places));
    }
    Ok(DepthChoice {
        place: places[0],
        others: others.into_iter().map(|own| own.place).collect(),
    })
}

/// Keeps the candidates of a view: those that state it, or else those that state none, in a file with one view at most.
fn of_view(
    passes: &[Pass],
    candidates: Vec<Candidate>,
    view: Option<&str>,
) -> Result<Vec<Candidate>, NoDepth> {
    let same = |a: Option<&str>| match (a, view) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        (a, b) => a == b,
    };
    let of_this = candidates.iter().any(|own| same(own.view.as_deref()));
    let mut views: Vec<&str> = passes
        .iter()
        .filter_map(|pass| pass.view.as_deref())
        .collect();
    views.dedup();
    let has_several_views = views
        .iter()
        .any(|other| !other.eq_ignore_ascii_case(views[0]));
    if of_this {
        let own = candidates
            .into_iter()
            .filter(|own| same(own.view.as_deref()));
        return Ok(own.collect());
    }
    match view {
        Some(view) if has_several_views && !candidates.is_empty() => {
            Err(NoDepth::OtherViews(view.to_owned()))
        }
        _ => Ok(candidates),
    }
}

/// Returns the channels of a pass that may be depth.
fn candidates(pass: &Pass, context: DepthContext) -> Vec<Candidate> {
    if is_vector(pass) {
        return Vec::new();
    }
    let candidate = |channel: usize, closeness| Candidate {
        place: pass.place(channel),
        view: pass.view.clone(),
        closeness,
    };
    let is_own = (context.colour)
        .is_some_and(|colour| (colour.part, &colour.prefix) == (pass.part, &pass.prefix));
    if let Some(channel) = of_depth_layer(pass) {
        let closeness = closeness(&pass.path, context, depth_source(pass.name()).is_some());
        return vec![candidate(channel, closeness)];
    }
    let holds_colour = pass.path.is_empty() || is_own || beauty_source(pass.name()).is_some();
    let components = pass.components.iter().filter_map(|(name, channel)| {
        if is_colour_component(name) || depth_source(name).is_none() {
            return None;
        }
        // Any layer may have a Z that is no depth of the plate.
        if name.eq_ignore_ascii_case("z") && !holds_colour {
            return None;
        }
        let mut path = pass.path.clone();
        path.push(name.clone());
        let closeness = match name.as_str() {
            "Z" | "z" if is_own => Closeness::SamePass,
            _ if pass.path.is_empty() || beauty_source(pass.name()).is_none() => {
                closeness(&path, context, true)
            }
            // Beside R, G and B of a part `rgba` as beside those of the root.
            _ => closeness(&path[path.len() - 1..], context, true),
        };
        Some(candidate(*channel, closeness))
    });
    components.collect()
}

/// Returns whether the components of a pass are those of a vector, such as a normal or a position.
fn is_vector(pass: &Pass) -> bool {
    let has = |name: &str| pass.component(name).is_some();
    let is_other_pass = is_other(pass.name())
        && depth_source(pass.name()).is_none()
        && !resembles_depth(pass.name());
    has("X") && (has("Y") || has("Z")) || is_other_pass
}

fn is_colour_component(name: &str) -> bool {
    let colours = ["r", "g", "b", "a", "y", "red", "green", "blue", "alpha"];
    colours
        .iter()
        .any(|colour| name.eq_ignore_ascii_case(colour))
}

/// Returns the channel of depth in a layer or part that is named so.
fn of_depth_layer(pass: &Pass) -> Option<usize> {
    if depth_source(pass.name()).is_none() && !resembles_depth(pass.name()) {
        return None;
    }
    let names = ["Z", "depth", "Pz", "V", "Y", "R", "red", "D", "distance"];
    let named = names.iter().find_map(|name| pass.component(name));
    match pass.components.as_slice() {
        [(_, only)] => Some(*only),
        _ => named,
    }
}

fn closeness(path: &[String], context: DepthContext, has_known_name: bool) -> Closeness {
    if !has_known_name {
        return Closeness::Resembling;
    }
    let parent = &path[..path.len().saturating_sub(1)];
    match context.colour {
        Some(colour) if !colour.path.is_empty() && parent == colour.path => Closeness::Child,
        Some(colour) if parent == colour.parent() => Closeness::Sibling,
        None if parent.is_empty() => Closeness::Sibling,
        _ => Closeness::Elsewhere,
    }
}

/// Finds the channels that a user may call `name`: a full name, `part:channel` or `part.channel`, exactly, else in any case;
/// else the depth channel of a part or layer of that name.
pub(super) fn named(passes: &[Pass], name: &str) -> Vec<ChannelPlace> {
    let find = |same: fn(&str, &str) -> bool| -> Vec<ChannelPlace> {
        let of_pass = |pass: &Pass| -> Vec<ChannelPlace> {
            let matches = pass.components.iter().filter(|(component, _)| {
                let full = match pass.prefix.as_str() {
                    "" => component.clone(),
                    prefix => format!("{prefix}.{component}"),
                };
                let part = pass.part_name.as_deref();
                same(&full, name)
                    || part.is_some_and(|part| {
                        same(&format!("{part}:{full}"), name)
                            || same(&format!("{part}.{full}"), name)
                    })
            });
            matches.map(|(_, channel)| pass.place(*channel)).collect()
        };
        passes.iter().flat_map(of_pass).collect()
    };
    let exact = find(|a, b| a == b);
    if !exact.is_empty() {
        return exact;
    }
    let any_case = find(str::eq_ignore_ascii_case);
    if !any_case.is_empty() {
        return any_case;
    }
    let layers = passes.iter().filter(|pass| {
        let names = pass.full_names();
        names.iter().any(|own| own.eq_ignore_ascii_case(name))
    });
    let depth = layers.filter_map(|pass| {
        let only = match pass.components.as_slice() {
            [(_, only)] => Some(*only),
            _ => of_depth_layer(pass),
        };
        only.map(|channel| pass.place(channel))
    });
    depth.collect()
}
