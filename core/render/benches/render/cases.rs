//! The cases of the benchmark: plates, lenses and references.

use crate::lenses::SkewNormalLens;
use crate::pupil_lens::PupilLens;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::psf::{PsfModel, Pupil, SkewNormal};
use seidel_render::{BlurField, Displacement, Edges, PlateMap, Scene, VergencePass};

/// The lenses of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lens {
    SkewNormal,
    Pupil,
}

impl Lens {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::SkewNormal => "skew-normal",
            Self::Pupil => "pupil",
        }
    }

    pub(crate) fn model(self) -> &'static dyn PsfModel {
        match self {
            Self::SkewNormal => &SkewNormal,
            Self::Pupil => &Pupil,
        }
    }

    /// Returns the lens for a plate of `size` that is its whole frame.
    pub(crate) fn on(self, size: (usize, usize), corner_sigma_px: f64) -> Box<dyn BlurField> {
        let frame = Frame::new(size.0 as u32, size.1 as u32, None).expect("a frame");
        match self {
            Self::SkewNormal => Box::new(SkewNormalLens::new(frame, corner_sigma_px)),
            Self::Pupil => Box::new(PupilLens::new(frame, corner_sigma_px)),
        }
    }
}

/// The reference of the fast renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Truth {
    /// The whole plate by the exact renderer.
    Whole,
    /// The exact renderer at some pixels. Ray-traced models use one kernel per square of `cell_px` pixels, and only
    /// their green plane is compared.
    Spots { count: usize, cell_px: usize },
    /// Nothing.
    None,
}

/// One line of the table.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    pub(crate) lens: Lens,
    pub(crate) corner_sigma_px: f64,
    pub(crate) size: (usize, usize),
    pub(crate) truth: Truth,
    /// Whether the overlap-add renderer renders it too.
    pub(crate) rival: bool,
    /// The exact renderer is timed on one of this many bands of rows; 0: not at all.
    pub(crate) exact_bands: usize,
    /// Whether peak memory is measured.
    pub(crate) memory: bool,
}

impl Case {
    pub(crate) fn name(&self) -> String {
        let (width, height) = self.size;
        format!(
            "{}-{}-{width}x{height}",
            self.lens.name(),
            self.corner_sigma_px
        )
    }

    /// Returns the scene: the plate is the whole frame of `lens`, edges are mirrored.
    pub(crate) fn scene<'a>(&self, lens: &'a dyn BlurField, of: Lens) -> Scene<'a> {
        Scene {
            lens,
            model: of.model(),
            width: self.size.0,
            height: self.size.1,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::Constant(0.0),
            edges: Edges::Mirror,
            displacement: Displacement::None,
        }
    }
}

const HD: (usize, usize) = (1920, 1080);
const UHD: (usize, usize) = (3840, 2160);
const UHD2: (usize, usize) = (7680, 4320);

/// Returns small plates for a quick check.
pub(crate) fn quick() -> Vec<Case> {
    let case = |lens, corner_sigma_px, memory| Case {
        lens,
        corner_sigma_px,
        size: (320, 180),
        truth: Truth::Whole,
        rival: lens == Lens::SkewNormal,
        exact_bands: if lens == Lens::SkewNormal { 1 } else { 0 },
        memory,
    };
    vec![
        case(Lens::SkewNormal, 6.0, false),
        case(Lens::SkewNormal, 18.0, true),
        case(Lens::Pupil, 6.0, false),
    ]
}

/// Returns all cases of the benchmark.
pub(crate) fn all() -> Vec<Case> {
    let mut cases = Vec::new();
    for (corner_sigma_px, count, bands) in [(6.0, 400, 4), (60.0, 100, 16)] {
        for size in [HD, UHD, UHD2] {
            cases.push(Case {
                lens: Lens::SkewNormal,
                corner_sigma_px,
                size,
                truth: if size == UHD2 {
                    Truth::None
                } else {
                    Truth::Spots { count, cell_px: 1 }
                },
                rival: size != UHD2,
                exact_bands: if size == HD { bands } else { 0 },
                memory: size == UHD2,
            });
        }
    }
    for (corner_sigma_px, count, cell_px) in [(6.0, 200, 4), (60.0, 50, 24)] {
        for size in [HD, UHD] {
            cases.push(Case {
                lens: Lens::Pupil,
                corner_sigma_px,
                size,
                truth: if size == HD {
                    Truth::Spots { count, cell_px }
                } else {
                    Truth::None
                },
                rival: false,
                exact_bands: 0,
                memory: false,
            });
        }
    }
    cases
}
