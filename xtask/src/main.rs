//! Development tasks. `cargo xtask tidy` checks the project's own rules, `header` writes the C header, `knobs` what else follows from the
//! table of knobs, `bundle` builds
//! the OpenFX bundle, `dist` the release archive, `attack` runs hostile inputs, `yardsticks` compares with simple programs, `endurance` long runs, `library` writes the lens
//! library, `luts` the colour config and its tables, `natron` compares with an installed Natron, and `pictures` draws the pictures of `docs/`.

mod attack;
mod bundle;
mod dist;
mod header;
mod knobs;
mod library;
mod luts;
mod natron;
mod pictures;
mod tidy;
mod workspace;
mod yardsticks;

use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask TASK
  tidy                        check the project's rules
  header                      write plugin/include/seidel.h
  knobs                       write the files that follow from the table of knobs: settings in Python, docs/guide/knobs.md
  attack [--minutes N] [--only TARGET,..] [OPTIONS]
                              damage inputs, kill runs and fill disks; `attack --help` lists the options
  yardsticks [OPTIONS]        every job beside the simplest program that could do it; writes docs/background/yardsticks.md
  endurance [RUN..]           long runs: sequence, c-abi, node, or all; `attack --help` lists the options
  bundle [--target TRIPLE].. [--install] [OPTIONS]
                              build the OpenFX bundle, and install it; `bundle --help` lists the options
  dist [--target TRIPLE] [--glibc VERSION] [--to FOLDER]
                              build the release archive of this platform, with notices and checksums
  library [--check]           write the lens library, core/optics/library, or check that it is up to date
  luts [--check]              write the colour config and tables of luts/, or check that they are up to date
  natron [--natron FILE]      render through an installed Natron, and compare with the command; skipped without one
  pictures [--programs FOLDER] [NAME...]
                              draw the pictures of docs/ from program output";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let task = arguments.next().unwrap_or_default();
    let root = workspace::root();
    let result = match task.as_str() {
        "tidy" => tidy::run(&root),
        "header" => header::write(&root),
        "knobs" => knobs::write(&root),
        "attack" => attack::run(&root, arguments),
        "endurance" => attack::endurance(&root, arguments),
        "yardsticks" => yardsticks::run(&root, arguments),
        "dist" => dist::run(&root, arguments),
        "bundle" => bundle::run(&root, arguments),
        "library" => library::run(&root, arguments),
        "luts" => luts::run(&root, arguments),
        "natron" => natron::run(&root, arguments),
        "pictures" => pictures::run(&root, arguments),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(report) => {
            println!("{report}");
            ExitCode::SUCCESS
        }
        Err(problem) => {
            eprintln!("{task}: {problem}");
            ExitCode::FAILURE
        }
    }
}
