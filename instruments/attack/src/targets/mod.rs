//! Targets: what is attacked. One a file.

pub(crate) mod animation;
pub(crate) mod c_abi;
pub(crate) mod exr;
pub(crate) mod frames;
pub(crate) mod full_disk;
pub(crate) mod image;
pub(crate) mod kill;
mod lens_table;
pub(crate) mod lists;
pub(crate) mod manifest;
pub(crate) mod ocio;
pub(crate) mod patterns;
pub(crate) mod photograph;
pub(crate) mod planted;
pub(crate) mod profile;
pub(crate) mod program;
pub(crate) mod reader;
pub(crate) mod tables;
pub(crate) mod unsteady_file;

use std::path::Path;
use std::time::Duration;

use crate::case::Case;
use reader::{DamagedFiles, Reader};

/// Makes an attack with its seeds in a folder.
type Start = fn(&Path) -> Box<dyn Attack>;

/// The means of an attack.
pub(crate) enum Method {
    /// Damaged files for a reader.
    Reader(Reader),
    /// Calls of the library.
    Calls(Start),
    /// Runs of the whole command.
    Program(Start),
}

/// Something that is attacked.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    /// A description on one line.
    pub(crate) about: &'static str,
    /// Share of the time, relative to other targets.
    pub(crate) weight: f64,
    pub(crate) method: Method,
}

impl Target {
    /// Makes the attack, with its seeds in `folder`.
    pub(crate) fn start(&'static self, folder: &Path) -> Box<dyn Attack> {
        match &self.method {
            Method::Reader(reader) => Box::new(DamagedFiles::new(reader, folder)),
            Method::Calls(start) | Method::Program(start) => start(folder),
        }
    }

    /// Returns the time that a damaged input may take over its undamaged twin: less for planted faults, whose tests wait for it.
    pub(crate) fn max_delay(&self) -> Duration {
        Duration::from_secs(if self.name == planted::TARGET.name {
            2
        } else {
            10
        })
    }

    /// Returns whether the whole command is run.
    pub(crate) fn is_program(&self) -> bool {
        matches!(self.method, Method::Program(_))
    }
}

/// A target with its seeds.
pub(crate) trait Attack {
    /// Returns the number of seeds. Case `n` begins with seed `n` modulo this number.
    fn seeds(&self) -> usize;

    /// Runs a case and leaves its inputs in the folder of the case.
    fn run(&mut self, case: &mut Case);

    /// Prepares the folder for the next case, after the inputs of a finding were kept.
    fn clean_up(&mut self, _folder: &Path) {}
}

/// Every target, in the order of the table.
pub(crate) const ALL: &[&Target] = &[
    &exr::TARGET,
    &image::PNG,
    &image::TIFF,
    &image::DPX,
    &image::HDR,
    &image::JPEG,
    &photograph::DNG,
    &photograph::FITS,
    &photograph::PGM,
    &profile::TARGET,
    &manifest::TARGET,
    &animation::TARGET,
    &lens_table::TARGET,
    &frames::TARGET,
    &patterns::TARGET,
    &lists::TARGET,
    &ocio::TARGET,
    &tables::CUBE,
    &tables::SPI1D,
    &c_abi::TARGET,
    &program::TARGET,
    &kill::TARGET,
    &full_disk::TARGET,
    &unsteady_file::TARGET,
];

/// Returns the target of this name, also the hidden one.
pub(crate) fn named(name: &str) -> Option<&'static Target> {
    let mut all = ALL.iter().copied().chain([&planted::TARGET]);
    all.find(|target| target.name == name)
}

/// Returns the targets of these names, or all.
pub(crate) fn chosen(names: &[String]) -> Result<Vec<&'static Target>, String> {
    if names.is_empty() {
        return Ok(ALL.to_vec());
    }
    let known = || ALL.iter().map(|t| t.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        named(name).ok_or_else(|| format!("--only: no target {name}; there are {}", known()))
    };
    names.iter().map(find).collect()
}
