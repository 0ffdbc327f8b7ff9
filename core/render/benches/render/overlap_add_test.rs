//! The rival is what it should be: through a lens that does the same everywhere it is the exact
//! renderer, and with nodes close together nearly so through any other.

mod lenses;
#[expect(dead_code, reason = "the benchmark reads the time that kernels took")]
mod overlap_add;
mod transform;

use lenses::SkewNormalLens;
use overlap_add::OverlapAdd;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::psf::SkewNormal;
use seidel_render::{
    BlurField, DisplacedBlur, Displacement, Edges, Plane, PlateMap, Renderer, Scatter, Scene,
    VergencePass,
};

const WIDTH: usize = 123;
const HEIGHT: usize = 77;

/// A lens that does everywhere what another does at one point.
struct Constant(SkewNormalLens);

impl BlurField for Constant {
    fn frame(&self) -> Frame {
        self.0.frame()
    }

    fn channel_count(&self) -> usize {
        self.0.channel_count()
    }

    fn blur_at(&self, channel: usize, _at: FieldPoint, vergence: f64) -> DisplacedBlur {
        self.0
            .blur_at(channel, FieldPoint::new(0.6, -0.3), vergence)
    }
}

/// The largest difference between both renderers of three planes, one of them of all channels.
fn difference(lens: &dyn BlurField, edges: Edges, spacing: usize) -> f32 {
    let scene = Scene {
        lens,
        model: &SkewNormal,
        width: WIDTH,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges,
        displacement: Displacement::None,
    };
    let samples: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| ((k * 7919) % 1009) as f32 / 1009.0)
        .collect();
    let weights = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.2, 0.3]];
    let planes = weights.each_ref().map(|weights| Plane {
        samples: &samples,
        weights,
    });
    let exact = Scatter
        .render(&scene, &planes, &|_| true)
        .expect("a sound scene")
        .planes;
    let rival = OverlapAdd {
        spacing,
        left_out: 0.0,
    };
    let found = rival.render(&scene, &planes).planes;
    let pairs = found.iter().flatten().zip(exact.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn lens(corner_sigma_px: f64) -> SkewNormalLens {
    let frame = Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a frame");
    SkewNormalLens::new(frame, corner_sigma_px)
}

#[test]
fn a_constant_lens_is_drawn_exactly() {
    for edges in [Edges::Black, Edges::Mirror] {
        // The second window holds the whole plate and kernels fold more than once.
        for (sigma, spacing) in [(6.0, 16), (6.0, 48), (40.0, 128)] {
            let worst = difference(&Constant(lens(sigma)), edges, spacing);
            assert!(
                worst < 1e-5,
                "{edges:?}, sigma {sigma}, spacing {spacing}: {worst}"
            );
        }
    }
}

#[test]
fn the_error_of_a_varying_lens_falls_with_the_spacing() {
    let errors = [32, 16, 4].map(|spacing| difference(&lens(6.0), Edges::Mirror, spacing));
    assert!(errors[0] > 1.5 * errors[1], "{errors:?}");
    assert!(errors[1] > 3.0 * errors[2], "{errors:?}");
    assert!(errors[2] < 5e-3, "{errors:?}");
}
