//! Warnings about a fitted moments model.

use seidel_optics::lens::DepthLaw;
use seidel_optics::profile::{LensProfile, MomentsChannel};

/// Returns warnings about the depth law of each channel. Channels with the same warning share a line.
pub(super) fn depth_warnings(lens: &LensProfile) -> Vec<String> {
    let Ok(laws) = lens.depth_laws() else {
        return Vec::new();
    };
    let mut by_text: Vec<(String, Vec<&str>)> = Vec::new();
    for (channel, law) in lens.moments_channels().iter().zip(laws) {
        for text in channel_warnings(channel, law.as_ref()) {
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

fn channel_warnings(channel: &MomentsChannel, law: Option<&DepthLaw>) -> Vec<String> {
    let Some(law) = law else {
        return vec![
            "the object distance is unknown, so the blur is the same at every depth".to_owned(),
        ];
    };
    let mut warnings = Vec::new();
    let missing = law.undetermined();
    if channel.planes.len() == 1 {
        warnings.push(
            "one object distance, so the blur is the same at every depth; fit three or more to model its change"
                .to_owned(),
        );
    } else if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(|k| format!("S{k}")).collect();
        warnings.push(format!(
            "two object distances do not determine the depth dependence of {}; add a third",
            names.join(", ")
        ));
    }
    if law.aberrations_change() {
        warnings.push(
            "aberrations change with object distance, so S1..S10 are quadratic in 1/distance instead of the degrees of a constant lens"
                .to_owned(),
        );
    }
    warnings
}
