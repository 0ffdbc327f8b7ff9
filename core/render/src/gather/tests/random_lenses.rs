//! The fast renderer against the exact one over random lenses on small plates: narrow and wide blur, uniform or changing
//! up to eightfold, skewed, with lateral colour.

use super::{TestLens, plate_of, psnr_db, render};
use crate::{Displacement, Edges, Gather, PlateMap, Quality, Scatter, Scene, VergencePass};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::psf::{Gaussian, PsfModel, SkewNormal};

const LENSES: u64 = 20;

/// A linear congruential generator, the same on any machine.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        let mut random = Self(7919 * seed + 3);
        random.share();
        random
    }

    /// Returns a number from 0 to 1.
    fn share(&mut self) -> f64 {
        const FACTOR: u64 = 6_364_136_223_846_793_005;
        self.0 = self.0.wrapping_mul(FACTOR).wrapping_add(1);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    fn coin(&mut self) -> bool {
        self.share() < 0.5
    }
}

fn lens(random: &mut Random) -> TestLens {
    let width = random.between(80.0, 340.0);
    let height = random.between(60.0, 200.0);
    let widest = 0.06 * width.hypot(height);
    let growth = 8.0_f64.powf(random.share());
    TestLens {
        frame: Frame::new(width as u32, height as u32, None).expect("a frame"),
        corner_sigma_px: 0.5 * (widest / 0.5).powf(random.share()),
        centre: if random.share() < 0.3 {
            growth.min(2.0)
        } else {
            1.0 / growth
        },
        skew: random.between(0.0, 0.95),
        rays: false,
    }
}

#[test]
fn random_lenses_meet_the_stated_psnr() {
    let mut narrow = 0;
    for seed in 0..LENSES {
        let mut random = Random::new(seed);
        let lens = lens(&mut random);
        let size = (
            lens.frame.width_px() as usize,
            lens.frame.height_px() as usize,
        );
        let model: &dyn PsfModel = if random.coin() {
            &Gaussian
        } else {
            &SkewNormal
        };
        let scene = Scene {
            lens: &lens,
            model,
            width: size.0,
            height: size.1,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::Constant(0.0),
            edges: if random.coin() {
                Edges::Mirror
            } else {
                Edges::Black
            },
            displacement: Displacement::Lateral,
        };
        let samples = plate_of(seed as u32, scene.width, scene.height);
        let exact = render(&Scatter, &scene, &samples);
        // The third channel's blur is the widest.
        let widest_px = 1.15 * lens.corner_sigma_px * lens.centre.max(1.0);
        narrow += usize::from(widest_px < 6.0);
        let bounds = [
            (Quality::Final, if widest_px < 6.0 { 75.0 } else { 60.0 }),
            (Quality::Draft, 45.0),
        ];
        for (quality, bound) in bounds {
            let found = psnr_db(
                &render(
                    &Gather {
                        quality,
                        kernels: None,
                    },
                    &scene,
                    &samples,
                ),
                &exact,
            );
            assert!(
                found >= bound,
                "{seed}: {size:?}, blur of {widest_px:.2} px, {quality:?}: {found}"
            );
        }
    }
    // Both bounds are exercised.
    assert!((5..LENSES as usize - 3).contains(&narrow), "{narrow}");
}
