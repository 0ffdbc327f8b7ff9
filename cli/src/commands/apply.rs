//! `seidel apply`: blur a plate with a lens, pixel by pixel of field, channel and depth.

mod adjust;
mod depth;
mod depth_check;
mod focus;
mod frame;
mod memory;
mod occlusion;
mod plate;
mod queue;
mod rendering;
mod setup;
mod verbose;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use clap::{Args, ValueEnum};
use rayon::{ThreadPool, ThreadPoolBuilder};
use seidel_core::render::{Displacement, Edges, Gather, Quality, Renderer, Scatter, VergencePass};

use super::drawing::DrawingArgs;
use super::{CommandError, read_lens};
use crate::Console;
use crate::files::animation::Animation;
use crate::files::atomic::check_target;
use crate::files::error::FileError;
use crate::files::sequence::{Step, expand};
use adjust::AdjustArgs;
use depth::DepthArgs;
use focus::FocusArgs;
use frame::Job;
use memory::{DEFAULT_MEMORY, parse_size};
use occlusion::OcclusionArgs;
use plate::PlateArgs;
use setup::Settings;

/// Options of `seidel apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// The plate: OpenEXR, PNG or TIFF; may hold a frame pattern such as plate.%04d.exr
    #[arg(value_name = "IN")]
    input: String,
    /// Where to write the blurred plate, in the same format
    #[arg(short, long, value_name = "OUT")]
    output: String,
    /// The lens profile
    #[arg(long)]
    lens: PathBuf,
    /// Frames to render where IN and OUT hold a frame pattern, such as 1001-1100 or 1-9x2
    #[arg(long)]
    frames: Option<String>,
    #[command(flatten)]
    depth: DepthArgs,
    #[command(flatten)]
    occlusion: OcclusionArgs,
    #[command(flatten)]
    plate: PlateArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    adjust: AdjustArgs,
    #[command(flatten)]
    focus: FocusArgs,
    /// Values by frame of --amount, --focus-distance, --f-number and others: CSV with a column `frame` and one an
    /// option, or JSON; between frames that have a value it changes evenly
    #[arg(long, value_name = "FILE")]
    animate: Option<PathBuf>,
    /// Which displacement of light to render
    #[arg(long, value_enum, default_value_t = Geometry::Lateral)]
    geometry: Geometry,
    /// What lies beyond the plate's edges
    #[arg(long, value_enum, default_value_t = EdgeChoice::Mirror)]
    edges: EdgeChoice,
    /// How near to the exact renderer's result: draft (45 dB), final (60 dB, 75 dB where no blur is above 6 px; 50 dB
    /// for lenses drawn ray by ray) or exact
    #[arg(long, value_enum, default_value_t = QualityChoice::Final)]
    quality: QualityChoice,
    /// Threads to blur with; all cores if left out
    #[arg(long)]
    threads: Option<usize>,
    /// Memory for the frames of a sequence that are read, blurred and written at once, such as 500M
    /// or 4G; one frame is always in flight
    #[arg(long, value_name = "SIZE", default_value = DEFAULT_MEMORY, value_parser = parse_size)]
    memory: u64,
    /// Render frames of a sequence again whose output exists already; they are skipped otherwise
    #[arg(long)]
    overwrite: bool,
    /// Say of each frame how it was rendered, and how near that is to the exact renderer: measured at 64 pixels
    /// spread over the plate, as PSNR in dB of the plate's peak. Takes longer
    #[arg(long)]
    verbose: bool,
}

/// Which renderer draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityChoice {
    /// For looking: 45 dB
    Draft,
    /// For delivery: 60 dB
    Final,
    /// Every source pixel with its own kernel: slow
    Exact,
}

impl QualityChoice {
    fn renderer(self) -> Box<dyn Renderer> {
        let gather = |quality| Box::new(Gather { quality });
        match self {
            Self::Draft => gather(Quality::Draft),
            Self::Final => gather(Quality::Final),
            Self::Exact => Box::new(Scatter),
        }
    }
}

/// Displacement of light by the lens.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Geometry {
    /// Blur alone
    None,
    /// Lateral colour: channels shifted against each other, the plate undistorted
    Lateral,
    /// Distortion and lateral colour
    Full,
}

/// What lies beyond the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EdgeChoice {
    /// The mirrored plate: no light is lost
    Mirror,
    /// Nothing: light that leaves is lost
    Black,
    /// The pixel nearest to it on the plate, with its depth and blur
    Extend,
}

impl From<Geometry> for Displacement {
    fn from(geometry: Geometry) -> Self {
        match geometry {
            Geometry::None => Self::None,
            Geometry::Lateral => Self::Lateral,
            Geometry::Full => Self::Full,
        }
    }
}

impl From<EdgeChoice> for Edges {
    fn from(choice: EdgeChoice) -> Self {
        match choice {
            EdgeChoice::Mirror => Self::Mirror,
            // What extends a plate does without the renderer's own way.
            EdgeChoice::Black | EdgeChoice::Extend => Self::Black,
        }
    }
}

pub(super) fn run(args: &ApplyArgs, console: &mut Console) -> Result<(), CommandError> {
    let measured = read_lens(&args.lens)?;
    let mut said = Vec::new();
    let setup = args.settings().open(&measured, &args.lens, &mut said)?;
    for remark in said {
        console.remark(remark);
    }
    let animation = args.animate.as_deref().map(Animation::open).transpose()?;
    let depth = args.depth.source()?;
    depth.check_lens(&setup.drawing.predictor, &args.lens)?;
    let holdout = args.occlusion.source()?;
    let mut patterns = vec![args.input.as_str(), args.output.as_str()];
    patterns.extend(depth.file_pattern());
    patterns.extend(holdout.file_patterns());
    let all = expand(&patterns, args.frames.as_deref())?;
    if let Some(table) = &animation {
        setup::check_names(table)?;
        if all.iter().any(|step| step.frame.is_none()) {
            return Err(CommandError::Usage(
                "--animate needs frames: give IN and OUT a frame pattern, and --frames".to_owned(),
            ));
        }
    }
    for step in &all {
        keeps_inputs(step, &args.lens)?;
        check_target(&step.paths[1])?;
    }
    let steps: Vec<&Step> = all.iter().filter(|step| !args.is_done(step)).collect();
    if steps.len() < all.len() {
        console.remark(format!(
            "{} of {} frames exist already and are skipped; give --overwrite to render them again",
            all.len() - steps.len(),
            all.len()
        ));
    }
    let bar = console.progress("blurring");
    let share = Mutex::new(0.0_f64);
    let count = steps.len();
    let progress = |index: usize, part: f64| {
        // A late word from another thread must not turn the bar back.
        let now = (index as f64 + part) / count as f64;
        if let Ok(mut shown) = share.lock()
            && now > *shown
        {
            *shown = now;
            bar.set(now);
        }
    };
    let job = Job {
        args,
        measured: &measured,
        setup: Arc::new(setup),
        animation: animation.as_ref(),
        depth: &depth,
        holdout: &holdout,
        meaning: args.depth.meaning()?,
        steps: &steps,
        reading: &pool(args.threads)?,
        blurring: &pool(args.threads)?,
        progress: &progress,
    };
    let mut failed = Vec::new();
    queue::run_all(&job, count, args.memory, |index, outcome| {
        bar.hidden(|| tell(steps[index], outcome, console, &mut failed));
    });
    drop(bar);
    match failed.len() {
        0 => Ok(()),
        1 if count == 1 => Err(failed.remove(0).1),
        _ => Err(CommandError::Frames { failed, count }),
    }
}

/// Says what became of a frame, or keeps for the end why it failed.
fn tell(
    step: &Step,
    outcome: queue::Outcome,
    console: &mut Console,
    failed: &mut Vec<(i64, CommandError)>,
) {
    let prefix = step
        .frame
        .map_or_else(String::new, |frame| format!("frame {frame}: "));
    match outcome {
        Ok(said) => {
            for line in said {
                console.remark(format!("{prefix}{line}"));
            }
            console.say(format!("wrote {}", step.paths[1].display()));
        }
        Err(error) => {
            if step.frame.is_some() {
                console.remark(format!("{prefix}failed; the end of this run says why"));
            }
            failed.push((step.frame.unwrap_or(0), error));
        }
    }
}

fn pool(threads: Option<usize>) -> Result<ThreadPool, CommandError> {
    ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|e| CommandError::Usage(format!("--threads: {e}")))
}

impl ApplyArgs {
    /// How the lens is to be where no table says otherwise.
    fn settings(&self) -> Settings {
        Settings {
            drawing: self.drawing.clone(),
            adjust: self.adjust.clone(),
            focus: self.focus.clone(),
        }
    }

    /// Whether a frame of a sequence was rendered by an earlier run: outputs are whole or not there.
    fn is_done(&self, step: &Step) -> bool {
        step.frame.is_some() && !self.overwrite && step.paths[1].exists()
    }
}

/// Refuses an output that would take the place of a file the run reads.
fn keeps_inputs(step: &Step, lens: &Path) -> Result<(), CommandError> {
    let output = &step.paths[1];
    // An output that does not exist yet replaces nothing.
    let Ok(target) = output.canonicalize() else {
        return Ok(());
    };
    let inputs = step.paths.iter().enumerate().filter(|(k, _)| *k != 1);
    let lost = inputs
        .map(|(_, path)| path.as_path())
        .chain([lens])
        .any(|path| path.canonicalize().is_ok_and(|p| p == target));
    if !lost {
        return Ok(());
    }
    Err(FileError::new(
        output,
        "",
        "is read by this command and would be overwritten",
        "give another name to -o",
    )
    .into())
}

/// Object vergence of a plate's pixels, 1/m.
enum Vergences {
    Constant(f64),
    PerPixel(Vec<f32>),
}

impl Vergences {
    fn pass(&self) -> VergencePass<'_> {
        match self {
            Self::Constant(v) => VergencePass::Constant(*v),
            Self::PerPixel(pass) => VergencePass::PerPixel(pass),
        }
    }
}
