//! The command line of `seidel-ofx-host`.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use crate::checks::ALL;
use crate::drive::binary_path;
use crate::files;
use crate::panel;
use crate::render_job::{ClipFile, RenderJob};
use crate::result_files;
use crate::runner::{Outcome, child_main, print_line, run_all, run_in_process, select, summarize};
use crate::subject::Subject;

const HELP: &str = "\
Usage: seidel-ofx-host PLUGIN [--kind KIND] [--id ID] [--json FILE] [--junit FILE] [--in-process] [CHECK...]

Runs all checks, or those whose names contain CHECK, on the plugin in a binary (.ofx) or bundle. Prints one line per
check, then the causes of faults, those of most checks first. The exit status is 0 if all checks pass, 1 if any fails,
2 if the command line is wrong or there is no such plugin.

  --kind KIND    the kind of plugin, whose parameters the checks use: any (the default), box, seidel
  --id ID        the plugin's identifier, if the binary has several plugins
  --json FILE    writes the results as JSON
  --junit FILE   writes the results as XML in the format of JUnit, which build servers read
  --in-process   runs all checks in this process, for debuggers and memory checkers
  --list         lists the checks

       seidel-ofx-host PLUGIN --panel [--host HOST]

Prints the panel of the plugin's parameters in the order in which the host shows it.

       seidel-ofx-host PLUGIN --render OUT --feed CLIP=FILE... [--set PARAMETER=VALUE...]

Renders one image to OUT, .exr or .png (sRGB). Fails if the plugin fails or misuses the host.

  --feed CLIP=FILE[:CHANNEL]  connects a clip to an OpenEXR file: its colour, or one channel
  --set PARAMETER=VALUE       sets a parameter: a number, several numbers separated by commas, on or off, an option of
                              a menu, or a string; presses a button
  --host HOST                 the kind of host: complete (the default), nuke, resolve, natron, ...
  --time TIME                 the frame; 0 by default
  --half                      writes the image at half its size
  --overlay                   draws the plugin's overlay over the image";

/// The arguments of the command.
struct Arguments {
    plugin: Option<PathBuf>,
    kind: String,
    id: Option<String>,
    in_process: bool,
    json: Option<PathBuf>,
    junit: Option<PathBuf>,
    filters: Vec<String>,
    /// The file to render to, instead of running checks.
    render: Option<PathBuf>,
    job: RenderJob,
    half: bool,
    help: bool,
    list: bool,
    panel: bool,
}

impl Arguments {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut parsed = Self {
            plugin: None,
            kind: "any".to_owned(),
            id: None,
            in_process: false,
            json: None,
            junit: None,
            filters: Vec::new(),
            render: None,
            job: RenderJob::default(),
            half: false,
            help: false,
            list: false,
            panel: false,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || {
                arguments
                    .next()
                    .ok_or_else(|| format!("{argument}: give a value"))
            };
            match argument.as_str() {
                "--kind" => parsed.kind = value()?,
                "--id" => parsed.id = Some(value()?),
                "--json" => parsed.json = Some(PathBuf::from(value()?)),
                "--junit" => parsed.junit = Some(PathBuf::from(value()?)),
                "--in-process" => parsed.in_process = true,
                "--render" => parsed.render = Some(PathBuf::from(value()?)),
                "--feed" => parsed.job.feeds.push(clip_file(&value()?)?),
                "--set" => parsed.job.settings.push(assignment(&argument, &value()?)?),
                "--host" => parsed.job.host = value()?,
                "--time" => {
                    let time = value()?;
                    parsed.job.time = time
                        .parse()
                        .map_err(|_| format!("--time {time}: give a number"))?;
                }
                "--overlay" => parsed.job.overlay = true,
                "--half" => parsed.half = true,
                "--help" | "-h" => parsed.help = true,
                "--list" => parsed.list = true,
                "--panel" => parsed.panel = true,
                option if option.starts_with('-') => {
                    return Err(format!("{option}: unknown option"));
                }
                _ if parsed.plugin.is_none() => parsed.plugin = Some(PathBuf::from(argument)),
                _ => parsed.filters.push(argument),
            }
        }
        Ok(parsed)
    }
}

/// Splits `NAME=VALUE`.
fn assignment(option: &str, text: &str) -> Result<(String, String), String> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| format!("{option} {text}: write NAME=VALUE"))?;
    Ok((name.to_owned(), value.to_owned()))
}

/// Parses `CLIP=FILE[:CHANNEL]`. A colon that is part of an existing file's name separates no channel.
fn clip_file(text: &str) -> Result<ClipFile, String> {
    let (clip, name) = assignment("--feed", text)?;
    let (file, channel) = match name.rsplit_once(':') {
        Some((file, channel)) if !PathBuf::from(&name).exists() => (file, Some(channel.to_owned())),
        _ => (name.as_str(), None),
    };
    Ok(ClipFile {
        clip,
        file: PathBuf::from(file),
        channel,
    })
}

/// Runs the command.
#[must_use]
pub fn main() -> ExitCode {
    if let Some(code) = child_main() {
        return code;
    }
    let run = Arguments::parse(std::env::args().skip(1)).and_then(run);
    run.unwrap_or_else(|error| {
        eprintln!("{error}; see --help");
        ExitCode::from(2)
    })
}

fn run(arguments: Arguments) -> Result<ExitCode, String> {
    if arguments.help {
        print_line!("{HELP}");
        return Ok(ExitCode::SUCCESS);
    }
    if arguments.list {
        for check in ALL {
            print_line!("{:<24} {}", check.name, check.about);
        }
        return Ok(ExitCode::SUCCESS);
    }
    let plugin = arguments.plugin.ok_or("give a plugin")?;
    let binary = binary_path(&plugin);
    if !binary.is_file() {
        return Err(format!("{}: there is no such plugin", binary.display()));
    }
    if arguments.panel {
        let job = RenderJob {
            plugin,
            id: arguments.id,
            ..arguments.job
        };
        print_line!("{}", panel::text(&job.panel()?));
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(output) = arguments.render {
        let job = RenderJob {
            plugin,
            id: arguments.id,
            ..arguments.job
        };
        let written = job.run().and_then(|picture| {
            let half = arguments.half.then(|| picture.half_scale());
            files::write(&output, half.as_ref().unwrap_or(&picture))
        });
        return Ok(written.map_or_else(
            |error| {
                eprintln!("{error}");
                ExitCode::FAILURE
            },
            |()| ExitCode::SUCCESS,
        ));
    }
    let subject = Subject::new(plugin, &arguments.kind, arguments.id)?;
    if select(&arguments.filters).is_empty() {
        let filters = arguments.filters.join(", ");
        return Err(format!("{filters}: no check has such a name; see --list"));
    }
    let outcomes: Vec<Outcome> = if arguments.in_process {
        (select(&arguments.filters).into_iter())
            .map(|check| {
                let outcome = run_in_process(check, &subject);
                print_line!("{}", outcome.lines());
                outcome
            })
            .collect()
    } else {
        run_all(&subject, &arguments.filters, |outcome| {
            print_line!("{}", outcome.lines());
        })
    };
    let files = [
        (arguments.json, result_files::json(&subject, &outcomes)),
        (arguments.junit, result_files::junit(&subject, &outcomes)),
    ];
    for (file, text) in files {
        if let Some(file) = file {
            std::fs::write(&file, text).map_err(|e| format!("{}: {e}", file.display()))?;
        }
    }
    Ok(summarize(&outcomes))
}
