//! `seidel apply`: blur a plate with a lens, pixel by pixel of field, channel and depth.

mod depth;
mod plate;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use seidel_core::predict::Predictor;
use seidel_core::psf::PsfModel;
use seidel_core::render::{Displacement, Edges, Renderer, Scatter, Scene, VergencePass, stopped};

use super::CommandError;
use super::drawing::{Drawing, DrawingArgs};
use crate::Console;
use crate::files::error::FileError;
use crate::files::plate::Plate;
use crate::files::sequence::{Step, expand};
use depth::{DepthArgs, DepthSource};
use plate::{PlateArgs, plate_map, plate_weights};

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
    plate: PlateArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
    /// Which displacement of light to render
    #[arg(long, value_enum, default_value_t = Geometry::Lateral)]
    geometry: Geometry,
    /// What lies beyond the plate's edges
    #[arg(long, value_enum, default_value_t = EdgeChoice::Mirror)]
    edges: EdgeChoice,
    /// Threads to use; all cores if left out
    #[arg(long)]
    threads: Option<usize>,
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
#[derive(Debug, Clone, Copy, ValueEnum)]
enum EdgeChoice {
    /// The mirrored plate: no light is lost
    Mirror,
    /// Nothing: light that leaves is lost
    Black,
}

pub(super) fn run(args: &ApplyArgs, console: &mut Console) -> Result<(), CommandError> {
    let Drawing {
        predictor, model, ..
    } = args.drawing.open(&args.lens, console)?;
    let depth = args.depth.source()?;
    depth.check_lens(&predictor, &args.lens)?;
    let depth_file = depth.file_pattern();
    let mut patterns = vec![args.input.as_str(), args.output.as_str()];
    patterns.extend(depth_file);
    let steps = expand(&patterns, args.frames.as_deref())?;
    for step in &steps {
        keeps_inputs(step, &args.lens)?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.unwrap_or(0))
        .build()
        .map_err(|e| CommandError::Usage(format!("--threads: {e}")))?;
    let progress = console.progress("blurring");
    let count = steps.len() as f64;
    for (index, step) in steps.iter().enumerate() {
        let job = Job {
            args,
            predictor: &predictor,
            model,
            depth: &depth,
        };
        let said = pool.install(|| {
            job.frame(step, &|share| {
                progress.set((index as f64 + share) / count);
                true
            })
        })?;
        for line in said {
            match step.frame {
                Some(frame) => console.remark(format!("frame {frame}: {line}")),
                None => console.remark(line),
            }
        }
        console.say(format!("wrote {}", step.paths[1].display()));
    }
    Ok(())
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

/// What all frames of a run share.
struct Job<'a> {
    args: &'a ApplyArgs,
    predictor: &'a Predictor,
    model: &'static dyn PsfModel,
    depth: &'a DepthSource,
}

impl Job<'_> {
    /// Blurs one frame; returns what the user should know.
    fn frame(
        &self,
        step: &Step,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<String>, CommandError> {
        let args = self.args;
        let input = &step.paths[0];
        let mut said = Vec::new();
        let mut plate = Plate::open(input, &args.plate.options())?;
        let planes = args.plate.light(&plate, &mut said)?;
        let vergence = self.depth.read(
            &plate,
            step.paths.get(2).map(PathBuf::as_path),
            self.predictor,
            &mut said,
        )?;
        let weights =
            plate_weights(&plate, self.predictor).map_err(|e| FileError::from_core(input, e))?;
        let scene = Scene {
            lens: self.predictor,
            model: self.model,
            width: plate.width(),
            height: plate.height(),
            map: plate_map(&plate, self.predictor, args.plate.lens_scale),
            vergence: match &vergence {
                Vergences::Constant(v) => VergencePass::Constant(*v),
                Vergences::PerPixel(pass) => VergencePass::PerPixel(pass),
            },
            edges: match args.edges {
                EdgeChoice::Mirror => Edges::Mirror,
                EdgeChoice::Black => Edges::Black,
            },
            displacement: match args.geometry {
                Geometry::None => Displacement::None,
                Geometry::Lateral => Displacement::Lateral,
                Geometry::Full => Displacement::Full,
            },
        };
        let mut blurred = Scatter
            .render(&scene, &planes.with_weights(&weights), progress)
            .map_err(|e| {
                if e == stopped() {
                    CommandError::Core(e)
                } else {
                    FileError::from_core(input, e).into()
                }
            })?;
        planes.develop(self.predictor, &weights, &mut blurred);
        planes.put_back(&mut plate, blurred)?;
        said.extend(plate.write(&step.paths[1])?);
        Ok(said)
    }
}

/// Object vergence of a plate's pixels, 1/m.
enum Vergences {
    Constant(f64),
    PerPixel(Vec<f32>),
}
