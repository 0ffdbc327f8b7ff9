//! The files read beside a plate.

use std::path::{Path, PathBuf};

use clap::builder::{NonEmptyStringValueParser, TypedValueParser};

use seidel_image_io::image_channel::ChannelSpec;

/// The files read beside the plate of a frame; or those of a run, each a frame pattern or one file for all frames.
#[derive(Debug, Clone, Default)]
pub(crate) struct SideInputs {
    pub(crate) depth: Option<ChannelSpec>,
    /// Matte of an object that will be merged in front.
    pub(crate) holdout: Option<ChannelSpec>,
    pub(crate) holdout_depth: Option<ChannelSpec>,
    /// Weight of the blurred plate against its own pixels.
    pub(crate) mask: Option<ChannelSpec>,
    pub(crate) invert_mask: bool,
    /// The plate without its foreground.
    pub(crate) background: Option<PathBuf>,
    pub(crate) background_depth: Option<ChannelSpec>,
    /// Residual that `seidel remove` wrote.
    pub(crate) residual: Option<PathBuf>,
    pub(crate) aperture_picture: Option<PathBuf>,
}

impl SideInputs {
    fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        fn file(channel: &mut Option<ChannelSpec>) -> Option<&mut PathBuf> {
            channel.as_mut().map(|channel| &mut channel.file)
        }
        let files = [
            file(&mut self.depth),
            file(&mut self.holdout),
            file(&mut self.holdout_depth),
            file(&mut self.mask),
            self.background.as_mut(),
            file(&mut self.background_depth),
            self.residual.as_mut(),
            self.aperture_picture.as_mut(),
        ];
        files.into_iter().flatten()
    }

    /// Returns the paths of all files, in the order in which errors name them.
    pub(super) fn paths(&self) -> Vec<PathBuf> {
        let mut files = self.clone();
        files.paths_mut().map(std::mem::take).collect()
    }

    /// Returns the same files with each path replaced by `change` of it.
    pub(super) fn with_paths(&self, change: impl Fn(&Path) -> PathBuf) -> Self {
        let mut files = self.clone();
        files.paths_mut().for_each(|path| *path = change(path));
        files
    }
}

/// Returns the parser of options that name a file, or one channel of it.
pub(crate) fn channel_parser() -> impl TypedValueParser<Value = ChannelSpec> {
    NonEmptyStringValueParser::new().map(|text| ChannelSpec::parse(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_is_listed() {
        let path = || Some(PathBuf::from("pattern"));
        let channel = || Some(ChannelSpec::parse("pattern"));
        let files = SideInputs {
            depth: channel(),
            holdout: channel(),
            holdout_depth: channel(),
            mask: channel(),
            invert_mask: false,
            background: path(),
            background_depth: channel(),
            residual: path(),
            aperture_picture: path(),
        };
        let resolved = format!("{:?}", files.with_paths(|_| "frame".into()));
        assert!(!resolved.contains("pattern"), "{resolved}");
        assert_eq!(resolved.matches("frame").count(), files.paths().len());
    }
}
