//! Transforms and their lengths. Not in the library: it would be compiled once more, with all algorithms.

use seidel_fourier::{Planner, fast_length};

#[test]
fn fast_lengths_are_even_and_smooth() {
    let lengths = [1, 7, 50, 90, 91, 97, 129, 1023].map(fast_length);
    assert_eq!(lengths, [2, 8, 50, 90, 96, 100, 144, 1024]);
}

#[test]
fn the_inverse_of_a_transform_is_its_input_times_the_length() {
    let mut planner = Planner::<f64>::new();
    let input: Vec<f64> = (0..12).map(|k| f64::from(k * k % 7)).collect();
    let (forward, inverse) = (planner.real_forward(12), planner.real_inverse(12));
    let mut spectrum = forward.make_output_vec();
    forward
        .process(&mut input.clone(), &mut spectrum)
        .expect("buffers were made for this length");
    let mut back = inverse.make_output_vec();
    inverse
        .process(&mut spectrum, &mut back)
        .expect("buffers were made for this length");
    for (a, b) in back.iter().zip(&input) {
        assert!((a - 12.0 * b).abs() < 1e-12, "{a} {b}");
    }
}
