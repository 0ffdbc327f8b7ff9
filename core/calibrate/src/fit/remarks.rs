//! What a user should know of a fitted lens.

use seidel_optics::lens::DepthLaw;
use seidel_optics::profile::{LensProfile, MomentsChannel};

/// What the object distances at hand allow to be known across depth; channels of which the same is to
/// be said share a remark.
pub(super) fn on_depth(lens: &LensProfile) -> Vec<String> {
    let Ok(laws) = lens.depth_laws() else {
        return Vec::new();
    };
    let mut by_text: Vec<(String, Vec<&str>)> = Vec::new();
    for (channel, law) in lens.moments_channels().iter().zip(laws) {
        for text in depth_remark(channel, law.as_ref()) {
            match by_text.iter_mut().find(|(known, _)| *known == text) {
                Some((_, names)) => names.push(&channel.name),
                None => by_text.push((text, vec![&channel.name])),
            }
        }
    }
    by_text
        .into_iter()
        .map(|(text, names)| format!("{}: {text}", names.join(", ")))
        .collect()
}

fn depth_remark(channel: &MomentsChannel, law: Option<&DepthLaw>) -> Vec<String> {
    let Some(law) = law else {
        return vec![
            "the object distance is unknown, so the blur is the same at every depth".to_owned(),
        ];
    };
    let mut remarks = Vec::new();
    let missing = law.undetermined();
    if channel.planes.len() == 1 {
        remarks.push(
            "one object distance, so the blur is the same at every depth; three or more tell how it changes"
                .to_owned(),
        );
    } else if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(|k| format!("S{k}")).collect();
        remarks.push(format!(
            "two object distances leave the full dependence on depth of {} open; a third would settle it",
            names.join(", ")
        ));
    }
    if law.aberrations_change() {
        remarks.push(
            "aberrations change with object distance, so S1..S10 are quadratic in 1/distance instead of the degrees of a constant lens"
                .to_owned(),
        );
    }
    remarks
}
