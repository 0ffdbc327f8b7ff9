//! The designs of the lens library. Names describe a kind of lens, not a product.
//!
//! Aberrations are in pixels of the frame at the edge of the pupil, field positions in half frame widths.

/// A lens design.
pub(super) struct Design {
    pub(super) name: &'static str,
    /// A few words for a list.
    pub(super) title: &'static str,
    /// The kind of lens, in a sentence.
    pub(super) kind: &'static str,
    pub(super) focal_mm: f64,
    pub(super) f_number: f64,
    /// Largest f-number that the design is meant for.
    pub(super) smallest_aperture: f64,
    pub(super) focus_m: f64,
    pub(super) nearest_m: f64,
    /// Width and height of the sensor, mm.
    pub(super) sensor_mm: [f64; 2],
    /// Columns and rows of the frame.
    pub(super) frame_px: [u32; 2],
    /// Width of the scene over that of its image, for an anamorphic lens.
    pub(super) squeeze: Option<f64>,
    /// Defocus in the focused plane, red, green, blue; their mean is taken off.
    pub(super) axial: [f64; 3],
    /// Spherical aberration, red, green, blue.
    pub(super) beta: [f64; 3],
    /// Astigmatism.
    pub(super) gamma: f64,
    /// Field curvature.
    pub(super) delta: f64,
    /// Coma, red, green, blue.
    pub(super) coma: [f64; 3],
    /// Lateral colour: magnification relative to green, of red, green, blue.
    pub(super) lateral: [f64; 3],
    pub(super) distortion: f64,
    /// Variance of the symmetric blur, px².
    pub(super) blur_variance_px2: f64,
    /// Effects by identifier, with the parameters that are not neutral.
    pub(super) effects: &'static [(&'static str, &'static [(&'static str, f64)])],
    pub(super) shows: &'static [&'static str],
    pub(super) good_for: &'static [&'static str],
    pub(super) lacks: &'static [&'static str],
}

/// A lens without aberrations for a frame of 1920 x 1080 on a sensor 36 mm wide.
const PLAIN: Design = Design {
    name: "",
    title: "",
    kind: "",
    focal_mm: 50.0,
    f_number: 2.0,
    smallest_aperture: 16.0,
    focus_m: 2.0,
    nearest_m: 1.0,
    sensor_mm: [36.0, 20.25],
    frame_px: [1920, 1080],
    squeeze: None,
    axial: [0.0; 3],
    beta: [0.0; 3],
    gamma: 0.0,
    delta: 0.0,
    coma: [0.0; 3],
    lateral: [0.0; 3],
    distortion: 0.0,
    blur_variance_px2: 0.2,
    effects: &[],
    shows: &[],
    good_for: &[],
    lacks: &[],
};

/// The designs, in the order of the list.
pub(super) const ALL: &[Design] = &[
    Design {
        name: "modern-50",
        title: "clean modern prime, 50 mm f/1.4",
        kind: "A well-corrected double Gauss of many elements: even discs, cat's eyes only near the corners.",
        focal_mm: 50.0,
        f_number: 1.4,
        focus_m: 2.0,
        nearest_m: 0.45,
        axial: [0.25, 0.0, 0.4],
        beta: [0.35, 0.4, 0.5],
        gamma: -0.9,
        delta: 0.45,
        coma: [-0.45, -0.4, -0.4],
        lateral: [0.00015, 0.0, -0.0002],
        distortion: -0.006,
        effects: &[
            (
                "aperture_polygon",
                &[("blades", 9.0), ("rotation_deg", 10.0), ("roundness", 0.95)],
            ),
            (
                "vignetting",
                &[
                    ("radius_1", 1.2),
                    ("shift_1", 0.5),
                    ("radius_2", 1.25),
                    ("shift_2", -0.45),
                ],
            ),
        ],
        shows: &[
            "round, even discs; cat's eyes towards the corners that open as the lens is stopped down",
            "nine blades that show from about f/2.8",
            "almost no colour fringes",
        ],
        good_for: &[
            "a neutral start, to be changed with --amount and --channel-scale",
            "visual effects plates of modern cameras",
        ],
        lacks: &["focus breathing", "onion rings of aspherical elements"],
        ..PLAIN
    },
    Design {
        name: "soft-portrait-85",
        title: "soft portrait lens, 85 mm f/1.8",
        kind: "An old portrait lens with undercorrected spherical aberration: a sharp core within a glow, creamy backgrounds.",
        focal_mm: 85.0,
        f_number: 1.8,
        focus_m: 2.5,
        nearest_m: 0.9,
        axial: [1.2, 0.0, 2.0],
        beta: [-10.0, -11.0, -12.5],
        gamma: -1.6,
        delta: 1.0,
        coma: [-1.3, -1.2, -1.1],
        lateral: [-0.0003, 0.0, 0.0004],
        distortion: 0.003,
        effects: &[
            ("defocus_offset", &[("alpha", 5.5)]),
            ("higher_order", &[("w060", -2.5)]),
            (
                "vignetting",
                &[
                    ("radius_1", 1.25),
                    ("shift_1", 0.35),
                    ("radius_2", 1.3),
                    ("shift_2", -0.3),
                ],
            ),
            (
                "veiling_glare",
                &[("share", 0.05), ("radius", 6.0), ("steepness", 2.0)],
            ),
        ],
        shows: &[
            "spherical aberration: a glow around highlights in focus, which goes by f/4",
            "discs that fade towards their rim behind the focus, and have a bright rim in front of it",
            "focus that moves as the lens is stopped down",
            "veiling glare",
        ],
        good_for: &["faces", "dream sequences and period looks"],
        lacks: &["flare from single bright lights"],
        ..PLAIN
    },
    Design {
        name: "swirl-58",
        title: "swirling background, 58 mm f/2",
        kind: "A vintage double Gauss in a narrow barrel: astigmatism and strong cat's eyes turn the background around the axis.",
        focal_mm: 58.0,
        f_number: 2.0,
        focus_m: 2.0,
        nearest_m: 0.6,
        axial: [0.8, 0.0, 1.5],
        beta: [1.9, 2.0, 2.2],
        gamma: 9.0,
        delta: -3.0,
        coma: [-2.6, -2.4, -2.2],
        lateral: [0.0009, 0.0, -0.0011],
        distortion: -0.002,
        effects: &[
            ("aperture_polygon", &[("blades", 8.0), ("roundness", 1.0)]),
            (
                "vignetting",
                &[
                    ("radius_1", 1.05),
                    ("shift_1", 0.7),
                    ("radius_2", 1.1),
                    ("shift_2", -0.62),
                ],
            ),
        ],
        shows: &[
            "narrow cat's eyes along circles around the axis: a swirl behind the subject",
            "astigmatism that stretches discs the same way",
            "soft, comatic corners in focus; green and purple rims out of it",
        ],
        good_for: &[
            "portraits before leaves or lights",
            "a subject in the middle of the frame",
        ],
        lacks: &["the low contrast of old coatings"],
        ..PLAIN
    },
    Design {
        name: "wide-zoom-16",
        title: "wide zoom at 16 mm f/2.8",
        kind: "The short end of a retrofocus zoom: barrel distortion and lateral colour, nearly everything in focus.",
        focal_mm: 16.0,
        f_number: 2.8,
        smallest_aperture: 22.0,
        focus_m: 1.5,
        nearest_m: 0.3,
        axial: [0.2, 0.0, 0.3],
        beta: [0.3, 0.3, 0.35],
        gamma: 1.8,
        delta: -1.4,
        coma: [-1.5, -1.4, -1.2],
        lateral: [0.0016, 0.0, -0.0021],
        distortion: -0.035,
        blur_variance_px2: 0.25,
        effects: &[
            (
                "aperture_polygon",
                &[("blades", 7.0), ("rotation_deg", 12.0), ("roundness", 0.7)],
            ),
            ("higher_order", &[("w331", -0.8), ("w422", 1.2)]),
            (
                "vignetting",
                &[
                    ("radius_1", 1.15),
                    ("shift_1", 0.5),
                    ("radius_2", 1.3),
                    ("shift_2", -0.35),
                ],
            ),
        ],
        shows: &[
            "lateral colour: red and blue fringes that grow towards the corners",
            "coma and astigmatism that smear the corners, also of fifth order",
            "barrel distortion, with --geometry full",
        ],
        good_for: &[
            "interiors and landscapes",
            "integrating CG into action-camera and documentary plates",
        ],
        lacks: &[
            "the moustache distortion of many zooms",
            "other focal lengths of the zoom",
        ],
        ..PLAIN
    },
    Design {
        name: "anamorphic-75",
        title: "2x front anamorphic, 75 mm f/1.8",
        kind: "Cylinders before a spherical lens: upright ovals, and more aberrations along x than along y.",
        focal_mm: 75.0,
        f_number: 1.8,
        focus_m: 2.5,
        nearest_m: 1.1,
        sensor_mm: [21.5, 18.0],
        frame_px: [1290, 1080],
        squeeze: Some(2.0),
        axial: [0.6, 0.0, 1.1],
        beta: [1.1, 1.0, 1.0],
        coma: [-0.9, -0.8, -0.7],
        lateral: [0.0009, 0.0, -0.0012],
        blur_variance_px2: 0.2,
        effects: &[
            (
                "vignetting",
                &[
                    ("radius_1", 1.2),
                    ("shift_1", 0.45),
                    ("radius_2", 1.25),
                    ("shift_2", -0.4),
                ],
            ),
            (
                "double_plane",
                &[("w2020", -2.2), ("w0202", 1.5), ("w3010", 0.9)],
            ),
        ],
        shows: &[
            "discs twice as high as wide on the desqueezed plate",
            "another field curvature and coma along x than along y",
        ],
        good_for: &[
            "wide-screen plates, squeezed or desqueezed",
            "night streets with many lights",
        ],
        lacks: &[
            "the blue streak of a front anamorphic",
            "mumps: a squeeze that changes with focus",
        ],
        ..PLAIN
    },
    Design {
        name: "bubble-100",
        title: "soap bubbles, 100 mm f/2.8",
        kind: "A triplet with overcorrected spherical aberration: background lights become bubbles with a bright rim.",
        focal_mm: 100.0,
        f_number: 2.8,
        focus_m: 2.0,
        nearest_m: 1.0,
        axial: [1.0, 0.0, 1.6],
        beta: [6.6, 7.0, 7.6],
        gamma: -3.0,
        delta: 2.0,
        coma: [-1.6, -1.5, -1.4],
        lateral: [0.0005, 0.0, -0.0007],
        distortion: 0.001,
        effects: &[
            ("defocus_offset", &[("alpha", -6.0)]),
            ("aperture_polygon", &[("blades", 13.0), ("roundness", 1.0)]),
            ("higher_order", &[("w060", 4.0)]),
            (
                "vignetting",
                &[
                    ("radius_1", 1.3),
                    ("shift_1", 0.3),
                    ("radius_2", 1.35),
                    ("shift_2", -0.25),
                ],
            ),
        ],
        shows: &[
            "discs with a bright, coloured rim behind the focus, and soft ones in front of it",
            "spherical aberration of third and fifth order: the rim goes by f/5.6",
            "focus that moves as the lens is stopped down",
        ],
        good_for: &["lights, dew and foliage behind a subject"],
        lacks: &["uneven discs of single samples"],
        ..PLAIN
    },
    Design {
        name: "mirror-500",
        title: "catadioptric mirror, 500 mm f/8",
        kind: "A mirror lens: the pupil is dark in its middle, so that discs are rings.",
        focal_mm: 500.0,
        f_number: 8.0,
        smallest_aperture: 8.0,
        focus_m: 20.0,
        nearest_m: 4.0,
        beta: [0.5, 0.5, 0.5],
        gamma: 1.2,
        delta: -0.8,
        coma: [-0.5, -0.5, -0.5],
        blur_variance_px2: 0.4,
        effects: &[
            (
                "vignetting",
                &[
                    ("radius_1", 1.15),
                    ("shift_1", 0.2),
                    ("radius_2", 1.4),
                    ("shift_2", -0.2),
                ],
            ),
            ("obstruction", &[("radius", 0.42)]),
        ],
        shows: &[
            "rings with sharp inner edges in place of discs, before and behind the focus",
            "no axial or lateral colour, as mirrors have none",
        ],
        good_for: &[
            "long shots of water, leaves and lights",
            "nature and sports plates",
        ],
        lacks: &[
            "the spokes that hold the mirror",
            "an iris, as real ones do: leave the f-number alone",
        ],
        ..PLAIN
    },
    Design {
        name: "macro-100",
        title: "macro lens, 100 mm f/2.8",
        kind: "A flat-field macro lens at half a metre: sharp to the corners, and very large discs elsewhere.",
        focal_mm: 100.0,
        f_number: 2.8,
        smallest_aperture: 32.0,
        focus_m: 0.5,
        nearest_m: 0.35,
        axial: [0.3, 0.0, 0.4],
        beta: [-0.5, -0.5, -0.5],
        gamma: -0.2,
        delta: 0.1,
        coma: [-0.1, -0.1, -0.1],
        lateral: [0.00004, 0.0, -0.00005],
        distortion: 0.0005,
        blur_variance_px2: 0.15,
        effects: &[(
            "aperture_polygon",
            &[("blades", 6.0), ("rotation_deg", 90.0), ("roundness", 0.3)],
        )],
        shows: &[
            "six-sided discs of the same shape over the whole frame",
            "a depth of field of a few millimetres",
        ],
        good_for: &[
            "products, insects, eyes",
            "shots that go out of focus altogether",
        ],
        lacks: &[
            "diffraction, which real macro lenses show beyond f/11",
            "the fall of aperture with magnification",
        ],
        ..PLAIN
    },
];
