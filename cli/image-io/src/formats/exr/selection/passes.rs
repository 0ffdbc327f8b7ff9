//! The passes of a file: channels of one part with one prefix, and the layer and view that their names state.

use exr::prelude::LayerAttributes;

use crate::formats::exr::library_types::utf8;

/// The name of a part, its view and its channels, as the header states them.
#[derive(Debug, Clone, Default)]
pub(crate) struct PartNames {
    /// Name of the part, if it has one.
    pub(crate) name: Option<String>,
    /// The attribute `view`.
    pub(crate) view: Option<String>,
    /// The attribute `multiView`: views whose channels are distinguished by their names, the default view first.
    pub(crate) views: Vec<String>,
    /// Full names of the channels.
    pub(crate) channels: Vec<String>,
}

impl PartNames {
    pub(crate) fn new(attributes: &LayerAttributes, channels: Vec<String>) -> Self {
        let views = attributes.multi_view_names.iter().flatten();
        Self {
            name: attributes.layer_name.as_ref().map(utf8),
            view: attributes.view_name.as_ref().map(utf8),
            views: views.map(utf8).collect(),
            channels,
        }
    }
}

/// The place of a channel in a file: indices of its part, and of the channel in the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ChannelPlace {
    pub(crate) part: usize,
    pub(crate) channel: usize,
}

/// The channels of one part with one prefix.
#[derive(Debug, Clone)]
pub(super) struct Pass {
    /// Index of the part.
    pub(super) part: usize,
    /// Name of the part, if it has one.
    pub(super) part_name: Option<String>,
    /// The text before the last dot of the names; empty for root channels.
    pub(super) prefix: String,
    /// The layers that hold the channels, outermost first, by the names of part and channels, without view.
    pub(super) path: Vec<String>,
    pub(super) view: Option<String>,
    /// The text after the last dot, with the index in the part.
    pub(super) components: Vec<(String, usize)>,
}

impl Pass {
    /// Returns the name of the innermost layer; empty for root channels.
    pub(super) fn name(&self) -> &str {
        self.path.last().map_or("", String::as_str)
    }

    /// Returns the layers around the innermost one.
    pub(super) fn parent(&self) -> &[String] {
        &self.path[..self.path.len().saturating_sub(1)]
    }

    /// Returns the names by which a user may call the pass: its prefix, its part, or both.
    pub(super) fn full_names(&self) -> Vec<String> {
        let prefix = &self.prefix;
        let mut names = vec![prefix.clone()];
        if let Some(part) = &self.part_name {
            match prefix.as_str() {
                "" => names.push(part.clone()),
                prefix => names.extend([format!("{part}.{prefix}"), format!("{part}:{prefix}")]),
            }
        }
        names
    }

    /// Returns whether `name` states the view of the pass.
    pub(super) fn names_its_view(&self, name: &str) -> bool {
        let mut words = name.split(['.', '_', '-', ':']);
        (self.view.as_deref()).is_some_and(|view| words.any(|word| word.eq_ignore_ascii_case(view)))
    }

    /// Returns the index of the component `name`: exactly, else in any case.
    pub(super) fn component(&self, name: &str) -> Option<usize> {
        let find = |same: fn(&str, &str) -> bool| {
            let mut all = self.components.iter();
            all.find(|(own, _)| same(own, name))
                .map(|(_, index)| *index)
        };
        find(|a, b| a == b).or_else(|| find(str::eq_ignore_ascii_case))
    }

    /// Returns the place of the component at `index` of the part.
    pub(super) fn place(&self, index: usize) -> ChannelPlace {
        ChannelPlace {
            part: self.part,
            channel: index,
        }
    }
}

/// Returns the passes of a file, in the order of its parts and channels.
pub(super) fn passes(parts: &[PartNames]) -> Vec<Pass> {
    let views = view_names(parts);
    let mut passes: Vec<Pass> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let of_part = PartLayer::of(part, &views, parts.len() > 1);
        for (channel, full) in part.channels.iter().enumerate() {
            let (prefix, component) = full.rsplit_once('.').unwrap_or(("", full));
            let component = (component.to_owned(), channel);
            let own = passes
                .iter_mut()
                .find(|p| p.part == index && p.prefix == prefix);
            match own {
                Some(pass) => pass.components.push(component),
                None => passes.push(of_part.pass(index, prefix, component, &views)),
            }
        }
    }
    if parts.len() == 1 {
        name_default_view(&mut passes);
    }
    passes
}

/// The names of views that files use without stating them.
const USUAL_VIEWS: [&str; 2] = ["left", "right"];

fn view_names(parts: &[PartNames]) -> Vec<String> {
    let stated = parts
        .iter()
        .flat_map(|part| part.view.iter().chain(&part.views));
    stated
        .cloned()
        .chain(USUAL_VIEWS.map(str::to_owned))
        .collect()
}

fn find_view<'a>(views: &'a [String], name: &str) -> Option<&'a String> {
    views.iter().find(|view| view.eq_ignore_ascii_case(name))
}

/// The layer and view that the name of a part states for its channels.
struct PartLayer<'a> {
    name: Option<String>,
    path: Vec<String>,
    view: Option<&'a String>,
}

impl<'a> PartLayer<'a> {
    fn of(part: &'a PartNames, views: &'a [String], has_siblings: bool) -> Self {
        let name = part.name.as_deref().unwrap_or_default();
        let (layer, suffix) = split_view(name, views);
        let default = part.views.first();
        // The name of the only part says nothing about its channels.
        let path = if has_siblings {
            segments(layer)
        } else {
            Vec::new()
        };
        Self {
            name: part.name.clone(),
            path,
            view: part.view.as_ref().or(suffix).or(default),
        }
    }

    fn pass(
        &self,
        part: usize,
        prefix: &str,
        component: (String, usize),
        views: &[String],
    ) -> Pass {
        let mut path = segments(prefix);
        let own_view = path.iter().find_map(|segment| find_view(views, segment));
        path.retain(|segment| find_view(views, segment).is_none());
        let is_repeated = path.len() >= self.path.len()
            && (path.iter().zip(&self.path)).all(|(a, b)| a.eq_ignore_ascii_case(b));
        if !is_repeated {
            path.splice(0..0, self.path.iter().cloned());
        }
        Pass {
            part,
            part_name: self.name.clone(),
            prefix: prefix.to_owned(),
            path,
            view: own_view.or(self.view).cloned(),
            components: vec![component],
        }
    }
}

fn segments(name: &str) -> Vec<String> {
    let parts = name.split('.').filter(|part| !part.is_empty());
    parts.map(str::to_owned).collect()
}

/// Splits the name of a part into its layer and view: `rgba.left`, `rgba_left`, `left`, or Nuke's `rgba.main` of a file
/// with one view.
fn split_view<'a>(name: &'a str, views: &'a [String]) -> (&'a str, Option<&'a String>) {
    if let Some(view) = find_view(views, name) {
        return ("", Some(view));
    }
    let Some((layer, suffix)) = name.rsplit_once(['.', '_', '-']) else {
        return (name, None);
    };
    match find_view(views, suffix) {
        Some(view) => (layer, Some(view)),
        None if suffix.eq_ignore_ascii_case("main") => (layer, None),
        None => (name, None),
    }
}

/// Gives root channels beside those of one eye the view of the other eye, where the file does not name its views.
fn name_default_view(passes: &mut [Pass]) {
    let eye = |name: &str| {
        let of_eye = |pass: &&Pass| {
            pass.view
                .as_deref()
                .is_some_and(|v| v.eq_ignore_ascii_case(name))
        };
        passes.iter().any(|pass| of_eye(&pass))
    };
    let missing = match USUAL_VIEWS.map(eye) {
        [true, false] => USUAL_VIEWS[1],
        [false, true] => USUAL_VIEWS[0],
        _ => return,
    };
    for pass in passes.iter_mut().filter(|pass| pass.view.is_none()) {
        pass.view = Some(missing.to_owned());
    }
}
