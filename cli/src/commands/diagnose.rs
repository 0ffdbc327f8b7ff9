//! `seidel diagnose`: finds the effects that a lens lacks against measured PSFs, and how far adding them closes the gap.

mod output;
mod pair;
mod photo;
mod plate_gap;

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use rayon::ThreadPool;
use seidel_calibrate::diagnose::diagnose;
use seidel_core::diagnosis::PlacedPictures;
use seidel_core::profile::LensDescription;
use seidel_core::{
    Diagnosis, DiagnosisSettings, Lens, LensProfile, ObjectDistance, ObservationSet,
};
use seidel_optics::effects;

use super::{CommandError, parse_distance, short_name, thread_pool};
use crate::Console;
use crate::progress::ProgressArgs;
use crate::report::{self, Subject};
use output::OutputFolder;
use pair::PairArgs;
use photo::PhotoArgs;
use plate_gap::PlateGapMaps;
use seidel_image_io::error::FileError;
use seidel_image_io::lens_profile;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};

/// Options of `seidel diagnose`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("pictures").args(["photo", "reference"])))]
pub struct DiagnoseArgs {
    /// Lens profile or library:NAME, modelled ray by ray (fit --model reduced or extended)
    #[arg(long, required_unless_present = "schema")]
    lens: Option<PathBuf>,
    /// Observation set to compare the lens with
    #[arg(value_name = "OBS", required_unless_present_any = ["schema", "reference", "photo"], conflicts_with = "reference")]
    observations: Option<PathBuf>,
    /// Folder for report.json, report.html and corrected.json, and for PSFs estimated from a picture pair or measured in photographs (psf)
    #[arg(long, value_name = "DIR", required_unless_present = "schema")]
    out: Option<PathBuf>,
    /// Identifiers of the effects to try; all if omitted
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    only: Vec<String>,
    /// Set that the lens was fitted to: what its model leaves of that set is not held against these observations. Needed for
    /// a lens fitted with --use-all, which held no PSFs out
    #[arg(long, value_name = "SET", conflicts_with = "schema")]
    design: Option<PathBuf>,
    /// Distance of the lights or of the scene in metres from the entrance pupil, or `inf`: one for each photograph, or one for all
    #[arg(long = "distance", aliases = ["distance-m", "depth-m"], value_name = "METRES", value_delimiter = ',',
        value_parser = parse_distance, requires = "pictures")]
    distances: Vec<ObjectDistance>,
    /// Try no pairs of effects: faster
    #[arg(long)]
    no_pairs: bool,
    /// Number of threads; all cores if omitted
    #[arg(long, value_parser = super::parse_threads)]
    threads: Option<usize>,
    /// Print report.json instead of a summary
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
    /// Print the JSON schema of report.json and exit
    #[arg(long, exclusive = true)]
    schema: bool,
    // After the options without a heading, which would come under theirs.
    #[command(flatten)]
    pair: PairArgs,
    #[command(flatten)]
    photo: PhotoArgs,
}

pub(super) fn run(args: &DiagnoseArgs, console: &mut Console) -> Result<(), CommandError> {
    if args.schema {
        console.print(report::schema());
        return Ok(());
    }
    for id in &args.only {
        effects::by_id(id)?;
    }
    let pool = thread_pool(args.threads)?;
    let (Some(lens), Some(out)) = (&args.lens, &args.out) else {
        return Err(CommandError::Usage("give --lens and --out".to_owned()));
    };
    let estimates = args.pair.reference.is_some();
    let photographed = !args.photo.photo.is_empty();
    let entries: Vec<&str> = if photographed {
        output::ENTRIES_OF_PAIR.to_vec()
    } else if estimates {
        // Pictures of an earlier run are replaced, or removed where none are wanted now.
        [&output::ENTRIES_OF_PAIR[..], &plate_gap::FILES].concat()
    } else {
        output::FILES.to_vec()
    };
    let output = OutputFolder::check(out, lens, &entries)?;
    let profile = lens_profile::read(lens)?;
    check_pupil_lens(&profile, lens)?;
    let design = args.read_design(&profile, lens)?;
    let compared = args.compare(&profile, lens, design, &pool, console)?;
    let (source, mut diagnosis) = (compared.source, compared.diagnosis);
    diagnosis.remarks.extend(source.remarks.iter().cloned());
    let maps = args.plate_gap(&profile, &diagnosis, &source, &pool, console)?;
    let subject = Subject {
        plate_gap: maps.as_ref().map(|m| m.picture.clone()),
        ..Subject::new(short_name(lens), source.name, &source.set)
    };
    let json = report::json(&diagnosis, &subject)?;
    let estimated = (estimates || photographed).then_some(&source.set);
    output.write(&diagnosis, &subject, &json, estimated, maps.as_ref())?;
    if args.json {
        console.print(json.trim_end());
    } else {
        print_summary(&diagnosis, &subject, out, console);
        if let Some(maps) = &maps {
            console.print(maps.summary());
        }
    }
    for remark in &diagnosis.remarks {
        console.note(remark);
    }
    Ok(())
}

/// The observations that the lens is compared with.
struct Source {
    set: ObservationSet,
    /// The pictures that they were estimated from.
    pictures: Option<PlacedPictures>,
    /// The file or folder that messages name.
    path: PathBuf,
    /// Name in the report.
    name: String,
    remarks: Vec<String>,
}

/// A diagnosis, and the observations that it is of.
struct Comparison {
    source: Source,
    diagnosis: Diagnosis,
}

impl DiagnoseArgs {
    /// Compares the lens with the observation set, with one measured in photographs, or with one estimated from the picture pair.
    fn compare(
        &self,
        lens: &LensProfile,
        lens_path: &Path,
        design: Option<ObservationSet>,
        pool: &ThreadPool,
        console: &mut Console,
    ) -> Result<Comparison, CommandError> {
        let settings = DiagnosisSettings {
            library: self.only.clone(),
            pairs: !self.no_pairs,
            design,
            ..DiagnosisSettings::default()
        };
        let (Some(sharp), Some(blurred)) = (&self.pair.reference, &self.pair.observed) else {
            let source = self.read_source(lens, lens_path, console)?;
            let bar = console.progress_bar("diagnosing");
            let diagnosis =
                pool.install(|| diagnose(lens, &source.set, &settings, &|share| bar.show(share)));
            return match diagnosis {
                Ok(diagnosis) => Ok(Comparison { source, diagnosis }),
                Err(error) => Err(FileError::from_core(&source.path, error).into()),
            };
        };
        let lens = Lens::new(lens.clone()).map_err(|e| FileError::from_core(lens_path, e))?;
        let distance = self.distance_of_pair()?;
        let found = self.pair.diagnose(
            sharp, blurred, &lens, lens_path, distance, &settings, pool, console,
        )?;
        let estimate = found.estimate;
        let (count, name) = (estimate.set.observations.len(), short_name(blurred));
        let mut remarks = vec![format!(
            "{count} PSFs were estimated from {} and {name}; they were not measured",
            short_name(sharp)
        )];
        remarks.extend(estimate.remarks());
        Ok(Comparison {
            source: Source {
                set: estimate.set,
                pictures: Some(estimate.pictures),
                path: blurred.clone(),
                name,
                remarks,
            },
            diagnosis: found.diagnosis,
        })
    }

    /// Returns the distance of the scene of the picture pair.
    fn distance_of_pair(&self) -> Result<ObjectDistance, CommandError> {
        match self.distances[..] {
            [] => Ok(ObjectDistance::Unknown),
            [distance] => Ok(distance),
            _ => Err(CommandError::Usage(
                "--distance gives several distances; a picture pair has one".to_owned(),
            )),
        }
    }

    /// Reads the observation set, or measures one in photographs.
    fn read_source(
        &self,
        lens: &LensProfile,
        lens_path: &Path,
        console: &mut Console,
    ) -> Result<Source, CommandError> {
        if let Some(first) = self.photo.photo.first() {
            let encoding = self.pair.encoding;
            let measured =
                (self.photo).measure(lens, lens_path, &self.distances, encoding, console)?;
            return Ok(Source {
                set: measured.set,
                pictures: None,
                path: first.clone(),
                name: short_name(first),
                remarks: measured.remarks,
            });
        }
        let Some(path) = &self.observations else {
            return Err(CommandError::Usage(
                "give OBS, --photo, or --reference and --observed".to_owned(),
            ));
        };
        let set = manifest::read(path, ReadOptions::default())?.set;
        check_channels(lens, &set, path)?;
        Ok(Source {
            set,
            pictures: None,
            path: path.clone(),
            name: short_name(path),
            remarks: Vec::new(),
        })
    }

    /// Reads the set that the lens was fitted to, if it is given.
    ///
    /// # Errors
    /// No set for a lens that was fitted with `--use-all`; a set that does not suit the lens.
    fn read_design(
        &self,
        lens: &LensProfile,
        lens_path: &Path,
    ) -> Result<Option<ObservationSet>, CommandError> {
        let Some(path) = &self.design else {
            if lens.held_out.is_none() && lens.provenance.held_nothing_out() {
                return Err(FileError::new(
                    lens_path,
                    "held_out",
                    "is missing: the lens was fitted with --use-all, so what its own model leaves is not known",
                    "give the set that it was fitted to with --design SET, or fit it without --use-all",
                )
                .into());
            }
            return Ok(None);
        };
        let set = manifest::read(path, ReadOptions::default())?.set;
        check_channels(lens, &set, path)?;
        set.check_frame(lens.frame)
            .map_err(|error| FileError::from_core(path, error))?;
        Ok(Some(set))
    }

    /// Renders the gap in the plate if it is wanted.
    fn plate_gap(
        &self,
        lens: &LensProfile,
        diagnosis: &Diagnosis,
        source: &Source,
        pool: &ThreadPool,
        console: &Console,
    ) -> Result<Option<PlateGapMaps>, CommandError> {
        let Some(pictures) = source.pictures.as_ref().filter(|_| self.pair.plate_gap) else {
            return Ok(None);
        };
        let distance = self.distance_of_pair()?;
        let corrected = &diagnosis.corrected;
        PlateGapMaps::render(pictures, lens, corrected, distance, pool, console).map(Some)
    }
}

/// Rejects a lens described by moments before any long work starts.
fn check_pupil_lens(lens: &LensProfile, path: &Path) -> Result<(), FileError> {
    match lens.description {
        LensDescription::Pupil(_) => Ok(()),
        LensDescription::Moments(_) => Err(FileError::new(
            path,
            "kind",
            "is `moments`, to which no effect can be added",
            "fit the lens with `seidel fit --model reduced` or `extended`",
        )),
    }
}

/// Rejects a set with channels that the lens does not have.
fn check_channels(lens: &LensProfile, set: &ObservationSet, path: &Path) -> Result<(), FileError> {
    let known = lens.channel_names();
    let unknown: Vec<&str> = set
        .channels
        .iter()
        .map(String::as_str)
        .filter(|name| !known.contains(name))
        .collect();
    if unknown.is_empty() {
        return Ok(());
    }
    Err(FileError::new(
        path,
        format!("channel {}", unknown.join(", ")),
        format!("is not in the lens, which has {}", known.join(", ")),
        "fit the lens to sets with the same channels",
    ))
}

/// Prints the main results, one per line.
fn print_summary(diagnosis: &Diagnosis, subject: &Subject, out: &Path, console: &mut Console) {
    for line in report::summary(diagnosis, subject) {
        console.print(line);
    }
    console.print(format!(
        "wrote {} ({})",
        out.display(),
        output::FILES.join(", ")
    ));
}
