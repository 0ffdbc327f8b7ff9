//! The panel of a plugin's parameters, in the order in which a host shows them.

use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::param::*;

use crate::host::effect::{Effect, Parameter, ParameterSet};
use crate::host::profile::Profile;

/// A row of a panel: a group or a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The name of the parameter.
    pub name: String,
    /// Its label.
    pub label: String,
    /// The group that it is in.
    pub group: Option<String>,
    /// Its state and range, as far as a panel shows them.
    pub details: String,
}

/// Returns the rows of the first page of a descriptor, of all parameters if it has no page, without hidden ones.
#[must_use]
pub fn panel(descriptor: &Effect, host: &Profile) -> Vec<Row> {
    let mut all = descriptor.parameters.all();
    let pages = pages(&descriptor.parameters);
    let mut names: Vec<String> = match pages.first() {
        Some(page) => page.properties.texts(kOfxParamPropPageChild),
        None => all.iter().map(|one| one.name.clone()).collect(),
    };
    if host.appends_unlisted_groups {
        let groups = all.iter().filter(|one| is_group(one));
        let groups: Vec<_> = groups.map(|one| one.name.clone()).collect();
        let unlisted = groups.into_iter().filter(|name| !names.contains(name));
        names.extend(unlisted.collect::<Vec<_>>());
    }
    let place_of = |name: &str| names.iter().position(|listed| listed == name);
    all.retain(|one| {
        place_of(&one.name).is_some() && one.properties.int(kOfxParamPropSecret) != Some(1)
    });
    // A host shows a parameter where its group stands.
    all.sort_by_key(|one| {
        let own = place_of(&one.name);
        match group_of(one).and_then(|group| place_of(&group)) {
            Some(group) => (Some(group), own.map(|own| own + 1)),
            None => (own, None),
        }
    });
    all.iter().map(|one| row(one)).collect()
}

/// Returns the pages.
pub(crate) fn pages(all: &ParameterSet) -> Vec<Arc<Parameter>> {
    let mut pages = all.all();
    pages.retain(|one| one.kind.as_c_str() == kOfxParamTypePage);
    pages
}

/// Returns whether a parameter is a group.
pub(crate) fn is_group(parameter: &Parameter) -> bool {
    parameter.kind.as_c_str() == kOfxParamTypeGroup
}

/// Returns the name of the group that a parameter is in.
pub(crate) fn group_of(parameter: &Parameter) -> Option<String> {
    let parents = parameter.properties.texts(kOfxParamPropParent);
    parents.into_iter().find(|parent| !parent.is_empty())
}

fn row(parameter: &Parameter) -> Row {
    let set = &parameter.properties;
    let mut details = Vec::new();
    if is_group(parameter) && set.int(kOfxParamPropGroupOpen) == Some(0) {
        details.push("closed".to_owned());
    }
    let ends = [
        kOfxParamPropDisplayMin,
        kOfxParamPropDisplayMax,
        kOfxParamPropDefault,
    ];
    if let [Some(low), Some(high), Some(default)] =
        ends.map(|end| set.doubles(end).first().copied())
    {
        details.push(format!("{low} to {high}, default {default}"));
    }
    let options = set.texts(kOfxParamPropChoiceOption);
    if !options.is_empty() {
        details.push(options.join(" | "));
    }
    let labels = set.texts(kOfxPropLabel);
    Row {
        name: parameter.name.clone(),
        label: labels.into_iter().next().unwrap_or_default(),
        group: group_of(parameter),
        details: details.join(", "),
    }
}

/// Returns a panel as text, a line a row.
#[must_use]
pub fn text(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        let indent = if row.group.is_some() { "    " } else { "" };
        let label = format!("{indent}{}", row.label);
        format!("{label:<32}{}", row.details).trim_end().to_owned()
    });
    lines.collect::<Vec<_>>().join("\n")
}
