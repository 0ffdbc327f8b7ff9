//! Lenses that come with the plugin: designed for their look, not measured. The library's lenses follow those of the plugin.
//!
//! Each of the latter is a `pupil` lens (docs/background/model.md section 3) with five aberrations per channel in frame pixels. Defocus
//! alone changes with distance, by the thin lens law. The names describe the look of the lens, not a product.

use std::ffi::CStr;
use std::fmt::Write;

use seidel_core::LibraryLens;
use seidel_optics::effects::{Effect, Vignetting};

/// The menu: a file, then the lenses that come with the plugin. Projects store the index, so that it grows at its end only.
pub(crate) const NAMES: &[&CStr] = &[
    c"Lens File",
    c"Fast 50 mm f/0.95",
    c"Fast 35 mm f/1.4",
    c"Portrait 85 mm f/1.4",
    c"Vintage 58 mm f/2",
    c"Library: modern-50",
    c"Library: soft-portrait-85",
    c"Library: swirl-58",
    c"Library: wide-zoom-16",
    c"Library: anamorphic-75",
    c"Library: bubble-100",
    c"Library: mirror-500",
    c"Library: macro-100",
];

/// Prefix of the lenses of the library in the menu.
const LIBRARY_LABEL: &str = "Library: ";

/// Index of the file in the menu.
pub(crate) const FILE: i32 = 0;

/// Columns and rows of the frame in which aberrations are given.
const FRAME: (u32, u32) = (1920, 1080);
/// Width of the sensor that the frame covers, mm.
const SENSOR_MM: f64 = 36.0;

/// A lens design. Aberrations are in frame pixels at the edge of the pupil, field positions in half frame widths.
struct Design {
    focal_mm: f64,
    f_number: f64,
    /// Focus distance, metres.
    focus_m: f64,
    /// Nearest distance at which the lens is valid, metres.
    nearest_m: f64,
    /// Spherical aberration.
    beta: f64,
    /// Astigmatism.
    gamma: f64,
    /// Field curvature.
    delta: f64,
    /// Distortion.
    distortion: f64,
    /// Defocus in the focused plane, red, green, blue.
    axial: [f64; 3],
    /// Coma, red, green, blue.
    coma: [f64; 3],
    /// Lateral colour: magnification relative to green, of red, green, blue.
    lateral: [f64; 3],
    /// Vignetting by the two ends of the barrel: radius and shift of the first, radius and shift of the second, in pupil
    /// radii, shifts at the edge of the field.
    barrel: Option<[f64; 4]>,
}

const DESIGNS: [Design; 4] = [
    // An old fast prime wide open: comatic corners, longitudinal colour.
    Design {
        focal_mm: 50.0,
        f_number: 0.95,
        focus_m: 2.0,
        nearest_m: 0.9,
        beta: 2.4,
        gamma: -10.5,
        delta: 1.5,
        distortion: -0.004,
        axial: [1.5, 0.0, 2.7],
        coma: [-7.3, -6.8, -6.0],
        lateral: [0.0028, 0.0, -0.0034],
        barrel: None,
    },
    // A modern fast wide lens: small aberrations, cat's-eye bokeh in the corners.
    Design {
        focal_mm: 35.0,
        f_number: 1.4,
        focus_m: 3.0,
        nearest_m: 0.4,
        beta: 0.8,
        gamma: -2.4,
        delta: 1.1,
        distortion: -0.011,
        axial: [0.5, 0.0, 0.9],
        coma: [-1.7, -1.6, -1.4],
        lateral: [0.0006, 0.0, -0.0007],
        barrel: Some([1.25, 0.62, 1.3, -0.55]),
    },
    // A portrait lens: soft discs, corners nearly as good as the centre.
    Design {
        focal_mm: 85.0,
        f_number: 1.4,
        focus_m: 2.5,
        nearest_m: 0.9,
        beta: -1.9,
        gamma: -1.2,
        delta: 0.6,
        distortion: 0.003,
        axial: [0.9, 0.0, 1.4],
        coma: [-0.8, -0.7, -0.7],
        lateral: [-0.0004, 0.0, 0.0005],
        barrel: Some([1.2, 0.45, 1.25, -0.4]),
    },
    // A vintage lens: swirling background from astigmatism and a narrow barrel.
    Design {
        focal_mm: 58.0,
        f_number: 2.0,
        focus_m: 2.0,
        nearest_m: 0.6,
        beta: 2.0,
        gamma: 9.0,
        delta: 6.5,
        distortion: -0.002,
        axial: [0.8, 0.0, 1.6],
        coma: [-3.0, -2.8, -2.5],
        lateral: [0.0012, 0.0, -0.0015],
        barrel: Some([1.1, 0.75, 1.15, -0.7]),
    },
];

/// Channels and their wavelengths, nm.
const CHANNELS: [(&str, f64); 3] = [("R", 620.0), ("G", 540.0), ("B", 460.0)];

/// Returns the lens of the library at `index` of the menu.
fn of_library(index: i32) -> Option<&'static LibraryLens> {
    let label = NAMES.get(usize::try_from(index).ok()?)?.to_str().ok()?;
    LibraryLens::by_name(label.strip_prefix(LIBRARY_LABEL)?).ok()
}

/// Returns the profile of the lens at `index` of the menu, as JSON.
pub(crate) fn profile(index: i32) -> String {
    if let Some(lens) = of_library(index) {
        return lens.profile_json.to_owned();
    }
    let last = DESIGNS.len() as i32;
    let design = &DESIGNS[(index.clamp(1, last) - 1) as usize];
    let channels: Vec<String> = (0..CHANNELS.len()).map(|k| channel(design, k)).collect();
    let waves: Vec<String> = CHANNELS
        .iter()
        .map(|(name, wave)| format!("\"{name}\": {wave:?}"))
        .collect();
    let (width, height) = FRAME;
    format!(
        r#"{{"format": "seidel-lens", "version": 1, "kind": "pupil", "image_size": [{width}, {height}],
 "optical_axis": [{:?}, {:?}], "pixel_pitch_um": {:?},
 "camera": {{"focal_length_mm": {:?}, "f_number": {:?}, "focus_distance_m": {:?}, "wavelength_nm": {{{}}}}},
 "channels": [{}],
 "provenance": {{"program": "seidel-ofx {}", "sources": ["built-in"], "settings": "designed, not measured"}}}}"#,
        f64::from(width) / 2.0,
        f64::from(height) / 2.0,
        SENSOR_MM * 1e3 / f64::from(width),
        design.focal_mm,
        design.f_number,
        design.focus_m,
        waves.join(", "),
        channels.join(",\n  "),
        env!("CARGO_PKG_VERSION"),
    )
}

impl Design {
    /// Returns the radius of the blur disc on the axis, frame pixels per 1/m of vergence: the shift of the image, times the
    /// radius of the pupil over the image distance.
    fn defocus(&self) -> f64 {
        let focal = self.focal_mm * 1e-3;
        let image = focal / (1.0 - focal / self.focus_m);
        let pitch = SENSOR_MM * 1e-3 / f64::from(FRAME.0);
        image * focal / (2.0 * self.f_number) / pitch
    }

    /// Returns vignetting as an effect of the profile, as JSON; empty without a barrel.
    fn effects(&self) -> String {
        let Some([radius_1, shift_1, radius_2, shift_2]) = self.barrel else {
            return String::new();
        };
        format!(
            r#"{{"id": "{}", "parameters": {{"radius_1": {}, "shift_1": {}, "radius_2": {}, "shift_2": {}}}}}"#,
            Vignetting.id(),
            series(&[radius_1]),
            series(&[shift_1]),
            series(&[radius_2]),
            series(&[shift_2])
        )
    }
}

/// Returns a polynomial in vergence with these coefficients, as JSON.
fn series(coefficients: &[f64]) -> String {
    let sigma = vec![0.0; coefficients.len()];
    format!(r#"{{"coefficients": {coefficients:?}, "sigma": {sigma:?}}}"#)
}

/// Returns channel `k` of the profile, as JSON.
fn channel(design: &Design, k: usize) -> String {
    let slope = design.defocus();
    let mut text = format!(r#"{{"name": "{}""#, CHANNELS[k].0);
    let mut put = |name: &str, coefficients: &[f64]| {
        // Writing to a string does not fail.
        let _ = write!(text, r#", "{name}": {}"#, series(coefficients));
    };
    put("alpha", &[design.axial[k] - slope / design.focus_m, slope]);
    put("beta", &[design.beta]);
    put("gamma", &[design.gamma]);
    put("delta", &[design.delta]);
    put("phi", &[design.coma[k]]);
    put("blur_variance_px2", &[0.2]);
    put("magnification", &[design.lateral[k]]);
    put("distortion", &[design.distortion]);
    let most = 1.0 / design.nearest_m;
    let effects = design.effects();
    text + &format!(r#", "measured_vergence_per_m": [0.0, {most:?}], "effects": [{effects}]}}"#)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::{LensOrigin, load};
    use seidel_core::ObjectDistance;

    #[test]
    fn every_lens_of_the_menu_loads() {
        assert_eq!(
            NAMES.len(),
            1 + DESIGNS.len() + seidel_optics::library::ALL.len()
        );
        for lens in seidel_optics::library::ALL {
            let label = format!("{LIBRARY_LABEL}{}", lens.name);
            let index = NAMES.iter().position(|name| name.to_str() == Ok(&label));
            let index = index.expect("every lens of the library is in the menu") as i32;
            assert_eq!(profile(index), lens.profile_json);
        }
        for index in 1..=DESIGNS.len() as i32 {
            let lens = load(&LensOrigin::BuiltIn(index), 0).expect("a valid profile");
            assert_eq!(lens.predictor().channel_names(), ["R", "G", "B"]);
            assert!(lens.predictor().depends_on_depth());
            let design = &DESIGNS[index as usize - 1];
            let focus = lens.profile().camera.focus_distance;
            assert_eq!(focus, ObjectDistance::Metres(design.focus_m));
        }
    }
}
