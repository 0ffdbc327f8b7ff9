//! The choice of the colour and alpha channels of a plate, one set for each view.

use super::pass_names::{beauty_source, is_other};
use super::passes::{ChannelPlace, Pass};

/// The user's choice among the views of a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum ViewChoice {
    /// All of them.
    #[default]
    All,
    /// The one of this name, in any case.
    Named(String),
}

/// The colour channels of one view, and why they were chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ColourChoice {
    /// Names of the colour channels without layer: R, G, B, or Y alone.
    pub(crate) names: Vec<&'static str>,
    /// In the order of `names`.
    pub(crate) colour: Vec<ChannelPlace>,
    pub(crate) alpha: Option<ChannelPlace>,
    pub(crate) view: Option<String>,
    /// The reason, where the file has other passes that could have been meant.
    pub(crate) reason: Option<String>,
    /// Index of the pass in the list of passes.
    pub(super) pass: usize,
}

/// The reason why no colour channels were chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum NoColour {
    /// No pass that could be the plate.
    Missing,
    /// Several passes are equally likely; the first channel of each.
    Several(Vec<ChannelPlace>),
    /// The view does not exist; those that do.
    NoView(Vec<String>),
}

/// Likelihood that a pass is the finished picture, the likeliest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    /// R, G, B without layer.
    Root,
    /// R, G, B of a layer with the name of a beauty pass.
    Beauty,
    /// The same within another layer.
    NestedBeauty,
    /// Y without layer, or of a beauty pass.
    GreyRoot,
    /// R, G, B of an unknown name, the only ones of their view.
    Unknown,
    /// Y of an unknown name.
    UnknownGrey,
}

/// Chooses the colour channels of each view: those of `layer`, or else of the finished picture.
pub(super) fn choose(
    passes: &[Pass],
    layer: Option<&str>,
    view: &ViewChoice,
) -> Result<Vec<ColourChoice>, NoColour> {
    let found = match layer {
        Some(layer) => of_layer(passes, layer),
        None => of_picture(passes),
    }?;
    match view {
        ViewChoice::All => Ok(found),
        ViewChoice::Named(name) => {
            let is_view = |own: &ColourChoice| {
                (own.view.as_deref()).is_some_and(|own| own.eq_ignore_ascii_case(name))
            };
            let views = found.iter().filter_map(|own| own.view.clone()).collect();
            let chosen: Vec<ColourChoice> = found.into_iter().filter(is_view).collect();
            if chosen.is_empty() {
                return Err(NoColour::NoView(views));
            }
            Ok(chosen)
        }
    }
}

/// Returns the names of the views that have colour.
pub(super) fn views(passes: &[Pass]) -> Vec<String> {
    let mut views: Vec<String> = Vec::new();
    for pass in passes.iter().filter(|pass| colour_of(pass, 0).is_some()) {
        let new = pass.view.iter().filter(|view| !views.contains(view));
        let new: Vec<String> = new.cloned().collect();
        views.extend(new);
    }
    views
}

/// Chooses the finished picture of each view.
fn of_picture(passes: &[Pass]) -> Result<Vec<ColourChoice>, NoColour> {
    let ranked: Vec<(Rank, ColourChoice)> = (passes.iter().enumerate())
        .filter_map(|(index, pass)| {
            let choice = colour_of(pass, index)?;
            Some((rank(pass, choice.names.len())?, choice))
        })
        .collect();
    let best = ranked.iter().map(|(rank, _)| *rank).min();
    let best = best.ok_or(NoColour::Missing)?;
    let others = passes
        .iter()
        .filter(|pass| colour_of(pass, 0).is_some())
        .count();
    let equal = ranked.into_iter().filter(|(rank, _)| *rank == best);
    let chosen = one_of_each_view(equal.map(|(_, choice)| choice).collect())?;
    if chosen.len() == others {
        return Ok(chosen);
    }
    let with_reason = |choice: ColourChoice| {
        let name = passes[choice.pass].name();
        let reason = match best {
            Rank::Root | Rank::GreyRoot if name.is_empty() => None,
            Rank::Root | Rank::Beauty | Rank::NestedBeauty | Rank::GreyRoot => {
                beauty_source(name).map(|source| format!("a beauty pass by the names of {source}"))
            }
            Rank::Unknown | Rank::UnknownGrey => {
                Some("the only colour that is not named as another pass".to_owned())
            }
        };
        ColourChoice { reason, ..choice }
    };
    Ok(chosen.into_iter().map(with_reason).collect())
}

/// Returns the likelihood that `pass`, of so many colours, is the finished picture; `None` if it is another kind of pass.
fn rank(pass: &Pass, colours: usize) -> Option<Rank> {
    let is_grey = colours == 1;
    if pass.path.is_empty() {
        return Some(if is_grey { Rank::GreyRoot } else { Rank::Root });
    }
    if pass.path.iter().any(|layer| is_other(layer)) {
        return None;
    }
    let is_beauty = beauty_source(pass.name()).is_some();
    Some(match (is_beauty, is_grey) {
        (true, true) => Rank::GreyRoot,
        (true, false) if pass.parent().is_empty() => Rank::Beauty,
        (true, false) => Rank::NestedBeauty,
        (false, false) => Rank::Unknown,
        (false, true) => Rank::UnknownGrey,
    })
}

/// Chooses the passes that `layer` names: a part, a prefix, a layer of every view, a view, or a single channel.
fn of_layer(passes: &[Pass], layer: &str) -> Result<Vec<ColourChoice>, NoColour> {
    let all: Vec<ColourChoice> = (passes.iter().enumerate())
        .filter_map(|(index, pass)| colour_of(pass, index))
        .collect();
    let same = |a: &str| a.eq_ignore_ascii_case(layer);
    let is_full = |pass: &Pass| pass.full_names().iter().any(|name| name == layer);
    let is_layer = |pass: &Pass| same(&pass.path.join("."));
    let is_view = |pass: &Pass| pass.view.as_deref().is_some_and(same);
    let is_innermost = |pass: &Pass| same(pass.name());
    let is_full_in_any_case = |pass: &Pass| pass.full_names().iter().any(|name| same(name));
    let tests: [&dyn Fn(&Pass) -> bool; 4] =
        [&is_full, &is_layer, &is_full_in_any_case, &is_innermost];
    for test in tests {
        let mut named: Vec<ColourChoice> = all
            .iter()
            .filter(|own| test(&passes[own.pass]))
            .cloned()
            .collect();
        if named.is_empty() {
            continue;
        }
        // A name without a view means this layer in every view.
        let first = &passes[named[0].pass];
        if named.len() == 1 && !first.names_its_view(layer) {
            let twins = all.iter().filter(|own| {
                let pass = &passes[own.pass];
                pass.view != first.view && pass.path == first.path
            });
            let twins: Vec<ColourChoice> = twins.cloned().collect();
            named.extend(twins);
            named.sort_by_key(|own| own.pass);
        }
        return one_of_each_view(named);
    }
    if let Some(single) = single_channel(passes, layer) {
        return Ok(vec![single]);
    }
    let of_view: Vec<Pass> = passes
        .iter()
        .filter(|pass| is_view(pass))
        .cloned()
        .collect();
    let mut chosen = of_picture(&of_view)?;
    for choice in &mut chosen {
        let pass = &of_view[choice.pass];
        let is_it = |own: &Pass| own.part == pass.part && own.prefix == pass.prefix;
        choice.pass = passes.iter().position(is_it).unwrap_or(0);
    }
    Ok(chosen)
}

/// Returns `choices` if each view has one of them.
fn one_of_each_view(choices: Vec<ColourChoice>) -> Result<Vec<ColourChoice>, NoColour> {
    let is_repeated = |(index, own): (usize, &ColourChoice)| {
        choices[..index].iter().any(|other| other.view == own.view)
    };
    if !choices.iter().enumerate().any(is_repeated) {
        return Ok(choices);
    }
    let firsts = choices.iter().map(|choice| choice.colour[0]);
    Err(NoColour::Several(firsts.collect()))
}

fn single_channel(passes: &[Pass], name: &str) -> Option<ColourChoice> {
    let (pass, index) = passes.iter().enumerate().find_map(|(index, pass)| {
        let own = pass.components.iter().find(|(component, _)| {
            pass.full_names().iter().any(|layer| match layer.as_str() {
                "" => component == name,
                layer => [".", ":"]
                    .iter()
                    .any(|dot| format!("{layer}{dot}{component}") == name),
            })
        })?;
        Some((index, own.1))
    })?;
    Some(ColourChoice {
        names: vec!["Y"],
        colour: vec![passes[pass].place(index)],
        alpha: None,
        view: passes[pass].view.clone(),
        reason: None,
        pass,
    })
}

/// Returns R, G, B (and A), or Y, of a pass. Luminance with chroma is not monochrome.
fn colour_of(pass: &Pass, index: usize) -> Option<ColourChoice> {
    let find = |name: &str| pass.component(name).map(|channel| pass.place(channel));
    let all = |names: [&str; 3]| names.map(find).into_iter().collect::<Option<Vec<_>>>();
    let rgb = all(["R", "G", "B"]).or_else(|| all(["red", "green", "blue"]));
    let (names, colour) = match rgb {
        Some(colour) => (vec!["R", "G", "B"], colour),
        None if find("RY").or_else(|| find("BY")).is_some() => return None,
        // X, Y and Z are a vector.
        None if find("X").is_some() => return None,
        None => (vec!["Y"], vec![find("Y")?]),
    };
    Some(ColourChoice {
        names,
        colour,
        alpha: find("A").or_else(|| find("alpha")),
        view: pass.view.clone(),
        reason: None,
        pass: index,
    })
}
