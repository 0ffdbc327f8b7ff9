//! Strips, and plates narrower than their blur: coarse levels draw them, so that the work does not grow with the width of the blur.

use super::*;
use crate::LevelStatistics;

/// A blur that is nearly even over the plates of these tests.
fn even(sigma_px: f64, rays: bool) -> TestLens {
    TestLens {
        centre: 0.9,
        rays,
        ..lens(sigma_px)
    }
}

fn model(lens: &TestLens) -> &'static dyn PsfModel {
    if lens.rays { &Pupil } else { &SkewNormal }
}

/// The result of one render.
struct Work {
    levels: Vec<LevelStatistics>,
    planes: Vec<Vec<f32>>,
}

/// Renders a plate of this size in Final quality.
fn work(scene: &Scene) -> Work {
    let samples = plate_of(5, scene.width, scene.height);
    let planes = WEIGHTS.each_ref().map(|weights| Plane {
        samples: &samples,
        weights,
    });
    let found = Gather::default().render(scene, &planes, &|_| true);
    let found = found.expect("a sound scene");
    Work {
        levels: found.statistics.levels,
        planes: found.planes,
    }
}

/// Checks a result against the exact renderer: by the PSNR of the quality, and relative to its own peak where little light stays.
fn check_exact(scene: &Scene, planes: &[Vec<f32>]) {
    let exact = render(&Scatter, scene, &plate_of(5, scene.width, scene.height));
    let peak = exact.iter().flatten().fold(0.0_f32, |a, b| a.max(*b));
    let psnr = psnr_db(planes, &exact);
    let relative = psnr + 20.0 * f64::from(peak).log10();
    let (width, height, edges) = (scene.width, scene.height, scene.edges);
    assert!(
        psnr > 50.0 && relative > 40.0,
        "{width} x {height}, {edges:?}: {psnr} dB, {relative} dB of the peak"
    );
}

fn sized<'a>(lens: &'a TestLens, [width, height]: [usize; 2], edges: Edges) -> Scene<'a> {
    Scene {
        width,
        height,
        edges,
        ..scene(lens, model(lens))
    }
}

#[test]
fn a_strip_is_drawn_on_coarse_levels() {
    for edges in [Edges::Black, Edges::Mirror] {
        // By rays, drawing every kernel takes minutes: the levels alone are checked.
        let lens = even(20.0, true);
        let levels = work(&sized(&lens, [1600, 26], edges)).levels;
        assert!(levels.len() > 1 && levels[0].gathered == 0, "{levels:?}");
        let lens = even(8.0, false);
        let scene = sized(&lens, [960, 18], edges);
        let Work { levels, planes } = work(&scene);
        // The blur is narrow at one end.
        let fine = &levels[0];
        assert!(
            levels.len() > 2 && fine.gathered < fine.upsampled,
            "{levels:?}"
        );
        check_exact(&scene, &planes);
    }
}

#[test]
fn a_plate_narrower_than_its_blur_is_drawn_on_coarse_levels() {
    for (rays, edges) in [(true, Edges::Black), (false, Edges::Mirror)] {
        let lens = even(60.0, rays);
        let scene = sized(&lens, [48, 30], edges);
        let Work { levels, planes } = work(&scene);
        let fine: usize = levels.iter().take(2).map(|level| level.gathered).sum();
        assert!(levels.len() > 2 && fine == 0, "{levels:?}");
        check_exact(&scene, &planes);
    }
}

/// A lens that cannot be drawn beyond a field radius.
struct LimitedField {
    lens: TestLens,
    radius_px: f64,
}

impl BlurField for LimitedField {
    fn frame(&self) -> Frame {
        self.lens.frame()
    }

    fn channel_count(&self) -> usize {
        self.lens.channel_count()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let found = self.lens.blur_at(channel, at, vergence_per_m);
        if at.radius() < self.radius_px {
            return found;
        }
        let moments = MeridionalMoments {
            mu20: 1e9,
            mu02: 1e9,
            mu30: 0.0,
            mu12: 0.0,
        };
        let meridian = at.meridian();
        let blur = LocalBlur::from_moments(moments.in_image(meridian), meridian);
        DisplacedBlur { blur, ..found }
    }
}

#[test]
fn tiles_do_not_grow_to_where_the_lens_has_no_blur() {
    let inner = even(60.0, false);
    let limited = LimitedField {
        lens: even(60.0, false),
        radius_px: 420.0,
    };
    let whole = Scene {
        width: 48,
        height: 30,
        ..scene(&inner, &SkewNormal)
    };
    let samples = plate_of(5, 48, 30);
    let expected = render(&Scatter, &whole, &samples);
    let scene = Scene {
        lens: &limited,
        ..whole
    };
    let found = render(&Gather::default(), &scene, &samples);
    assert!(psnr_db(&found, &expected) > 50.0);
}
