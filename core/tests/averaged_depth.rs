//! Depth averaged over the motion of a shutter, divided between both sides of its edges.

use seidel_core::{Depth, DepthPass, Image, Lens, Plate, Settings, apply, no_progress};

const WIDTH: usize = 192;
const HEIGHT: usize = 108;
/// Distances of a disc and of the wall behind it, metres.
const DISC_M: f32 = 1.5;
const WALL_M: f32 = 9.0;
/// Way of the disc while the shutter is open, px.
const WAY_PX: usize = 12;

/// Samples of a plate with their distances: red, green, blue and metres.
type Frame = Vec<[f32; 4]>;

/// Returns the plate at a moment: a textured disc that has come `way` pixels, before a textured wall.
fn moment(way: f32) -> Frame {
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x as f32, y as f32)));
    let pixel = |(x, y): (f32, f32)| {
        let (u, v) = (x - 80.0 - way, y - 54.0);
        if u.hypot(v) < 26.0 {
            let tone = 0.6 + 0.2 * (0.7 * u).sin() * (0.5 * v).cos();
            [tone, 0.8 * tone, 0.5 * tone, DISC_M]
        } else {
            let tone = 0.2 + 0.1 * (0.6 * x).sin() * (0.4 * y).cos();
            [0.6 * tone, 0.8 * tone, tone, WALL_M]
        }
    };
    pixels.map(pixel).collect()
}

/// Returns the mean of frames.
fn mean(frames: &[Frame]) -> Frame {
    let at = |index: usize| {
        let sum = |k: usize| frames.iter().map(|frame| frame[index][k]).sum::<f32>();
        [0, 1, 2, 3].map(|k| sum(k) / frames.len() as f32)
    };
    (0..WIDTH * HEIGHT).map(at).collect()
}

/// Returns `frame` through a lens, its depth stated as averaged over `averaged_px`.
fn rendered(frame: &Frame, averaged_px: f64) -> Frame {
    let lens = Lens::from_json(include_str!("data/lens.json")).expect("a lens profile");
    let samples: Vec<f32> = frame.iter().flat_map(|pixel| pixel[..3].to_vec()).collect();
    let image = Image::from_interleaved(WIDTH, HEIGHT, 3, &samples).expect("an image");
    let mut pass = DepthPass::metres(frame.iter().map(|pixel| pixel[3]).collect());
    pass.meaning.averaged_px = averaged_px;
    let plate = Plate::new(image).with_depth(Depth::Pass(pass));
    let image = apply(&lens, &plate, &Settings::default(), &no_progress).expect("a render");
    let at = |index: usize| {
        let [r, g, b] = [0, 1, 2].map(|k| image.colours[k][index]);
        [r, g, b, 0.0]
    };
    (0..WIDTH * HEIGHT).map(at).collect()
}

/// Returns the PSNR of `frame` against `truth`, peak 1, dB.
fn psnr_db(frame: &Frame, truth: &Frame) -> f64 {
    let pairs = frame.iter().zip(truth);
    let squares = pairs.flat_map(|(a, b)| (0..3).map(move |k| f64::from(a[k] - b[k]).powi(2)));
    -10.0 * (squares.sum::<f64>() / (3 * WIDTH * HEIGHT) as f64).log10()
}

#[test]
fn depth_averaged_over_a_motion_is_divided_as_the_moments_were() {
    let moments: Vec<Frame> = (0..WAY_PX).map(|way| moment(way as f32)).collect();
    let of_moments: Vec<Frame> = moments.iter().map(|frame| rendered(frame, 0.0)).collect();
    let truth = mean(&of_moments);
    let plate = mean(&moments);
    let as_it_is = psnr_db(&rendered(&plate, 0.0), &truth);
    let divided = psnr_db(&rendered(&plate, WAY_PX as f64 + 1.0), &truth);
    assert!(
        divided > as_it_is + 6.0,
        "{as_it_is:.1} dB as it is, {divided:.1} dB divided"
    );
}

#[test]
fn depth_of_one_sample_a_pixel_does_not_change() {
    let frame = moment(3.0);
    assert_eq!(rendered(&frame, 32.0), rendered(&frame, 0.0));
}

#[test]
fn a_width_out_of_range_is_refused_by_name() {
    let mut pass = DepthPass::metres(vec![1.0; 16]);
    pass.meaning.averaged_px = -2.0;
    let image = Image::from_interleaved(4, 4, 3, &[0.5; 48]).expect("an image");
    let lens = Lens::from_json(include_str!("data/lens.json")).expect("a lens profile");
    let plate = Plate::new(image).with_depth(Depth::Pass(pass));
    let error = apply(&lens, &plate, &Settings::default(), &no_progress).expect_err("out of range");
    assert!(error.to_string().contains("averaged depth"), "{error}");
}
