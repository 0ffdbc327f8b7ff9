//! Depth with occlusion, against the same plate at the distance of the largest blur.

use crate::{FAST, median, memory, planes_of, plate, timed};
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{LocalBlur, PHI, SkewNormal};
use seidel_render::{
    BlurField, DisplacedBlur, Displacement, Edges, LayeredRenderer, Occlusion, PlateMap, Renderer,
    Scene, VergencePass,
};

/// Name of the case on the command line.
pub(crate) const NAME: &str = "depth-1920x1080";
const SIZE: (usize, usize) = (1920, 1080);
/// Vergences in focus, farthest and nearest, 1/m: 3 m, 20 m and 0.5 m.
const FOCUS: f64 = 1.0 / 3.0;
const FARTHEST: f64 = 0.05;
const NEAREST: f64 = 2.0;
/// Radius (two standard deviations) of the nearest blur, px.
const LARGEST_RADIUS_PX: f64 = 40.0;
/// The aim for the time with depth over that of a flat plate.
const MOST: f64 = 5.0;

/// A skew-normal blur that grows with the distance from focus and decreases slightly towards the corners.
struct DepthLens {
    frame: Frame,
}

impl BlurField for DepthLens {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let rho = at.radius() / self.frame.corner_radius();
        let rate = LARGEST_RADIUS_PX / 2.0 / (NEAREST - FOCUS) * [0.95, 1.0, 1.05][channel];
        let sigma = |fall: f64| (rate * (vergence - FOCUS) * (1.0 - fall * rho * rho)).hypot(0.6);
        let (radial, across) = (sigma(0.1), sigma(0.4));
        let alpha = [3.0, 4.0, 5.0][channel] * rho;
        let delta = alpha / (1.0 + alpha * alpha).sqrt();
        let skew = delta * radial / (1.0 - 2.0 * delta * delta / std::f64::consts::PI).sqrt();
        let meridian = at.meridian();
        let moments = MeridionalMoments {
            mu20: radial * radial,
            mu02: across * across,
            mu30: PHI * skew.powi(3),
            mu12: 0.0,
        };
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
            displacement_px: (0.0, 0.0),
        }
    }
}

/// A floor from the farthest vergence at the top to the nearest at the bottom, two cards and a disc.
fn pass() -> Vec<f32> {
    let (width, height) = SIZE;
    let vergence = |index: usize| {
        let x = (index % width) as f64 / width as f64;
        let y = (index / width) as f64 / height as f64;
        let floor = FARTHEST + (NEAREST - FARTHEST) * y * y;
        let near = (0.1..0.25).contains(&x) && (0.2..0.8).contains(&y);
        let sharp = (0.5..0.6).contains(&x) && (0.1..0.6).contains(&y);
        let disc = (x - 0.8).hypot((y - 0.4) * height as f64 / width as f64) < 0.08;
        let at = |there: bool, vergence: f64| if there { vergence } else { 0.0 };
        floor
            .max(at(near, 1.3))
            .max(at(sharp, FOCUS))
            .max(at(disc, 0.7)) as f32
    };
    (0..width * height).map(vergence).collect()
}

/// Returns a line with both times, and a table with the aim for their ratio.
pub(crate) fn report(rounds: usize) -> Result<String> {
    eprintln!("{NAME}");
    let (width, height) = SIZE;
    let lens = DepthLens {
        frame: Frame::new(width as u32, height as u32, None)?,
    };
    let samples = plate::plate(width, height, 0.0);
    let planes = planes_of(&samples);
    let pass = pass();
    let scene = |vergence| Scene {
        lens: &lens,
        model: &SkewNormal,
        width,
        height,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence,
        edges: Edges::Mirror,
        displacement: Displacement::None,
    };
    let layered = LayeredRenderer {
        inner: &FAST,
        settings: Occlusion::default(),
    };
    let (mut deep, mut flat) = (Vec::new(), Vec::new());
    for round in 0..=rounds {
        let vergences = [
            VergencePass::PerPixel(&pass),
            VergencePass::Constant(NEAREST),
        ];
        for (vergence, times) in vergences.into_iter().zip([&mut deep, &mut flat]) {
            let (done, seconds) = timed(|| layered.render(&scene(vergence), &planes, &|_| true));
            done?;
            // The first round is a warm-up.
            if round > 0 {
                times.push(seconds);
            }
        }
    }
    let (deep, flat) = (median(&deep), median(&flat));
    let ratio = deep / flat;
    let verdict = if ratio <= MOST { "met" } else { "not met" };
    let memory = memory::peak_bytes().map_or_else(String::new, |bytes| {
        format!(
            "; the process held {:.2} GiB at most",
            bytes as f64 / f64::from(1 << 30)
        )
    });
    Ok(format!(
        "Depth from 20 m to 0.5 m with occlusion, radius up to {LARGEST_RADIUS_PX} px, {width} x {height}: {deep:.2} s; all at \
         0.5 m: {flat:.3} s{memory}.\n\n| aim | wanted | found | |\n| --- | --- | --- | --- |\n\
         | depth / flat | at most {MOST} | {ratio:.1} | {verdict} |",
    ))
}
