//! One frame of a run: read, its blur removed, written.

use std::path::Path;

use seidel_core::{NoiseGain, RemovedPlate};

use super::RemoveArgs;
use crate::commands::CommandError;
use crate::commands::apply::default_rendering_record;
use crate::commands::plates::{
    FinishedFrame, FrameFiles, LoadedPlate, Map, SideFile, ViewWork, setting,
};
use crate::commands::removal::Removal;
use seidel_image_io::error::FileError;
use seidel_image_io::format::Format;
use seidel_image_io::formats::output_format;
use seidel_image_io::plate::PlateFile;
use seidel_image_io::residual::Residual;
use seidel_image_io::windows::{crop_or_extend, crop_or_pad};

/// The warning of a background that shows nothing.
const NO_FOREGROUND: &str = "--background changes nothing: the plate is nowhere nearer than its background, by their depths and this lens";

/// The work on the frames of a run.
pub(super) struct Job<'a> {
    pub(super) args: &'a RemoveArgs,
    pub(super) removal: Removal<'a>,
}

impl Job<'_> {
    /// Returns the difference between the plate and the re-blurred `sharp` plate as its file will hold it.
    fn residual(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        sharp: &PlateFile,
        removed: Option<&RemovedPlate>,
        path: &Path,
    ) -> Result<Residual, CommandError> {
        let reader = self.removal.reader;
        let mut stored = reader.load_result(sharp.clone(), loaded, self.removal.frame(index))?;
        // The lens may have been scaled by its check.
        stored.set_lens(loaded.lens.clone());
        let applied = (stored.prepared)
            .apply(&|share| self.removal.show_render_progress(index, share))
            .map_err(|e| stored.in_file(e))?;
        let noise = match removed {
            Some(removed) => removed.noise(),
            None => vec![0.0; loaded.prepared.planes().len()],
        };
        let (whole, own) = (sharp.data_window(), loaded.plate.data_window());
        let planes = applied.iter().zip(loaded.prepared.planes());
        let residual = planes.map(|(applied, plane)| {
            let applied = crop_or_extend(applied, whole, own);
            let difference: Vec<f32> = plane.iter().zip(applied).map(|(p, a)| p - a).collect();
            crop_or_pad(&difference, own, whole)
        });
        let mut settings = reader.record(&loaded.lens, &loaded.plate)?;
        settings.extend(default_rendering_record());
        Ok(Residual {
            path: path.to_owned(),
            windows: sharp.windows(),
            plate: own,
            names: loaded.prepared.names(),
            residual: residual.collect(),
            sharp: stored.prepared.planes().to_vec(),
            noise,
            settings,
        })
    }

    /// Returns the format of the output of the frame at `index`.
    fn output_format(&self, index: usize) -> Result<Format, CommandError> {
        Ok(output_format(&self.removal.frame(index).output)?)
    }

    /// Puts the planes without colour fringes into `plate`.
    fn put_matched(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        plate: &mut PlateFile,
    ) -> Result<(), CommandError> {
        let progress = |share| self.removal.show_match_progress(index, share);
        let planes = (loaded.prepared)
            .match_colours(&progress)
            .map_err(|e| loaded.in_file(e))?;
        loaded.put_planes(plate, planes)
    }

    /// Puts the sharp planes into `plate`, with the light found beyond its edges if the file can hold it.
    fn put_sharp(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        removed: &RemovedPlate,
        plate: &mut PlateFile,
    ) -> Result<(), CommandError> {
        let in_file = |e| loaded.in_file(e);
        let canvas = removed.canvas().map_err(in_file)?;
        let mut planes = removed.sharp_planes(&loaded.prepared).map_err(in_file)?;
        let format = self.output_format(index)?;
        let can_grow = format == plate.format() && format.has_data_window();
        if can_grow && !self.args.no_overscan {
            let own = plate.data_window();
            plate.set_data_window(own.expanded(canvas.margin_x, canvas.margin_y));
        } else {
            planes = planes.iter().map(|plane| canvas.crop(plane)).collect();
        }
        loaded.put_planes(plate, planes)
    }
}

/// Returns the map that `option` requests; ones if no blur was removed.
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

impl ViewWork for Job<'_> {
    type Loaded = LoadedPlate;

    fn files(&self, index: usize) -> &FrameFiles {
        self.removal.frame(index)
    }

    fn plate<'a>(&self, loaded: &'a LoadedPlate) -> &'a PlateFile {
        &loaded.plate
    }

    fn read(&self, index: usize, view: usize) -> Result<LoadedPlate, CommandError> {
        let loaded = self.removal.read(index, view)?;
        if self.args.residual.is_some() && self.output_format(index)? != loaded.plate.format() {
            let problem = format!(
                "has another format than the plate, which is {}: --residual would not fit it",
                loaded.plate.format()
            );
            let remedy = "give OUT the extension of IN, or leave out --residual";
            let output = &self.removal.frame(index).output;
            return Err(FileError::new(output, "", problem, remedy).into());
        }
        Ok(loaded)
    }

    fn memory_bytes(&self, loaded: &LoadedPlate) -> u64 {
        // Foreground and background are solved one after the other, and kept.
        let solutions = if self.args.background.is_some() { 2 } else { 1 };
        solutions * self.removal.memory_bytes(loaded)
    }

    fn warnings(&self, loaded: &LoadedPlate) -> Vec<String> {
        loaded.warnings.clone()
    }

    fn process(
        &self,
        index: usize,
        mut loaded: LoadedPlate,
    ) -> Result<FinishedFrame, CommandError> {
        let mut plate = loaded.plate.clone();
        let mut removed = None;
        let strength = loaded.lens.session.settings().removal.strength;
        if loaded.is_neutral() || strength == 0.0 {
            loaded.put_unchanged(&mut plate)?;
            (loaded.warnings).push("at --amount 0 or --strength 0 the plate stays as it is".into());
        } else if self.args.only_chroma {
            self.put_matched(index, &loaded, &mut plate)?;
        } else {
            let noise_gain = if self.args.noise_gain.is_some() {
                NoiseGain::Measure
            } else {
                NoiseGain::Skip
            };
            let result = self.removal.remove(index, &mut loaded, noise_gain)?;
            if self.args.background.is_some() && !result.is_split() {
                (loaded.warnings).push(NO_FOREGROUND.into());
            }
            self.put_sharp(index, &loaded, &result, &mut plate)?;
            removed = Some(result);
        }
        if self.output_format(index)? == plate.format() {
            plate.quantise();
        }
        let mut side_files = Vec::new();
        for (option, path) in &self.removal.frame(index).written {
            let removed = removed.as_ref();
            side_files.push(if *option == "--residual" {
                let residual = self.residual(index, &loaded, &plate, removed, path)?;
                SideFile::Residual(Box::new(residual))
            } else {
                SideFile::Map(map(option, &loaded, removed, path))
            });
        }
        let mut record = (self.removal.reader).record(&loaded.lens, &loaded.plate)?;
        record.push(setting("strength", strength));
        if self.args.only_chroma {
            record.push(setting("only_chroma", true));
        }
        Ok(FinishedFrame {
            plate,
            record,
            side_files,
            warnings: loaded.warnings,
        })
    }
}
