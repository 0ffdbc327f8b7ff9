//! The views of a plate, such as the eyes of a stereo pair: each is rendered by itself and all are written as one file.

use seidel_image_io::error::FileError;
use seidel_image_io::formats::output_format;
use seidel_image_io::plate::PlateFile;

use super::finished_frame::FinishedFrame;
use super::frames::FrameFiles;
use super::queue::FrameWork;
use crate::commands::CommandError;

/// The work on one view of each frame before it is written. Frames and views are known by their index.
pub(crate) trait ViewWork: Sync {
    /// A view that was read.
    type Loaded: Send;

    /// Returns the files of a frame.
    fn files(&self, index: usize) -> &FrameFiles;

    /// Reads a view of a frame.
    fn read(&self, index: usize, view: usize) -> Result<Self::Loaded, CommandError>;

    /// Returns the plate of a view that was read.
    fn plate<'a>(&self, loaded: &'a Self::Loaded) -> &'a PlateFile;

    /// Returns an upper bound of the memory that the view takes, bytes.
    fn memory_bytes(&self, loaded: &Self::Loaded) -> u64;

    /// Returns the warnings about a view that was read.
    fn warnings(&self, loaded: &Self::Loaded) -> Vec<String>;

    /// Processes a view.
    fn process(&self, index: usize, loaded: Self::Loaded) -> Result<FinishedFrame, CommandError>;
}

/// The views of a frame that were read.
pub(super) struct LoadedViews<T> {
    first: T,
    others: Vec<T>,
}

/// The work on all views of each frame.
pub(super) struct AllViews<'a, W>(pub(super) &'a W);

impl<W: ViewWork> AllViews<'_, W> {
    /// Returns the number of views to render of a frame whose first view is `plate`.
    fn count(&self, index: usize, plate: &PlateFile) -> Result<usize, CommandError> {
        let count = plate.view_count();
        let files = self.0.files(index);
        if count == 1 || !output_format(&files.output)?.has_layers() {
            return Ok(1);
        }
        let residual = files.read.residual.as_ref().map(|_| "--residual");
        let written = files.written.first().map(|(option, _)| *option);
        if let Some(option) = residual.or(written) {
            return Err(FileError::new(
                plate.path(),
                "views",
                format!("has {count} views of the plate, but {option} holds one"),
                format!("name one of them with --view, or leave out {option}"),
            )
            .into());
        }
        Ok(count)
    }

    /// Returns `warnings` about a view of `plate`, with its name where the plate has several.
    fn named(plate: &PlateFile, warnings: Vec<String>) -> Vec<String> {
        if plate.view_count() == 1 {
            return warnings;
        }
        let view = plate.view().unwrap_or("without a name");
        let named = warnings.into_iter();
        named
            .map(|warning| format!("view {view}: {warning}"))
            .collect()
    }
}

impl<W: ViewWork> FrameWork for AllViews<'_, W> {
    type Loaded = LoadedViews<W::Loaded>;
    type Processed = FinishedFrame;

    fn read(&self, index: usize) -> Result<Self::Loaded, CommandError> {
        let first = self.0.read(index, 0)?;
        (self.0.plate(&first)).check_output(&self.0.files(index).output)?;
        let others = 1..self.count(index, self.0.plate(&first))?;
        let others = others.map(|view| self.0.read(index, view));
        Ok(LoadedViews {
            others: others.collect::<Result<_, _>>()?,
            first,
        })
    }

    fn memory_bytes(&self, views: &Self::Loaded) -> u64 {
        let others = views.others.iter().map(|view| self.0.memory_bytes(view));
        self.0.memory_bytes(&views.first) + others.sum::<u64>()
    }

    fn warnings(&self, views: &Self::Loaded) -> Vec<String> {
        let of_view = |view: &W::Loaded| Self::named(self.0.plate(view), self.0.warnings(view));
        let all = std::iter::once(&views.first).chain(&views.others);
        all.flat_map(of_view).collect()
    }

    fn process(&self, index: usize, views: Self::Loaded) -> Result<FinishedFrame, CommandError> {
        let is_left_out = self.0.plate(&views.first).view_count() > 1 + views.others.len();
        let process = |view| {
            let mut frame = self.0.process(index, view)?;
            frame.warnings = Self::named(&frame.plate, std::mem::take(&mut frame.warnings));
            Ok::<_, CommandError>(frame)
        };
        let mut finished = process(views.first)?;
        for view in views.others {
            let frame = process(view)?;
            finished.plate.take_view(&frame.plate);
            finished.warnings.extend(frame.warnings);
        }
        if is_left_out {
            let note = "the other views are left out, since the output holds one picture";
            finished.warnings.push(note.to_owned());
        }
        Ok(finished)
    }
}
