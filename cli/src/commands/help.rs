//! The command line as a whole: the examples of each help, and the options that `-h` shows.

use clap::{Arg, CommandFactory};

use super::Cli;

/// A help: its command, examples of command lines, and the options that `-h` shows.
struct Help {
    /// Names of the command and its subcommand.
    command: &'static str,
    /// Each example with its purpose.
    examples: &'static [Example],
    /// The usual options, by name; all if empty. `--help` shows the others, too.
    usual: &'static [&'static str],
}

/// A command line, without the name of the program.
struct Example {
    purpose: &'static str,
    line: &'static str,
}

const fn example(purpose: &'static str, line: &'static str) -> Example {
    Example { purpose, line }
}

const HELPS: &[Help] = &[
    Help {
        command: "demo",
        examples: &[example("Make the example files", "demo seidel-demo")],
        usual: &[],
    },
    Help {
        command: "measure lights",
        examples: &[example(
            "Photograph of a pinhole chart at 3 m, and the lens fitted to it",
            "measure lights chart.dng --distance 3 --out chart --fit lens.json",
        )],
        usual: &[
            "out", "distance", "channels", "axis", "dark", "flat", "cfa", "fit", "also", "tile",
            "min-snr",
        ],
    },
    Help {
        command: "measure chart",
        examples: &[example(
            "A printed noise chart at 2 m, and the lens fitted to it",
            "measure chart chart.dng --chart noise.png --distance 2 --out blocks --fit lens.json",
        )],
        usual: &[
            "out", "chart", "at", "distance", "channels", "axis", "dark", "cfa", "fit", "also",
            "tile",
        ],
    },
    Help {
        command: "measure pair",
        examples: &[example(
            "A scene stopped down, and the same scene wide open",
            "measure pair f11.dng f2.dng --distance 2 --out blocks --fit lens.json",
        )],
        usual: &[
            "out",
            "sharp-sigma-px",
            "distance",
            "channels",
            "axis",
            "dark",
            "cfa",
            "fit",
            "also",
            "tile",
        ],
    },
    Help {
        command: "measure edges",
        examples: &[example(
            "A chart of dark squares at 2 m, with a camera whose file does not state it",
            "measure edges chart.dng --distance 2 --out edges --fit lens.json --focal-length-mm 50 --f-number 2 --focus-distance 3 --pitch-um 4",
        )],
        usual: &[
            "out",
            "distance",
            "channels",
            "axis",
            "dark",
            "cfa",
            "encoding",
            "fit",
            "also",
            "force",
            "focal-length-mm",
            "f-number",
            "focus-distance",
            "pitch-um",
        ],
    },
    Help {
        command: "measure match",
        examples: &[example(
            "The lens of a plate with many sharp edges",
            "measure match plate.exr -o lens.json",
        )],
        usual: &[
            "output", "distance", "channels", "axis", "encoding", "sheet", "json",
        ],
    },
    Help {
        command: "measure print",
        examples: &[
            example(
                "A noise chart to print, and its picture for `measure chart`",
                "measure print noise -o noise.pdf -o noise.png --distance 2 --focal-length-mm 50 --pitch-um 4",
            ),
            example(
                "Slanted edges on a screen",
                "measure print edges -o edges.png --screen 3840x2160 --screen-width-mm 700",
            ),
        ],
        usual: &[],
    },
    Help {
        command: "measure plan",
        examples: &[example(
            "Distances and sizes for a 50 mm lens at f/2",
            "measure plan --focal-length-mm 50 --f-number 2 --focus-distance 3 --pitch-um 4",
        )],
        usual: &[],
    },
    Help {
        command: "fit",
        examples: &[
            example(
                "Fit a lens to PSFs",
                "fit seidel-demo/measured -o lens.json",
            ),
            example(
                "Sets at several distances, the optical axis estimated",
                "fit near far -o lens.json --axis free",
            ),
        ],
        usual: &[],
    },
    Help {
        command: "eval",
        examples: &[example(
            "Compare a lens with PSFs",
            "eval --lens lens.json seidel-demo/measured",
        )],
        usual: &[],
    },
    Help {
        command: "psf",
        examples: &[example(
            "The PSFs of a lens stopped down, at the places of a set",
            "psf --lens lens.json --like seidel-demo/measured --out predicted --f-number f/2.8",
        )],
        usual: &[],
    },
    Help {
        command: "lens show",
        examples: &[
            example("Describe a lens of the library", "lens show swirl-58"),
            example(
                "Draw the PSFs of a lens",
                "lens show lens.json -o sheet.png",
            ),
        ],
        usual: &[],
    },
    Help {
        command: "view",
        examples: &[
            example("Look at a lens", "view library:swirl-58 -o swirl.html"),
            example(
                "Measured PSFs, and those of the fitted lens beside them",
                "view seidel-demo/measured --lens seidel-demo/lens.json -o measured.html",
            ),
            example(
                "The findings of a diagnosis",
                "view report/report.json -o findings.html",
            ),
        ],
        usual: &[],
    },
    Help {
        command: "apply",
        examples: &[
            example(
                "A flat plate at 3 m",
                "apply --lens lens.json plate.png -o blurred.exr --distance 3",
            ),
            example(
                "A CG plate by its own depth pass, focused at 2.5 m, at f/2",
                "apply --lens lens.json cg.exr -o blurred.exr --focus-distance 2.5 --f-number f/2",
            ),
            example(
                "A sequence focused as its files say",
                "apply --lens lens.json plate.%04d.exr -o out.%04d.exr --frames 1001-1100 --lens-metadata plate",
            ),
            example(
                "The ovals and bubbles of an old anamorphic lens",
                "apply --lens library:modern-50 cg.exr -o look.exr --squeeze 2 --spherical 0.6 --cats-eye 0.5",
            ),
            example(
                "The circles of confusion of a plate, before it is blurred",
                "apply --lens lens.json cg.exr -o coc.png --show coc",
            ),
            example(
                "A sequence with its depth in other files, in centimetres",
                "apply --lens lens.json cg.%04d.exr --depth z.%04d.exr:Z --depth-unit cm -o out.%04d.exr --frames 1001-1100",
            ),
        ],
        usual: &[
            "lens",
            "depth",
            "distance",
            "depth-kind",
            "depth-unit",
            "focus-distance",
            "f-number",
            "lens-metadata",
            "amount",
            "blades",
            "in-space",
            "out-space",
            "output",
            "quality",
            "show",
            "frames",
            "skip-existing",
        ],
    },
    Help {
        command: "remove",
        examples: &[
            example(
                "Sharpen a plate taken at 3 m",
                "remove --lens lens.json plate.exr -o sharp.exr --distance 3",
            ),
            example(
                "Keep the rest, so that `apply --residual` gives the plate back",
                "remove --lens lens.json plate.exr -o sharp.exr --distance 3 --residual rest.exr",
            ),
        ],
        usual: &[
            "lens",
            "depth",
            "distance",
            "depth-unit",
            "focus-distance",
            "f-number",
            "lens-metadata",
            "amount",
            "output",
            "strength",
            "noise",
            "clip",
            "residual",
            "frames",
            "threads",
            "skip-existing",
        ],
    },
    Help {
        command: "relens",
        examples: &[example(
            "Give a plate of one lens the look of another",
            "relens --from modern.json --to vintage.json plate.exr -o out.exr --distance 3",
        )],
        usual: &[
            "from",
            "to",
            "depth",
            "distance",
            "depth-unit",
            "focus-distance",
            "f-number",
            "lens-metadata",
            "amount",
            "output",
            "noise",
            "clip",
            "frames",
            "threads",
            "skip-existing",
        ],
    },
    Help {
        command: "diagnose",
        examples: &[
            example(
                "Find what a lens lacks against PSFs",
                "diagnose --lens lens.json measured --out report",
            ),
            example(
                "The same from a raw photograph of lights at 2 m",
                "diagnose --lens lens.json --photo lights.dng --distance 2 --out report",
            ),
            example(
                "The same from a sharp picture and its photograph at 3 m",
                "diagnose --lens lens.json --reference sharp.exr --observed photo.exr --distance 3 --out report",
            ),
        ],
        usual: &[
            "lens",
            "out",
            "photo",
            "distance",
            "only",
            "design",
            "no-pairs",
            "reference",
            "observed",
            "plate-gap",
            "threads",
            "json",
        ],
    },
    Help {
        command: "info",
        examples: &[
            example(
                "Channels, windows and metadata of a picture, and what made it",
                "info blurred.exr",
            ),
            example(
                "Focus and aperture over a sequence, if its files state them",
                "info plate.%04d.exr",
            ),
        ],
        usual: &[],
    },
    Help {
        command: "lut",
        examples: &[example(
            "A table from camera log to ACEScg",
            "lut --in-space \"Sony S-Log3 S-Gamut3.Cine\" --out-space ACEScg -o log.cube",
        )],
        usual: &[],
    },
    Help {
        command: "completions",
        examples: &[example("Complete in Bash", "completions bash")],
        usual: &[],
    },
    Help {
        command: "man",
        examples: &[example(
            "Pages for `man seidel-apply`, where MANPATH names the folder",
            "man man/man1",
        )],
        usual: &[],
    },
];

/// Returns the command line with its helps. Options with a value take negative numbers, so that each can say itself why
/// it refuses one.
pub fn command() -> clap::Command {
    with_helps(Cli::command(), "")
}

/// Adds helps to `command`, whose name follows `before`.
fn with_helps(command: clap::Command, before: &str) -> clap::Command {
    let named = HELPS.iter().find(|help| help.command == before);
    let command = command.mut_args(|arg| {
        let takes_number = arg.get_action().takes_values() && !arg.is_positional();
        let is_hidden = named.is_some_and(|help| help.hides(&arg));
        arg.allow_negative_numbers(takes_number)
            .hide_short_help(is_hidden)
    });
    let command = match named {
        Some(help) => command.after_long_help(help.examples_text()),
        None => command,
    };
    let before = before.to_owned();
    command.mut_subcommands(move |subcommand| {
        let name = format!("{before} {}", subcommand.get_name());
        with_helps(subcommand, name.trim_start())
    })
}

impl Help {
    fn hides(&self, arg: &Arg) -> bool {
        let name = arg.get_long().unwrap_or_default();
        !self.usual.is_empty() && !arg.is_positional() && !self.usual.contains(&name)
    }

    fn examples_text(&self) -> String {
        let lines = (self.examples.iter())
            .map(|example| format!("  {}:\n    seidel {}", example.purpose, example.line));
        format!("Examples:\n{}", lines.collect::<Vec<_>>().join("\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Splits a command line at spaces outside quotes.
    fn words(line: &str) -> Vec<String> {
        let quoted = line.split('"').enumerate();
        let words = quoted.flat_map(|(k, part)| match k % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect(),
            _ => vec![part.to_owned()],
        });
        words.collect()
    }

    fn subcommand(path: &str) -> clap::Command {
        path.split(' ').fold(command(), |command, name| {
            let found = command.find_subcommand(name);
            found.expect("a command of this name").clone()
        })
    }

    #[test]
    fn the_command_line_is_sound() {
        command().debug_assert();
    }

    #[test]
    fn every_example_is_a_valid_command_line() {
        for help in HELPS {
            assert!(!help.examples.is_empty(), "{}", help.command);
            for example in help.examples {
                assert!(example.line.starts_with(help.command), "{}", example.line);
                let line = std::iter::once("seidel".to_owned()).chain(words(example.line));
                let parsed = command().try_get_matches_from(line);
                assert!(parsed.is_ok(), "{}: {:?}", example.line, parsed.err());
            }
        }
    }

    /// Adds the options of `command` and of its subcommands to `lines`: names, values and defaults.
    fn list_options(command: &clap::Command, before: &str, lines: &mut Vec<String>) {
        let path = format!("{before}{}", command.get_name());
        for arg in command.get_arguments() {
            let long = arg.get_long().map(|name| format!(" --{name}"));
            let short = arg.get_short().map(|name| format!(" -{name}"));
            let aliases = arg.get_all_aliases().unwrap_or_default();
            let aliases = aliases.iter().map(|name| format!(" --{name}"));
            let names: String = long.into_iter().chain(short).chain(aliases).collect();
            let names = if names.is_empty() {
                format!(" {}", arg.get_id())
            } else {
                names
            };
            let words: Vec<String> = (arg.get_possible_values().iter())
                .map(|value| value.get_name().to_owned())
                .collect();
            let defaults = arg.get_default_values().iter();
            let defaults: Vec<_> = defaults.map(|value| value.to_string_lossy()).collect();
            lines.push(format!(
                "{path}{names} [{}] = {}",
                words.join("|"),
                defaults.join(",")
            ));
        }
        for subcommand in command.get_subcommands() {
            list_options(subcommand, &format!("{path} "), lines);
        }
    }

    /// Scripts use these names. A new option is a new line; no other line changes.
    #[test]
    fn options_keep_their_names_values_and_defaults() {
        let mut lines = Vec::new();
        list_options(&command(), "", &mut lines);
        lines.sort();
        let found = lines.join("\n") + "\n";
        assert_eq!(found, include_str!("options.txt"), "found:\n{found}");
    }

    #[test]
    fn usual_options_exist() {
        for help in HELPS {
            let command = subcommand(help.command);
            for name in help.usual {
                let mut options = command.get_arguments();
                assert!(
                    options.any(|arg| arg.get_long() == Some(name)),
                    "{}: --{name}",
                    help.command
                );
            }
        }
    }

    #[test]
    fn short_helps_fit_on_a_screen() {
        // Wrapped at 100 columns where the width of the terminal is unknown.
        for help in HELPS {
            let text = subcommand(help.command).render_help().to_string();
            let lines = text.lines().count();
            assert!(lines <= 50, "{}: {lines} lines\n{text}", help.command);
        }
    }
}
