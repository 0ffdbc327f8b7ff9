//! One frame of a run: read, blurred, written.

use seidel_core::{Edges, Expand, Quality, Rendering};
use seidel_render::VergencePass;

use super::{ApplyArgs, residual, show, verbose};
use crate::commands::plates::{
    FinishedFrame, FrameFiles, LoadedPlate, PlateReader, Run, SettingsRecord, ViewWork, setting,
};
use crate::commands::{CommandError, value_name};
use seidel_image_io::plate::PlateFile;
use seidel_image_io::residual::Residual;

/// The work on the frames of a run.
pub(super) struct Job<'a> {
    pub(super) args: &'a ApplyArgs,
    pub(super) reader: &'a PlateReader<'a>,
    pub(super) run: &'a Run,
}

/// A frame in memory.
pub(super) struct LoadedFrame {
    loaded: LoadedPlate,
    residual: Option<Residual>,
}

impl Job<'_> {
    /// Returns the settings of the frame by name.
    fn record(&self, loaded: &LoadedPlate) -> Result<SettingsRecord, CommandError> {
        let mut record = self.reader.record(&loaded.lens, &loaded.plate)?;
        match self.args.show {
            Some(choice) => record.push(setting("show", value_name(choice))),
            None => record.extend(
                self.args
                    .record(loaded.lens.session.settings(), loaded.prepared.edges()),
            ),
        }
        Ok(record)
    }

    /// Returns a note about the edges and the data window, where they were chosen by the plate and are not those of a full
    /// frame.
    fn edges_note(&self, loaded: &LoadedPlate) -> Option<String> {
        if loaded.is_neutral() {
            return None;
        }
        let settings = loaded.lens.session.settings();
        let edges = match loaded.prepared.edges() {
            _ if settings.edges.is_some() => None,
            Edges::Mirror => None,
            Edges::Black => Some("element over nothing: rendered with --edges black"),
            Edges::Extend => Some("element cut by the border: rendered with --edges extend"),
        };
        let grown = loaded.own_window.is_some() && settings.expand == Expand::Auto;
        let grown = grown
            .then_some("the data window grows by the reach of the blur (--expand off keeps it)");
        let notes: Vec<&str> = edges.into_iter().chain(grown).collect();
        (!notes.is_empty()).then(|| notes.join("; "))
    }

    /// Returns the most memory that the frame takes, bytes.
    fn needed_bytes(&self, loaded: &LoadedPlate) -> u64 {
        loaded.plate.memory_bytes() + loaded.prepared.apply_bytes()
    }

    /// Returns a note where the frame alone may take more than `--memory`, for the first one.
    fn memory_note(&self, index: usize, loaded: &LoadedPlate) -> Option<String> {
        let (needed, limit) = (self.needed_bytes(loaded), self.run.memory_bytes());
        (index == 0 && needed > limit).then(|| {
            let [needed, limit] = [needed, limit].map(|bytes| bytes as f64 / f64::from(1 << 20));
            format!(
                "a frame may take {needed:.1} MiB, more than --memory allows ({limit:.1} MiB): frames are rendered one at a time"
            )
        })
    }

    /// Renders the planes of the frame at `index`. Adds to `warnings`.
    fn render(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        rendering: &Rendering,
        warnings: &mut Vec<String>,
    ) -> seidel_core::Result<Vec<Vec<f32>>> {
        let varies = matches!(rendering.scene.vergence, VergencePass::PerPixel(_));
        let occlusion = rendering.occlusion.is_some();
        let quality = loaded.lens.session.settings().quality;
        if varies && !occlusion && quality != Quality::Exact {
            warnings.push(
                "depth varies over the plate: without occlusion it is rendered exactly, whatever --quality says"
                    .into(),
            );
        }
        let progress = |share| self.run.show_progress(index, share);
        let rendered = rendering.render(None, &progress)?;
        if self.args.verbose {
            let report = verbose::report(rendering, &rendered, &loaded.prepared)?;
            warnings.push(report);
        }
        Ok(rendered.planes)
    }
}

impl ViewWork for Job<'_> {
    type Loaded = LoadedFrame;

    fn files(&self, index: usize) -> &FrameFiles {
        &self.run.frames()[index]
    }

    fn plate<'a>(&self, frame: &'a LoadedFrame) -> &'a PlateFile {
        &frame.loaded.plate
    }

    fn read(&self, index: usize, view: usize) -> Result<LoadedFrame, CommandError> {
        let frame = self.files(index);
        let mut loaded = self.reader.read(frame, index, view)?;
        if self.args.show.is_some() {
            return Ok(LoadedFrame {
                loaded,
                residual: None,
            });
        }
        self.reader.add_side_images(&frame.read, &mut loaded)?;
        loaded.expand()?;
        if index == 0 {
            loaded.warnings.extend(self.edges_note(&loaded));
            let focus = loaded.prepared.focus_warning();
            (loaded.warnings).extend(focus.map_err(|e| loaded.in_file(e))?);
        }
        let residual = match &frame.read.residual {
            Some(file) => {
                let record = self.record(&loaded)?;
                Some(residual::open(file, &mut loaded, &record)?)
            }
            None => None,
        };
        loaded.warnings.extend(self.memory_note(index, &loaded));
        Ok(LoadedFrame { loaded, residual })
    }

    fn memory_bytes(&self, frame: &LoadedFrame) -> u64 {
        self.needed_bytes(&frame.loaded)
    }

    fn warnings(&self, frame: &LoadedFrame) -> Vec<String> {
        frame.loaded.warnings.clone()
    }

    fn process(&self, index: usize, frame: LoadedFrame) -> Result<FinishedFrame, CommandError> {
        let LoadedFrame {
            mut loaded,
            residual,
        } = frame;
        let mut warnings = std::mem::take(&mut loaded.warnings);
        // The plate is copied once the memory of the render is free again.
        let mut plate;
        if let Some(choice) = self.args.show {
            let shown = show::draw(choice, self.args.focus_tolerance, &loaded)?;
            if index == 0 {
                warnings.extend(shown.legend);
            }
            plate = loaded.plate.clone();
            if choice.is_numbers() {
                loaded.put_numbers(&mut plate, shown.planes)?;
            } else {
                loaded.put_planes(&mut plate, shown.planes)?;
            }
        } else if loaded.is_neutral() {
            plate = loaded.plate.clone();
            loaded.put_unchanged(&mut plate)?;
            if self.args.verbose {
                warnings.push("not rendered: at --amount 0 the plate stays as it is".into());
            }
        } else {
            let render =
                |rendering: &Rendering| self.render(index, &loaded, rendering, &mut warnings);
            let blurred = loaded.prepared.apply_with(render);
            let mut blurred = blurred.map_err(|e| loaded.in_file(e))?;
            if let Some(residual) = &residual {
                residual::add(residual, &loaded.prepared, &mut blurred)
                    .map_err(|e| loaded.in_file(e))?;
            }
            let window = loaded.trimmed_window(&blurred);
            plate = loaded.plate.clone();
            loaded.put_planes(&mut plate, blurred)?;
            if let Some(window) = window {
                plate.set_data_window(window);
            }
        }
        if let Some(residual) = &residual {
            plate.set_data_window(residual.plate);
        }
        Ok(FinishedFrame {
            record: self.record(&loaded)?,
            side_files: Vec::new(),
            plate,
            warnings,
        })
    }
}
