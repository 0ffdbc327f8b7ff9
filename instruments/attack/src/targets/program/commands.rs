//! Command lines that succeed on the undamaged inputs.

use crate::case::{Case, Inputs};

/// Returns the command line of a case. The slow ones take a tenth of their turns.
pub(crate) fn command_of(case: &mut Case) -> &'static str {
    let turn = case.seed_index(COMMANDS.len());
    let quick = COMMANDS.len() - SLOW;
    let is_left_out = turn >= quick && case.inputs == Inputs::Damaged && !case.rng.once_in(10);
    COMMANDS[if is_left_out {
        case.rng.below(quick)
    } else {
        turn
    }]
}

/// Command lines at the end of the list that take ten times as long as the others.
const SLOW: usize = 3;

/// One command line each. Words are separated by spaces.
pub(crate) const COMMANDS: &[&str] = &[
    "apply --lens lens.json --quality draft plate.exr -o out.exr",
    "apply --lens lens.json --distance 2 --quality draft --compression piz plate.exr -o out.exr",
    "apply --lens lens.json --distance 1.5 --amount 0.5 --geometry full --edges black plate.exr -o out.exr --quality draft",
    "apply --lens lens.json --depth plate.exr:Z --depth-unit 1 --holdout plate.exr:A --quality draft plate.exr -o out.exr",
    "apply --lens lens.json --distance 3 --channel-scale R=1.2,B=0.9 --axis-offset 1,-2 plate.exr -o out.exr --quality draft",
    "apply --lens lens.json --distance 3 --focus-distance 2.5 --f-number 1.4 plate.exr -o out.exr --quality draft",
    "apply --lens lens.json --distance 3 --memory 2G --threads 1 --provenance full plate.exr -o out.tif --quality draft",
    "apply --lens lens.json --distance 3 --encoding srgb plate.png -o out.png --quality draft",
    "apply --lens lens.json --distance 3 --encoding srgb plate.tif -o out.exr --quality draft",
    "apply --lens lens.json --distance 3 --encoding linear plate.dpx -o out.dpx --quality draft",
    "apply --lens lens.json --distance 3 plate.hdr -o out.hdr --quality draft",
    "apply --lens lens.json --distance 3 --encoding srgb plate.jpg -o out.exr --quality draft",
    "remove --lens lens.json --distance 2 plate.exr -o out.exr",
    "remove --lens lens.json --distance 2 --strength 0.5 --grain solved plate.exr -o out.exr",
    "relens --from lens.json --to lens.json --distance 2 plate.exr -o out.exr",
    "lut plate.exr -o out.exr --in-space ACEScg --out-space ACES2065-1",
    "lut -o out.cube --in-space ACEScg --out-space ACES2065-1 --size 9 --range 0,1",
    "lut --list --ocio config.ocio",
    "lut plate.exr -o out.exr --ocio config.ocio --in-space Camera --out-space ACEScg",
    "info plate.exr",
    "info --json plate.exr plate.png plate.tif plate.dpx plate.hdr plate.jpg",
    "lens schema",
    "psf --lens lens.json --like set --out out --f-number 1.4",
    "fit set --model moments -o out.json",
    "lens show lens.json -o sheet.png",
    "eval --lens lens.json set --splits 2",
    "eval --lens lens.json set --only list.txt --json",
];
