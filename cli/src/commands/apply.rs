//! `seidel apply`: blurs a plate with a lens, by field position, channel and depth.

mod frame;
mod occlusion;
mod residual;
mod show;
mod verbose;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::{Edges, Expand, MaskScales, Settings};

use super::knobs::{ApplyKnobs, knob_text};
use super::plates::{
    Files, LensUse, LookArgs, PlateCommandArgs, PlateReader, SettingsRecord, SideInputs,
    channel_parser, setting,
};
use super::{CommandError, short_name, value_name};
use crate::Console;
use crate::progress::ProgressArgs;
use frame::Job;
use occlusion::OcclusionArgs;
use seidel_image_io::formats::exr;
use seidel_image_io::image_channel::ChannelSpec;
use show::ShowChoice;

/// Options of `seidel apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// Lens profile, or library:NAME
    #[arg(long, help_heading = "Input")]
    lens: PathBuf,
    #[command(flatten)]
    shared: PlateCommandArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    occlusion: OcclusionArgs,
    #[command(flatten)]
    knobs: ApplyKnobs,
    /// Residual that `seidel remove --residual` wrote beside IN, or a frame pattern
    ///
    /// It is added where IN was not changed, which restores the original plate there. OUT has the pixels of that plate.
    #[arg(long, help_heading = "Input", value_name = "FILE")]
    residual: Option<PathBuf>,
    /// Mask: the plate keeps its own pixels where it is 0; or a frame pattern. Its A, its only channel, or CHANNEL
    ///
    /// The plate is blurred as without it, so light of a masked object still reaches its surroundings. With --mask-scales blur the mask
    /// scales the blur itself, which takes that away.
    #[arg(long, help_heading = "Look", value_name = "FILE[:CHANNEL]", value_parser = channel_parser(), conflicts_with = "residual")]
    mask: Option<ChannelSpec>,
    /// Use 1 less the mask
    #[arg(long, help_heading = "Look", requires = "mask")]
    invert_mask: bool,
    /// Only the lens's axial and lateral colour, without the blur that all colours share
    ///
    /// At each place and distance the sharpest colour stays sharp, and the others blur by as much as their variance exceeds its own.
    #[arg(long, help_heading = "Look", conflicts_with = "residual")]
    only_chroma: bool,
    /// Picture of the blur by depth, instead of the plate
    #[arg(long, value_enum, help_heading = "Output", value_name = "PICTURE", conflicts_with_all = ["residual", "verbose"])]
    show: Option<ShowChoice>,
    /// Growth of the circle of confusion over that in the plane of focus up to which --show counts a pixel as in focus
    #[arg(long, help_heading = "Output", value_name = "PX", default_value_t = show::IN_FOCUS_PX, requires = "show", value_parser = show::parse_tolerance)]
    focus_tolerance: f32,
    /// Report the method and the accuracy of every render; takes longer
    ///
    /// Accuracy is the PSNR in dB of the plate's peak against the exact renderer, at 64 pixels spread over the plate.
    #[arg(long, help_heading = "Run")]
    verbose: bool,
}

impl ApplyArgs {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        self.shared.run.progress
    }

    /// Returns the `settings` of a render with these `edges` by name, without those of lens and plate.
    fn record(&self, settings: &Settings, edges: Edges) -> SettingsRecord {
        let mut record = rendering_record(&of_edges(settings, edges), &self.occlusion.record());
        if settings.mix != 1.0 {
            record.push(setting("mix", settings.mix));
        }
        if settings.mask_scales != MaskScales::Mix {
            record.push(setting("mask_scales", knob_text("mask-scales", settings)));
        }
        if self.only_chroma {
            record.push(setting("only_chroma", true));
        }
        if self.invert_mask {
            record.push(setting("invert_mask", true));
        }
        record.extend(
            self.mask
                .as_ref()
                .map(|mask| setting("mask", short_name(&mask.file))),
        );
        record
    }
}

/// Returns `settings` with the edges that a plate was rendered with.
fn of_edges(settings: &Settings, edges: Edges) -> Settings {
    let mut settings = settings.clone();
    settings.edges = Some(edges);
    settings
}

fn rendering_record(settings: &Settings, occlusion: &str) -> SettingsRecord {
    vec![
        setting("quality", knob_text("quality", settings)),
        setting("edges", knob_text("edges", settings)),
        setting("occlusion", occlusion),
    ]
}

/// Returns the settings of a render by name with all options of `apply` at their defaults, without those of lens and
/// plate.
pub(super) fn default_rendering_record() -> SettingsRecord {
    rendering_record(&of_edges(&Settings::default(), Edges::Mirror), "on")
}

pub(super) fn run(
    args: &ApplyArgs,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let mut settings = Settings::default();
    args.knobs.put(&mut settings)?;
    if settings.mask_scales != MaskScales::Mix && args.mask.is_none() {
        let problem = "--mask-scales needs a mask: give --mask, or leave it out";
        return Err(CommandError::Usage(problem.to_owned()));
    }
    if args.residual.is_some() {
        if settings.mix != 1.0 {
            let problem = "--mix and --residual cannot be combined: leave one of the two out";
            return Err(CommandError::Usage(problem.to_owned()));
        }
        // The residual is the rest of a render of the plate's own pixels with mirrored edges.
        settings.edges = settings.edges.or(Some(Edges::Mirror));
        settings.expand = Expand::Never;
    }
    settings.occlusion = args.occlusion.settings();
    settings.only_chroma = args.only_chroma;
    let look = LensUse::Apply(&args.look, &args.knobs);
    let mut reader = PlateReader::open(&args.lens, &args.shared, look, settings, console)?;
    args.occlusion.check()?;
    if let Some(choice) = args.show.filter(|choice| choice.is_numbers())
        && exr::FORMAT.check_name(&args.shared.output).is_err()
    {
        return Err(CommandError::Usage(format!(
            "--show {} writes numbers, which only EXR files hold as they are; name OUT .exr",
            value_name(choice)
        )));
    }
    let files = Files {
        input: &args.shared.input,
        output: &args.shared.output,
        read: SideInputs {
            depth: args.shared.depth.depth.clone(),
            residual: args.residual.clone(),
            mask: args.mask.clone(),
            invert_mask: args.invert_mask,
            aperture_picture: args.look.files().next().map(Path::to_owned),
            ..args.occlusion.side_inputs()
        },
        written: Vec::new(),
        lenses: (args.shared.lens).files_with(vec![("Lens", &args.lens)]),
    };
    let task = if args.show.is_some() {
        "drawing"
    } else {
        "blurring"
    };
    let run = (args.shared.run).begin(task, &files, command_line, console)?;
    reader.begin(&run, console)?;
    let job = Job {
        args,
        reader: &reader,
        run: &run,
    };
    run.process(&job, console)
}
