//! The CoC map: the diameter of the circle of confusion of each pixel in false colour.

use seidel_core::{CocColours, Image, PreparedPlate};

/// Returns the map of a plate with R, G and B; its alpha stays.
///
/// # Errors
/// Focus settings that cannot be followed.
pub(crate) fn coc_map(plate: &PreparedPlate) -> seidel_core::Result<Image> {
    let map = plate.blur_map()?;
    let scale = CocColours::default();
    let mut planes = plate.planes().to_vec();
    let alpha = planes.get(plate.colour_count()).cloned();
    for (index, diameter_px) in map.diameter_px.iter().enumerate() {
        let coverage = alpha.as_ref().map_or(1.0, |alpha| alpha[index]);
        let colour = scale.of(*diameter_px).map(|value| coverage * value);
        for (plane, value) in planes.iter_mut().take(plate.colour_count()).zip(colour) {
            plane[index] = value;
        }
    }
    let placement = plate.placement();
    plate.to_image_of_size(placement.width, placement.height, planes)
}
