//! The pages of the panel.

use super::{Check, Report, fixture};
use crate::host::effect::{Effect, Parameter};
use crate::host::profile::Profile;
use crate::panel::{group_of, is_group, pages};
use crate::subject::Subject;

use openfx::sys::image_effect_v1::param::kOfxParamPropPageChild;

pub(super) static CHECK: Check = Check {
    name: "pages",
    about: "pages list defined parameters once, and each group before those in it",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        for context in loaded.contexts() {
            let descriptor = loaded.describe_in(&context)?;
            let pages = pages(&descriptor.parameters);
            if pages.is_empty() {
                report.skip("the plugin has no pages");
            }
            for page in pages {
                check_page(&descriptor, &page, report);
            }
            descriptor.invalidate(loaded.host);
        }
        Ok(())
    })
}

fn check_page(descriptor: &Effect, page: &Parameter, report: &mut Report) {
    let names = page.properties.texts(kOfxParamPropPageChild);
    for (index, name) in names.iter().enumerate() {
        report.expect(!names[..index].contains(name), || {
            format!("page {} lists {name} twice", page.name)
        });
        let Some(parameter) = descriptor.parameters.get(name) else {
            report.fault(format!(
                "page {} lists {name}, which is not defined",
                page.name
            ));
            continue;
        };
        let Some(group) = group_of(&parameter) else {
            continue;
        };
        let parent = descriptor.parameters.get(&group);
        report.expect(parent.is_some_and(|parent| is_group(&parent)), || {
            format!("{name} is in {group}, which is no group")
        });
        report.expect(names[..index].contains(&group), || {
            format!(
                "page {} does not list the group {group} before the parameters in it: Natron shows the group at the end",
                page.name
            )
        });
    }
}
