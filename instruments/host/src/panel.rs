//! The panel of a plugin's parameters, in the order in which a host shows them.

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

/// Returns the rows of the first page of a descriptor; without a page, all parameters in the order of their definition.
#[must_use]
pub fn panel(descriptor: &Effect, host: &Profile) -> Vec<Row> {
    let all = &descriptor.parameters;
    let Some(page) = pages(all).into_iter().next() else {
        let rows = all.all().into_iter();
        return rows.map(|parameter| row(&parameter)).collect();
    };
    let mut names = page.properties.texts(kOfxParamPropPageChild);
    if host.appends_unlisted_groups {
        let groups = all.all().into_iter().filter(|one| is_group(one));
        let unlisted: Vec<_> = groups
            .map(|group| group.name.clone())
            .filter(|name| !names.contains(name))
            .collect();
        names.extend(unlisted);
    }
    let listed: Vec<_> = names.iter().filter_map(|name| all.get(name)).collect();
    // A host shows a parameter where its group stands.
    let mut rows = Vec::new();
    for parameter in listed.iter().filter(|one| group_of(one).is_none()) {
        rows.push(row(parameter));
        let inside = (listed.iter()).filter(|one| group_of(one).as_ref() == Some(&parameter.name));
        rows.extend(inside.map(|one| row(one)));
    }
    // Groups that are not on the page keep their parameters where those are listed.
    let orphans: Vec<_> = listed
        .iter()
        .map(|one| row(one))
        .filter(|one| !rows.contains(one))
        .collect();
    rows.extend(orphans);
    rows.retain(|row| !row.details.contains("hidden"));
    rows
}

/// Returns the pages.
pub(crate) fn pages(all: &ParameterSet) -> Vec<std::sync::Arc<Parameter>> {
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
    if set.int(kOfxParamPropSecret) == Some(1) {
        details.push("hidden".to_owned());
    }
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
