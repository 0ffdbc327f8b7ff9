//! Ray-traced plates with shared, coarser kernels against one fine kernel per pixel.

use crate::*;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};
use seidel_optics::psf::{KernelBounds, LocalBlur, PsfModel, Pupil, SampleGrid};

/// The upper right corner of a fast lens's frame, 960 px wide.
struct Corner;

impl BlurField for Corner {
    fn frame(&self) -> Frame {
        Frame::new(960, 540, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        1
    }

    fn blur_at(&self, _: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let numbers = ReducedNumbers {
            alpha: 36.0 * (vergence - 0.5),
            beta: 1.2,
            gamma: -5.2,
            delta: 0.8,
            phi: -3.6,
        };
        let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.06);
        DisplacedBlur {
            blur: LocalBlur::from_pupil(pupil, at.meridian()),
            displacement_px: (1.4 * at.x, 1.4 * at.y),
        }
    }
}

/// [`Pupil`] in full detail, without shared kernels.
struct Fine;

impl PsfModel for Fine {
    fn id(&self) -> &'static str {
        "fine"
    }

    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds {
        Pupil.kernel_bounds(blur)
    }

    fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]) {
        Pupil.sample(blur, window, out);
    }

    fn sample_f32(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f32]) {
        Pupil.sample_f32(blur, window, out);
    }
}

#[test]
fn shared_and_coarser_kernels_are_not_visible() {
    let (width, height) = (56, 24);
    // From far behind focus to in front of it, and a step.
    let vergence: Vec<f32> = (0..width * height)
        .map(|k| match k % width {
            column if column < 20 => 0.01,
            column => 0.2 + 0.015 * (column - 20) as f32,
        })
        .collect();
    let samples: Vec<f32> = (0..width * height)
        .map(|k| match k % 149 {
            7 => 300.0,
            other => (other * other % 31) as f32 / 31.0,
        })
        .collect();
    let by = |model: &dyn PsfModel| {
        let scene = Scene {
            lens: &Corner,
            model,
            width,
            height,
            map: PlateMap {
                origin: ImagePoint::new(904.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::PerPixel(&vergence),
            edges: Edges::Mirror,
            displacement: Displacement::Full,
        };
        let planes = [Plane {
            samples: &samples,
            weights: &[1.0],
        }];
        let done = Scatter.render(&scene, &planes, &|_| true);
        done.expect("a valid scene").planes.remove(0)
    };
    let (fine, shared) = (by(&Fine), by(&Pupil));
    let energy = |light: &dyn Fn(usize) -> f32| -> f64 {
        let squares = (0..width * height).map(|k| f64::from(light(k)).powi(2));
        squares.sum()
    };
    let ratio = energy(&|k| fine[k]) / energy(&|k| fine[k] - shared[k]);
    let db = 10.0 * ratio.log10();
    assert!(db > 45.0, "{db}");
    let total = |light: &[f32]| light.iter().map(|&v| f64::from(v)).sum::<f64>();
    assert!((total(&fine) / total(&shared) - 1.0).abs() < 1e-5);
}
