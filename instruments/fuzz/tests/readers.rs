//! The readers of the attack under a fuzzer. `cargo test` runs the seeds, earlier findings and some random inputs of each on stable
//! Rust; coverage-guided runs are described in CONTRIBUTING.md.
#![forbid(unsafe_code)]

use std::fs;
use std::path::Path;

use seidel_attack::fuzz::FuzzTarget;

/// Random inputs that `cargo test` adds to the corpus.
const ITERATIONS: usize = 200;

/// Longest input, bytes.
const LONGEST: usize = 64 << 10;

/// Runs the target that the variable `READER` names, or all.
#[test]
fn readers() {
    let chosen = std::env::var("READER").ok();
    FuzzTarget::all(chosen.as_deref()).for_each(fuzz);
}

fn fuzz(target: FuzzTarget) {
    // Where bolero looks for inputs.
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/__fuzz__");
    let corpus = tests.join(target.name).join("corpus");
    fs::create_dir_all(&corpus).expect("writable");
    for (k, bytes) in target.seeds.iter().enumerate() {
        fs::write(corpus.join(format!("seed-{k}")), bytes).expect("writable");
    }
    bolero::check!(name = target.name)
        .with_iterations(ITERATIONS)
        .with_max_len(LONGEST)
        .for_each(|bytes: &[u8]| target.read(bytes));
}
