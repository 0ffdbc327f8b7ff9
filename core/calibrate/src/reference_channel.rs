//! The channel to which positions and focus of the others are compared.

use seidel_optics::camera::Camera;

/// Returns the index of the channel of middle wavelength among `names`; `G`, else the middle one, where `camera` does not
/// state all wavelengths.
pub(crate) fn reference_channel<'a>(
    camera: &Camera,
    names: impl Iterator<Item = &'a str> + Clone,
) -> usize {
    let known: Option<Vec<f64>> = (names.clone())
        .map(|name| camera.wavelength_nm.get(name).copied())
        .collect();
    let Some(waves) = known else {
        let green = names.clone().position(|name| name == "G");
        return green.unwrap_or_else(|| names.count() / 2);
    };
    let mut order: Vec<usize> = (0..waves.len()).collect();
    order.sort_by(|a, b| waves[*a].total_cmp(&waves[*b]));
    order.get(order.len() / 2).copied().unwrap_or(0)
}
