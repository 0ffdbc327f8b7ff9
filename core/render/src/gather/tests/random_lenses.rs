//! The fast renderer against the exact one over lenses drawn by chance: small plates over which blur
//! changes by much of itself, narrow and wide, even and growing or shrinking eightfold, skewed, in colour.

use super::{TestLens, plate_of, psnr_db, render};
use crate::{Displacement, Edges, PlateMap, Scatter, Scene, VergencePass};
use crate::{Gather, Quality};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::psf::{Gaussian, PsfModel, SkewNormal};

const LENSES: u64 = 20;

/// Numbers by a linear congruential generator, the same on any machine.
struct Chance(u64);

impl Chance {
    fn of_seed(seed: u64) -> Self {
        let mut chance = Self(7919 * seed + 3);
        chance.share();
        chance
    }

    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        const FACTOR: u64 = 6_364_136_223_846_793_005;
        self.0 = self.0.wrapping_mul(FACTOR).wrapping_add(1);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    fn one_in_two(&mut self) -> bool {
        self.share() < 0.5
    }
}

fn lens(chance: &mut Chance) -> TestLens {
    let width = chance.between(80.0, 340.0);
    let height = chance.between(60.0, 200.0);
    let widest = 0.06 * width.hypot(height);
    let growth = 8.0_f64.powf(chance.share());
    TestLens {
        frame: Frame::new(width as u32, height as u32, None).expect("a frame"),
        corner_sigma_px: 0.5 * (widest / 0.5).powf(chance.share()),
        centre: if chance.share() < 0.3 {
            growth.min(2.0)
        } else {
            1.0 / growth
        },
        skew: chance.between(0.0, 0.95),
        rays: false,
    }
}

#[test]
fn random_lenses_keep_to_the_bound() {
    let mut narrow = 0;
    for seed in 0..LENSES {
        let mut chance = Chance::of_seed(seed);
        let lens = lens(&mut chance);
        let size = (
            lens.frame.width_px() as usize,
            lens.frame.height_px() as usize,
        );
        let model: &dyn PsfModel = if chance.one_in_two() {
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
            edges: if chance.one_in_two() {
                Edges::Mirror
            } else {
                Edges::Black
            },
            displacement: Displacement::Lateral,
        };
        let samples = plate_of(seed as u32, size);
        let exact = render(&Scatter, &scene, &samples);
        // The third channel's blur is the widest.
        let widest_px = 1.15 * lens.corner_sigma_px * lens.centre.max(1.0);
        narrow += usize::from(widest_px < 6.0);
        let bounds = [
            (Quality::Final, if widest_px < 6.0 { 75.0 } else { 60.0 }),
            (Quality::Draft, 45.0),
        ];
        for (quality, bound) in bounds {
            let found = psnr_db(&render(&Gather { quality }, &scene, &samples), &exact);
            assert!(
                found >= bound,
                "{seed}: {size:?}, blur of {widest_px:.2} px, {quality:?}: {found}"
            );
        }
    }
    // Both bounds were tried.
    assert!((5..LENSES as usize - 3).contains(&narrow), "{narrow}");
}
