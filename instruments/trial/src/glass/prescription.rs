//! Published lens prescriptions: radii, thicknesses, indices and Abbe numbers.

use super::dispersion::Glass;

/// A surface of a prescription and the medium behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Curvature, 1 / length unit of the prescription; 0 for a plane.
    pub(super) curvature: f64,
    /// Distance to the next surface, length units.
    pub(super) thickness: f64,
    /// Glass behind the surface; `None` for air.
    pub(super) glass: Option<Glass>,
}

const fn curvature(radius: f64) -> f64 {
    if radius == 0.0 { 0.0 } else { 1.0 / radius }
}

/// Returns a surface with air behind it. Radius 0 is a plane.
const fn air(radius: f64, thickness: f64) -> Row {
    Row {
        curvature: curvature(radius),
        thickness,
        glass: None,
    }
}

/// Returns a surface with a glass behind it. Radius 0 is a plane.
const fn glass(radius: f64, thickness: f64, nd: f64, vd: f64) -> Row {
    Row {
        curvature: curvature(radius),
        thickness,
        glass: Some(Glass { nd, vd }),
    }
}

/// A lens by its published prescription.
#[derive(Debug)]
pub(super) struct Prescription {
    /// Surfaces from the scene to the sensor, with the stop as one of them. The last thickness is unused.
    pub(super) rows: &'static [Row],
    /// Index of the stop surface.
    pub(super) stop: usize,
    /// f-numbers at which it is used here.
    pub(super) f_numbers: &'static [f64],
    /// Largest angle of the field to use, degrees from the axis.
    pub(super) field_deg: f64,
    /// Focal lengths it is scaled to, mm.
    pub(super) focal_mm: &'static [f64],
    /// True if the last two surfaces are a plate before the sensor.
    pub(super) has_cover: bool,
}

/// Cooke triplet, 50 mm f/5, 20 degrees: the sample lens "Cooke 40 degree field" of Zemax OpticStudio, as tabulated in
/// `optiland.samples.objectives.CookeTriplet` (optiland 0.6.3), whose paraxial focal length and focus are the published
/// ones. Glasses SK16 and F2.
pub(super) static COOKE_TRIPLET: Prescription = Prescription {
    rows: &[
        glass(22.01359, 3.25896, 1.620_409, 60.281),
        air(-435.76044, 6.00755),
        glass(-22.21328, 0.99997, 1.620_040, 36.366),
        air(20.29192, 4.75041),
        glass(79.6836, 2.95208, 1.620_409, 60.281),
        air(-18.39533, 42.20778),
    ],
    stop: 3,
    f_numbers: &[5.0, 5.6, 6.3, 8.0],
    field_deg: 20.0,
    focal_mm: &[35.0, 40.0, 50.0, 65.0, 75.0],
    has_cover: false,
};

/// Double Gauss, 100 mm f/2, 14 degrees: the sample lens "Double Gauss 28 degree field" of Zemax OpticStudio and CODE V, as
/// tabulated in `optiland.samples.objectives.DoubleGauss` (optiland 0.6.3) and `ag_dblgauss.seq` (ray-optics 0.9), whose
/// paraxial focal length and focus are the published ones. Glasses N-SSK2, N-SK2, F5 and N-SK16.
pub(super) static DOUBLE_GAUSS: Prescription = Prescription {
    rows: &[
        glass(56.20238, 8.75, 1.622_294, 53.274),
        air(152.2858, 0.5),
        glass(37.68262, 12.5, 1.607_381, 56.650),
        glass(0.0, 3.8, 1.603_420, 38.030),
        air(24.2313, 16.369_445),
        air(0.0, 13.747_957),
        glass(-28.37731, 3.8, 1.603_420, 38.030),
        glass(0.0, 11.0, 1.620_410, 60.324),
        air(-37.92546, 0.5),
        glass(177.41176, 7.0, 1.620_410, 60.324),
        air(-79.41143, 61.487_536),
    ],
    stop: 5,
    f_numbers: &[2.8, 3.5, 4.0, 5.6],
    field_deg: 14.0,
    focal_mm: &[40.0, 50.0, 65.0, 75.0, 85.0],
    has_cover: false,
};

/// Tessar, 4 inches f/4.5, 20 degrees: Milton Laikin, "Lens Design", 4th edition, CRC Press 2007, page 63, as tabulated in
/// `optiland.samples.objectives.TessarLens` (optiland 0.6.3). Glasses N-SK15, F2 and K10; in inches.
pub(super) static TESSAR: Prescription = Prescription {
    rows: &[
        glass(1.3329, 0.2791, 1.622_960, 58.019),
        air(-9.9754, 0.2054),
        glass(-2.0917, 0.09, 1.620_040, 36.366),
        air(1.2123, 0.0709),
        air(0.0, 0.1534),
        glass(-7.5205, 0.09, 1.501_371, 56.409),
        glass(1.301, 0.3389, 1.622_960, 58.019),
        air(-1.5218, 3.4025),
    ],
    stop: 4,
    f_numbers: &[4.5, 5.0, 5.6, 8.0],
    field_deg: 18.0,
    focal_mm: &[35.0, 40.0, 50.0, 65.0, 75.0],
    has_cover: false,
};

/// Double Gauss, 50 mm f/1.8: Japanese patent application S62-87922 (Canon), example 1, as tabulated in the lens library of
/// github.com/Latios96/crayg, `resources/lensfiles/canon-60mm.fx`, with the back focus.
pub(super) static CANON: Prescription = Prescription {
    rows: &[
        glass(34.30, 4.50, 1.622_80, 57.0),
        air(247.65, 2.40),
        glass(21.51, 4.35, 1.701_54, 41.2),
        air(40.31, 0.92),
        glass(78.44, 1.40, 1.672_70, 32.1),
        air(15.32, 6.75),
        air(0.0, 4.95),
        glass(-15.83, 1.10, 1.698_95, 30.1),
        glass(135.97, 5.70, 1.799_52, 42.2),
        air(-21.24, 0.15),
        glass(162.15, 3.00, 1.720_00, 50.2),
        air(-49.97, 37.93),
    ],
    stop: 6,
    f_numbers: &[2.0, 2.8, 4.0, 5.6],
    field_deg: 20.0,
    focal_mm: &[35.0, 40.0, 50.0, 65.0, 75.0, 85.0],
    has_cover: false,
};

/// Double Gauss of seven elements, f/1.1: US patent 2,701,982 (Angénieux), as tabulated in the lens database of
/// github.com/zpelgrims/lentil, `polynomial-optics/database/lenses.json`, entry 0001; Abbe numbers from the lens library of
/// github.com/Latios96/crayg, `double-gauss-angenieux-50mm.fx`. For 100 mm; the distance to the sensor is that of the database.
pub(super) static ANGENIEUX: Prescription = Prescription {
    rows: &[
        glass(164.13, 10.99, 1.6751, 32.3),
        air(559.2, 0.23),
        glass(100.12, 11.45, 1.6689, 46.7),
        air(213.54, 0.23),
        glass(58.04, 22.95, 1.6913, 53.8),
        glass(2551.1, 2.58, 1.6751, 32.3),
        air(32.39, 15.66),
        air(0.0, 15.0),
        glass(-40.42, 2.74, 1.6992, 30.2),
        glass(192.98, 27.92, 1.6204, 60.2),
        air(-55.53, 0.23),
        glass(192.98, 7.98, 1.6913, 53.8),
        air(-225.3, 0.23),
        glass(175.09, 8.48, 1.6913, 53.8),
        air(-203.55, 55.724),
    ],
    stop: 7,
    f_numbers: &[2.0, 2.8, 4.0],
    field_deg: 16.0,
    focal_mm: &[40.0, 50.0, 65.0, 75.0],
    has_cover: false,
};

/// Objective of ten elements, 36 mm f/2, 10.8 degrees: US patent 8,879,901, as tabulated in
/// `optiland.samples.objectives.ObjectiveUS008879901` (optiland 0.6.3), whose paraxial focal length and focus are the
/// published ones. Glasses by nd and Vd of their catalogue entries.
pub(super) static US_8879901: Prescription = Prescription {
    rows: &[
        glass(47.071_252_35, 5.298_118_26, 1.794_569, 45.527),
        air(184.281_716_67, 0.6),
        glass(29.921_776_45, 7.136_548_63, 1.806_100, 41.017),
        air(50.499_263_8, 2.0),
        glass(60.500_484_5, 0.999_416_71, 1.717_362, 29.522),
        air(17.726_383_76, 9.9),
        air(0.0, 8.7),
        glass(-17.498_622_41, 1.299_345_79, 1.755_200, 27.641),
        glass(1000.0, 8.443_252_64, 1.772_502, 49.465),
        air(-28.001_224_22, 0.1),
        glass(-141.999_767_77, 6.799_502_54, 1.772_502, 49.465),
        air(-35.941_030_45, 0.516),
        glass(92.000_346_67, 3.299_013_61, 1.743_104, 49.437),
        air(-277.852_108_88, 2.13),
        glass(-157.245_886_62, 1.299_804_22, 1.487_490, 70.236),
        air(740.473_977_42, 0.25),
        glass(19.919_294_98, 5.593_456_88, 1.804_000, 46.598),
        air(36.488_526_23, 0.574),
        glass(45.975_322_35, 1.000_457_31, 1.717_362, 29.522),
        air(16.395_218_47, 2.951),
        glass(33.861_316_31, 3.224_442_31, 1.729_160, 54.685),
        air(0.0, 8.0),
        glass(0.0, 4.0, 1.729_160, 54.685),
        air(0.0, 3.153_178_38),
    ],
    stop: 6,
    f_numbers: &[2.0, 2.8, 4.0, 5.6],
    field_deg: 10.8,
    focal_mm: &[35.0, 40.0, 50.0, 65.0],
    has_cover: true,
};

/// All prescriptions.
pub(super) static ALL: [&Prescription; 6] = [
    &COOKE_TRIPLET,
    &DOUBLE_GAUSS,
    &TESSAR,
    &CANON,
    &ANGENIEUX,
    &US_8879901,
];
