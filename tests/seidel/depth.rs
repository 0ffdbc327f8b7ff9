//! Occlusion against images rendered through many pinholes.

use crate::depth_scenes::{self, DepthScene};
use crate::pinholes::{self, HEIGHT, ThinLens, WIDTH};
use seidel_core::{Displacement, ImagePoint};
use seidel_optics::psf::Pupil;
use seidel_render::{
    Background, Edges, LayeredRenderer, Occlusion, Plane, PlateMap, Renderer, Scatter, Scene,
    VergencePass,
};

/// Width of the border that is not compared, because its pixels depend on the scene outside the frame.
const BORDER_PX: usize = 20;
/// Least signal-to-noise ratios for depth with anti-aliased edges and with noise.
const SMOOTH_DB: f64 = 36.0;
const NOISY_DB: f64 = 36.0;
/// The scenes whose first card is a blurred foreground, and the least signal-to-noise ratio at their edges with the background
/// given.
const FOREGROUNDS: [&str; 2] = ["near-card-blurred", "dark-card-blurred"];
const GIVEN_DB: f64 = 41.6;
/// Half width of the band around depth edges that is scored separately, px.
const BAND_PX: usize = 16;

fn scene<'a>(lens: &'a ThinLens, vergence: &'a [f32]) -> Scene<'a> {
    Scene {
        lens,
        model: &Pupil,
        width: WIDTH,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::PerPixel(vergence),
        edges: Edges::Mirror,
        displacement: Displacement::None,
    }
}

/// Light and alpha of an opaque plate, rendered.
fn rendered(by: &dyn Renderer, lens: &ThinLens, light: &[f32], vergence: &[f32]) -> [Vec<f32>; 2] {
    let opaque = vec![1.0; light.len()];
    let planes = [light, &opaque].map(|samples| Plane {
        samples,
        weights: &[1.0],
    });
    let done = by.render(&scene(lens, vergence), &planes, &|_| true);
    let planes = done.expect("a valid scene").planes;
    planes.try_into().expect("as many planes as given")
}

fn layered() -> LayeredRenderer<'static> {
    LayeredRenderer {
        inner: &Scatter,
        settings: Occlusion::default(),
    }
}

/// Light of an opaque plate, rendered with what its cards but the first one show as its background.
fn rendered_with_background(scene: &DepthScene, light: &[f32], vergence: &[f32]) -> Vec<f32> {
    let (behind, behind_vergence) = pinholes::plate(&scene.lens, &scene.cards[1..]);
    let opaque = vec![1.0; light.len()];
    let renderer = LayeredRenderer {
        inner: &Scatter,
        settings: Occlusion {
            background: Some(Background {
                planes: &[&behind, &opaque],
                vergence: VergencePass::PerPixel(&behind_vergence),
            }),
            ..Occlusion::default()
        },
    };
    let [ours, alpha] = rendered(&renderer, &scene.lens, light, vergence);
    let worst = alpha.iter().map(|a| (a - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-4, "{}, alpha: {worst}", scene.name);
    ours
}

/// Indices of the compared pixels, and of those near a depth edge.
fn compared(vergence: &[f32]) -> (Vec<usize>, Vec<usize>) {
    let inside: Vec<usize> = (0..WIDTH * HEIGHT)
        .filter(|index| {
            let (x, y) = (index % WIDTH, index / WIDTH);
            (BORDER_PX..WIDTH - BORDER_PX).contains(&x)
                && (BORDER_PX..HEIGHT - BORDER_PX).contains(&y)
        })
        .collect();
    let jumps: Vec<(i64, i64)> = inside
        .iter()
        .filter(|&&k| {
            (vergence[k] - vergence[k + 1]).abs() > 0.05
                || (vergence[k] - vergence[k + WIDTH]).abs() > 0.05
        })
        .map(|k| ((k % WIDTH) as i64, (k / WIDTH) as i64))
        .collect();
    let near = |index: &&usize| {
        let (x, y) = ((**index % WIDTH) as i64, (**index / WIDTH) as i64);
        let reach = BAND_PX as i64;
        jumps
            .iter()
            .any(|(a, b)| (a - x).abs() <= reach && (b - y).abs() <= reach)
    };
    let band = inside.iter().filter(near).copied().collect();
    (inside, band)
}

/// Peak signal-to-noise ratio, dB, for a white of one.
fn psnr(got: &[f32], want: &[f32], pixels: &[usize]) -> f64 {
    let squares = pixels.iter().map(|&k| f64::from(got[k] - want[k]).powi(2));
    -10.0 * (squares.sum::<f64>() / pixels.len() as f64).log10()
}

/// The images of a scene and their scores.
struct Pictures {
    plate: Vec<f32>,
    reference: Vec<f32>,
    ours: Vec<f32>,
    plain: Vec<f32>,
    vergence: Vec<f32>,
}

fn pictures(scene: &DepthScene) -> Pictures {
    let (plate, vergence) = pinholes::plate(&scene.lens, &scene.cards);
    let reference = pinholes::reference(&scene.lens, &scene.cards, scene.pinholes);
    let [ours, _] = rendered(&layered(), &scene.lens, &plate, &vergence);
    let [plain, _] = rendered(&Scatter, &scene.lens, &plate, &vergence);
    Pictures {
        plate,
        reference,
        ours,
        plain,
        vergence,
    }
}

/// Asserts least signal-to-noise ratios over the frame and near depth edges, in dB, and that an opaque scene stays
/// opaque.
fn must_agree(name: &str, least: (f64, f64)) {
    let scenes = depth_scenes::all();
    let scene = scenes.iter().find(|scene| scene.name == name);
    let scene = scene.expect("a scene of that name");
    let (plate, vergence) = pinholes::plate(&scene.lens, &scene.cards);
    let reference = pinholes::reference(&scene.lens, &scene.cards, scene.pinholes);
    let [ours, alpha] = rendered(&layered(), &scene.lens, &plate, &vergence);
    let (inside, band) = compared(&vergence);
    let all = psnr(&ours, &reference, &inside);
    assert!(all > least.0, "{name}: {all}");
    if !band.is_empty() {
        let edges = psnr(&ours, &reference, &band);
        assert!(edges > least.1, "{name}, edges: {edges}");
    }
    let worst = alpha.iter().map(|a| (a - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-4, "{name}, alpha: {worst}");
}

#[test]
fn a_sharp_card_before_a_blurred_background() {
    must_agree("near-card-sharp", (49.5, 44.6));
}

#[test]
fn a_blurred_card_before_a_sharp_background() {
    must_agree("dark-card-blurred", (35.3, 30.4));
}

#[test]
fn three_cards_one_in_focus() {
    must_agree("three-cards", (46.0, 45.2));
}

#[test]
fn a_card_that_stands_on_a_floor() {
    must_agree("card-on-floor", (42.2, 39.2));
}

#[test]
fn a_slanted_plane_has_no_bands_and_stays_opaque() {
    must_agree("slanted-plane", (46.5, 0.0));
}

#[test]
fn blurred_wires() {
    must_agree("wires-blurred", (43.3, 41.4));
}

#[test]
fn sharp_wires() {
    must_agree("wires-sharp", (36.8, 34.9));
}

#[test]
fn lights_behind_the_edge_of_a_sharp_card() {
    must_agree("light-behind-sharp-card", (33.4, 29.5));
}

#[test]
fn lights_behind_the_edge_of_a_blurred_card_are_cut() {
    must_agree("light-behind-blurred-card", (36.5, 34.5));
}

/// Without occlusion the same scenes have far larger errors.
#[test]
fn occlusion_is_worth_ten_decibels_at_an_edge() {
    let scenes = depth_scenes::all();
    let scene = scenes.iter().find(|scene| scene.name == "near-card-sharp");
    let all = pictures(scene.expect("a scene of that name"));
    let (_, band) = compared(&all.vergence);
    let gain = psnr(&all.ours, &all.reference, &band) - psnr(&all.plain, &all.reference, &band);
    assert!(gain > 10.0, "{gain}");
}

/// With its background given, a blurred foreground is right at its edge, where an estimate is not.
#[test]
fn a_given_background_is_shown_behind_a_blurred_card() {
    for name in FOREGROUNDS {
        let scenes = depth_scenes::all();
        let scene = scenes.iter().find(|scene| scene.name == name);
        let scene = scene.expect("a scene of that name");
        let all = pictures(scene);
        let given = rendered_with_background(scene, &all.plate, &all.vergence);
        let (_, band) = compared(&all.vergence);
        let with = psnr(&given, &all.reference, &band);
        let gain = with - psnr(&all.ours, &all.reference, &band);
        assert!(with > GIVEN_DB && gain > 8.0, "{name}: {with}, {gain} more");
    }
}

/// Anti-aliased edges and noise of the depth pass reduce accuracy only a little.
#[test]
fn smooth_edges_and_noise_of_depth_do_little_harm() {
    let scenes = depth_scenes::all();
    let scene = scenes.iter().find(|scene| scene.name == "near-card-sharp");
    let DepthScene { lens, cards, .. } = scene.expect("a scene of that name");
    let (plate, vergence) = pinholes::plate(lens, cards);
    let reference = pinholes::reference(lens, cards, 512);
    let (_, band) = compared(&vergence);
    let score = |vergence: &[f32]| {
        let [ours, _] = rendered(&layered(), lens, &plate, vergence);
        psnr(&ours, &reference, &band)
    };
    let smooth = score(&pinholes::smooth_depth(lens, cards));
    assert!(smooth > SMOOTH_DB, "{smooth}");
    // Noise of 2 %: an eighth of a pixel of blur in the foreground, a third in the background.
    let noisy = vergence.iter().enumerate().map(|(k, v)| {
        let noise = ((k * 7919) % 101) as f32 / 50.0 - 1.0;
        v * (1.0 + 0.02 * noise)
    });
    let noisy = score(&noisy.collect::<Vec<_>>());
    assert!(noisy > NOISY_DB, "{noisy}");
}

/// Writes `depth-edges.png` to the folder named by `SEIDEL_DEPTH_PICTURES` and prints the figures of
/// `docs/background/depth-edges.md`. Each row has plate, reference, render, render without occlusion and twice the error.
#[test]
#[ignore = "writes a picture to look at"]
fn write_images_for_the_docs() {
    let folder = std::env::var_os("SEIDEL_DEPTH_PICTURES").expect("SEIDEL_DEPTH_PICTURES is set");
    let scenes = depth_scenes::all();
    let size = ((5 * WIDTH) as u32, (scenes.len() * HEIGHT) as u32);
    let mut picture = image::GrayImage::new(size.0, size.1);
    for (line, scene) in scenes.iter().enumerate() {
        let all = pictures(scene);
        print_row(scene.name, &all);
        if FOREGROUNDS.contains(&scene.name) {
            let given = rendered_with_background(scene, &all.plate, &all.vergence);
            let (_, band) = compared(&all.vergence);
            let edges = psnr(&given, &all.reference, &band);
            println!("{}, edges, with --background: {edges:.1}", scene.name);
        }
        let error: Vec<f32> = (all.ours.iter().zip(&all.reference))
            .map(|(a, b)| (0.5 + 2.0 * (a - b)).clamp(0.0, 1.0).powf(2.2))
            .collect();
        let tiles = [&all.plate, &all.reference, &all.ours, &all.plain, &error];
        for (index, tile) in tiles.iter().enumerate() {
            for (k, light) in tile.iter().enumerate() {
                let shown = (light.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
                let (x, y) = (index * WIDTH + k % WIDTH, line * HEIGHT + k / WIDTH);
                picture.put_pixel(x as u32, y as u32, image::Luma([shown]));
            }
        }
    }
    let file = std::path::Path::new(&folder).join("depth-edges.png");
    picture.save(file).expect("the folder can be written");
}

/// Prints a row of the table: frame and edges, with and without occlusion.
fn print_row(name: &str, all: &Pictures) {
    let (inside, band) = compared(&all.vergence);
    let score = |got: &[f32], pixels: &[usize]| {
        if pixels.is_empty() {
            "-".to_owned()
        } else {
            format!("{:.1}", psnr(got, &all.reference, pixels))
        }
    };
    println!(
        "| {name} | {} | {} | {} | {} |",
        score(&all.ours, &inside),
        score(&all.plain, &inside),
        score(&all.ours, &band),
        score(&all.plain, &band),
    );
}
