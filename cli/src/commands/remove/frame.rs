//! One frame of a run: read, its blur removed, written.

use std::path::Path;

use seidel_core::{NoiseGain, RemovedPlate};

use super::RemoveArgs;
use super::extras::{Extra, Map};
use crate::commands::CommandError;
use crate::commands::plates::{
    FrameId, LoadedPlate, Outcome, PlateReader, Run, Stages, default_rendering_record,
};
use crate::commands::removal::{LensCheck, work_bytes};
use seidel_image_io::error::FileError;
use seidel_image_io::format::{Format, output_format};
use seidel_image_io::plate::Plate;
use seidel_image_io::residual::Residual;
use seidel_image_io::windows::{crop_or_extend, crop_or_pad};

/// Share of the work that is the removal.
const REMOVAL_SHARE: f64 = 0.9;

/// The frames of a run: options, reader and progress.
pub(super) struct Job<'a> {
    pub(super) args: &'a RemoveArgs,
    pub(super) reader: &'a PlateReader<'a>,
    /// The check of the lens.
    pub(super) check: LensCheck,
    pub(super) run: &'a Run,
}

/// A frame to be written.
pub(super) struct SharpFrame {
    plate: Plate,
    extras: Vec<Extra>,
    warnings: Vec<String>,
}

impl Job<'_> {
    fn depth_file(&self, index: usize) -> Option<&Path> {
        let read = &self.run.frame(index).read;
        read.first().map(|path| path.as_path())
    }

    /// The difference between the plate and what its lens makes of the `sharp` plate as its file will hold it.
    fn residual(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        sharp: &Plate,
        removed: Option<&RemovedPlate>,
        path: &Path,
    ) -> Result<Residual, CommandError> {
        let number = self.run.frame(index).number;
        let depth = self.depth_file(index);
        let mut stored = (self.reader).load_written(sharp.clone(), loaded, number, depth)?;
        // As far as the lens was removed.
        stored.set_lens(loaded.lens.clone());
        let progress = |share: f64| {
            let done = REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share;
            self.run.tell(index, done);
            true
        };
        let applied = stored.prepared.apply(&progress);
        let applied = applied.map_err(|e| stored.in_file(e))?;
        let noise = match removed {
            Some(removed) => removed.noise(),
            None => vec![0.0; loaded.prepared.planes().len()],
        };
        let (whole, own) = (sharp.data_window(), loaded.plate.data_window());
        let difference = |(applied, plane): (&Vec<f32>, &Vec<f32>)| {
            let applied = crop_or_extend(applied, whole, own);
            let difference: Vec<f32> = plane.iter().zip(applied).map(|(p, a)| p - a).collect();
            crop_or_pad(&difference, own, whole)
        };
        let mut settings = self.reader.record(&loaded.lens, &loaded.plate)?;
        settings.extend(default_rendering_record());
        Ok(Residual {
            path: path.to_owned(),
            windows: sharp.windows(),
            plate: own,
            names: loaded.prepared.names(),
            residual: (applied.iter().zip(loaded.prepared.planes()))
                .map(difference)
                .collect(),
            sharp: stored.prepared.planes().to_vec(),
            noise,
            settings,
        })
    }

    /// Whether the frame at `index` is written in the format of its `plate`.
    fn keeps_format(&self, index: usize, plate: &Plate) -> Result<bool, CommandError> {
        Ok(output_format(&self.run.frame(index).output)? == plate.format())
    }

    /// Puts the sharp planes into `plate`, with overscan where `overscan` says so.
    fn put_sharp(
        &self,
        loaded: &LoadedPlate,
        removed: &RemovedPlate,
        plate: &mut Plate,
        overscan: Overscan,
    ) -> Result<(), CommandError> {
        let in_file = |e| loaded.in_file(e);
        let canvas = removed.canvas().map_err(in_file)?;
        let mut planes = removed.sharp_planes(&loaded.prepared).map_err(in_file)?;
        match overscan {
            Overscan::Keep => {
                let own = plate.data_window();
                plate.set_data_window(own.expanded(canvas.margin_x, canvas.margin_y));
            }
            Overscan::Crop => {
                planes = planes.iter().map(|plane| canvas.cropped(plane)).collect();
            }
        }
        loaded.put_planes(plate, planes)
    }

    /// Whether the sharp `plate` keeps the light found beyond its edges: where an EXR is written as EXR.
    fn overscan(&self, index: usize, plate: &Plate) -> Result<Overscan, CommandError> {
        let to_exr = output_format(&self.run.frame(index).output)? == Format::Exr;
        let keep = to_exr && plate.format() == Format::Exr && !self.args.no_overscan;
        Ok(if keep { Overscan::Keep } else { Overscan::Crop })
    }
}

/// Light found beyond the edges of the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Overscan {
    Keep,
    Crop,
}

/// The map that `option` asks for; ones where no blur was removed.
fn map(option: &str, loaded: &LoadedPlate, removed: Option<&RemovedPlate>, path: &Path) -> Map {
    let planes = match (removed, option) {
        (Some(removed), "--confidence") => removed.confidence(),
        (Some(removed), _) => removed.noise_gain().to_vec(),
        (None, _) => {
            let pixels = loaded.plate.width() * loaded.plate.height();
            vec![vec![1.0; pixels]; loaded.prepared.colour_count()]
        }
    };
    Map {
        path: path.to_owned(),
        windows: loaded.plate.windows(),
        names: loaded.plate.colour_names().to_vec(),
        planes,
    }
}

impl Stages for Job<'_> {
    type Read = LoadedPlate;
    type Done = SharpFrame;

    fn read(&self, index: usize) -> Result<LoadedPlate, CommandError> {
        let frame = self.run.frame(index);
        let id = FrameId::new(frame.number, index);
        let loaded = (self.reader).read(&frame.input, id, self.depth_file(index))?;
        if self.args.residual.is_some() && !self.keeps_format(index, &loaded.plate)? {
            let problem = format!(
                "is written as another format than the plate, which is {}: --residual would not fit it",
                loaded.plate.format()
            );
            let remedy = "give OUT the extension of IN, or leave out --residual";
            return Err(FileError::new(&frame.output, "", problem, remedy).into());
        }
        self.args.removal.check(&loaded.plate)?;
        Ok(loaded)
    }

    fn bytes(&self, loaded: &LoadedPlate) -> u64 {
        work_bytes(loaded)
    }

    fn blur(&self, index: usize, mut loaded: LoadedPlate) -> Result<SharpFrame, CommandError> {
        let mut plate = loaded.plate.clone();
        let mut removed = None;
        if loaded.is_neutral() || self.args.strength == 0.0 {
            loaded.keep(&mut plate)?;
            (loaded.warnings).push("at --amount 0 or --strength 0 the plate stays as it is".into());
        } else {
            let progress = |share| self.run.tell(index, REMOVAL_SHARE * share);
            let noise_gain = if self.args.noise_gain.is_some() {
                NoiseGain::Measure
            } else {
                NoiseGain::Skip
            };
            let number = self.run.frame(index).number;
            let found = self.args.removal.remove(
                self.reader,
                &self.check,
                number,
                &mut loaded,
                noise_gain,
                &progress,
            )?;
            let overscan = self.overscan(index, &plate)?;
            self.put_sharp(&loaded, &found, &mut plate, overscan)?;
            removed = Some(found);
        }
        if self.keeps_format(index, &plate)? {
            plate.quantise();
        }
        let mut extras = Vec::new();
        for ((option, _), path) in self.args.written().zip(&self.run.frame(index).written) {
            extras.push(match option {
                "--residual" => Extra::Residual(Box::new(self.residual(
                    index,
                    &loaded,
                    &plate,
                    removed.as_ref(),
                    path,
                )?)),
                _ => Extra::Map(map(option, &loaded, removed.as_ref(), path)),
            });
        }
        let mut record = self.reader.record(&loaded.lens, &loaded.plate)?;
        record.push(("strength".to_owned(), self.args.strength.to_string()));
        self.run.set_provenance(index, &mut plate, &record);
        Ok(SharpFrame {
            plate,
            extras,
            warnings: loaded.warnings,
        })
    }

    fn write(&self, index: usize, frame: SharpFrame) -> Outcome {
        let SharpFrame {
            plate,
            extras,
            mut warnings,
        } = frame;
        for extra in extras {
            extra.write()?;
        }
        warnings.extend(plate.write(&self.run.frame(index).output)?);
        Ok(warnings)
    }
}
