//! The checks, one a file, each on the list of all.

mod abort;
mod arguments;
mod blur;
mod changes;
mod components;
mod concurrent;
mod context;
mod description;
mod determinism;
mod empty_clips;
mod exports;
mod fields;
mod file;
mod frame;
mod identity;
mod images;
mod kinds;
mod leaks;
mod members;
mod messages;
mod order;
mod origin;
mod overlay;
mod pixel_aspect;
mod properties;
mod region_of_definition;
mod regions_of_interest;
mod reload;
mod render_scale;
mod rows;
mod samples;
mod sizes;
pub(crate) mod stage;
mod strings;
mod suites;
mod thread_counts;
mod threads;
mod tiles;
mod tiny;
mod values;
mod variants;

use crate::subject::Subject;

/// What a check found.
#[derive(Debug, Default)]
pub struct Report {
    /// What the plugin does wrong.
    pub faults: Vec<String>,
    /// What could not be looked at, and why.
    pub skipped: Vec<String>,
}

impl Report {
    /// Notes a fault.
    pub fn fault(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.faults.contains(&text) {
            self.faults.push(text);
        }
    }

    /// Notes a fault unless `right`.
    pub fn expect(&mut self, right: bool, text: impl FnOnce() -> String) {
        if !right {
            self.fault(text());
        }
    }

    /// Notes a fault, if there is one.
    pub fn none(&mut self, fault: Option<String>, what: &str) {
        if let Some(fault) = fault {
            self.fault(format!("{what}: {fault}"));
        }
    }

    /// Notes what could not be looked at.
    pub fn skip(&mut self, why: &str) {
        self.skipped.push(why.to_owned());
    }
}

/// One check.
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// What has to be so, in one sentence.
    pub about: &'static str,
    /// Does it. An error is one more fault.
    pub run: fn(&Subject, &mut Report) -> Result<(), String>,
}

/// All of them, from the outside in.
pub static ALL: &[&Check] = &[
    &exports::CHECK,
    &description::CHECK,
    &context::CHECK,
    &blur::CHECK,
    &reload::CHECK,
    &threads::CHECK,
    &order::CHECK,
    &arguments::CHECK,
    &suites::CHECK,
    &members::CHECK,
    &properties::CHECK,
    &strings::CHECK,
    &values::CHECK,
    &kinds::CHECK,
    &leaks::CHECK,
    &images::CHECK,
    &frame::CHECK,
    &rows::CHECK,
    &origin::CHECK,
    &tiles::CHECK,
    &regions_of_interest::CHECK,
    &region_of_definition::CHECK,
    &thread_counts::CHECK,
    &determinism::CHECK,
    &concurrent::CHECK,
    &render_scale::CHECK,
    &pixel_aspect::CHECK,
    &fields::CHECK,
    &components::CHECK,
    &samples::CHECK,
    &empty_clips::CHECK,
    &sizes::CHECK,
    &tiny::CHECK,
    &identity::CHECK,
    &variants::CHECK,
    &changes::CHECK,
    &abort::CHECK,
    &messages::CHECK,
    &file::CHECK,
    &overlay::CHECK,
];

/// The check of that name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Check> {
    ALL.iter().find(|check| check.name == name).copied()
}
