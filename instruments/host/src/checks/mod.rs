//! The checks, one per file.

mod abort;
mod action_order;
mod bit_depths;
mod blur;
mod components;
mod concurrency;
mod contexts;
mod description;
mod determinism;
mod empty_clips;
mod exports;
mod fields;
mod fixture;
mod frame_memory;
mod host_kinds;
mod identity;
mod image_release;
mod input_sizes;
mod leaks;
mod leftover_threads;
mod messages;
mod missing_file;
mod missing_properties;
mod missing_suites;
mod null_arguments;
mod null_functions;
mod origin;
mod overlay;
mod pages;
mod parameter_access;
mod parameter_changes;
mod pixel_aspect;
mod region_of_definition;
mod regions_of_interest;
mod reload;
mod render_scale;
mod row_layouts;
mod saved_project;
mod string_lifetime;
mod thread_counts;
mod tiles;
mod tiny_images;
mod variants;
mod written_pixels;

use crate::drive::Frame;
use crate::picture::Picture;
use crate::subject::Subject;

/// The findings of a check.
#[derive(Debug, Default)]
pub struct Report {
    /// Faults of the plugin.
    pub faults: Vec<String>,
    /// Parts that were not tested, with the reason.
    pub skipped: Vec<String>,
}

impl Report {
    /// Records a fault, unless it is recorded already.
    pub fn fault(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.faults.contains(&text) {
            self.faults.push(text);
        }
    }

    /// Records a fault unless `condition` holds.
    pub fn expect(&mut self, condition: bool, fault: impl FnOnce() -> String) {
        if !condition {
            self.fault(fault());
        }
    }

    /// Records a fault if there is one, with the case in which it occurred.
    pub fn expect_none(&mut self, fault: Option<String>, case: &str) {
        if let Some(fault) = fault {
            self.fault(format!("{case}: {fault}"));
        }
    }

    /// Records an error as a fault, with the case in which it occurred.
    pub fn expect_ok<T>(&mut self, result: Result<T, String>, case: &str) {
        self.expect_none(result.err(), case);
    }

    /// Records a fault if a frame differs from `expected` in any bit within its window.
    pub fn expect_same(&mut self, expected: &Picture, frame: &Frame, case: &str) {
        self.expect_none(expected.difference(&frame.picture, frame.window), case);
    }

    /// Records an error, or a difference as in [`Self::expect_same`].
    pub fn expect_renders_same(
        &mut self,
        expected: &Picture,
        frame: Result<Frame, String>,
        case: &str,
    ) {
        match frame {
            Ok(frame) => self.expect_same(expected, &frame, case),
            Err(fault) => self.fault(format!("{case}: {fault}")),
        }
    }

    /// Records that something was not tested.
    pub fn skip(&mut self, why: &str) {
        self.skipped.push(why.to_owned());
    }
}

/// A check.
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// The requirement that it checks.
    pub about: &'static str,
    /// Runs it. An error is a fault that ends the check.
    pub run: fn(&Subject, &mut Report) -> Result<(), String>,
}

/// All checks, from loading to rendering to rarer features.
pub static ALL: &[&Check] = &[
    // The two longest run beside all the others.
    &variants::CHECK,
    &missing_properties::CHECK,
    &exports::CHECK,
    &description::CHECK,
    &contexts::CHECK,
    &pages::CHECK,
    &blur::CHECK,
    &reload::CHECK,
    &leftover_threads::CHECK,
    &action_order::CHECK,
    &null_arguments::CHECK,
    &missing_suites::CHECK,
    &null_functions::CHECK,
    &string_lifetime::CHECK,
    &parameter_access::CHECK,
    &host_kinds::CHECK,
    &leaks::CHECK,
    &frame_memory::CHECK,
    &image_release::CHECK,
    &written_pixels::CHECK,
    &row_layouts::CHECK,
    &origin::CHECK,
    &tiles::CHECK,
    &regions_of_interest::CHECK,
    &region_of_definition::CHECK,
    &thread_counts::CHECK,
    &determinism::CHECK,
    &concurrency::CHECK,
    &render_scale::CHECK,
    &pixel_aspect::CHECK,
    &fields::CHECK,
    &components::CHECK,
    &bit_depths::CHECK,
    &empty_clips::CHECK,
    &input_sizes::CHECK,
    &tiny_images::CHECK,
    &identity::CHECK,
    &parameter_changes::CHECK,
    &abort::CHECK,
    &messages::CHECK,
    &missing_file::CHECK,
    &saved_project::CHECK,
    &overlay::CHECK,
];

/// Returns the check of that name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Check> {
    ALL.iter().find(|check| check.name == name).copied()
}
