//! What an OpenColorIO has to do for us, whoever wrote it.

#[cfg(feature = "ocio-native")]
mod native;
#[cfg(all(feature = "ocio", not(feature = "ocio-native")))]
mod port;

use std::path::Path;

use crate::Source;

/// A pixel as engines have it. The fourth number is alpha, which they are given as 1 and which nobody reads.
pub type Pixel = [f32; 4];

/// A colour space of a config.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Space {
    /// Its name.
    pub name: String,
    /// Other names for it.
    pub aliases: Vec<String>,
    /// Its place in menus, such as `Input/ARRI`; empty if the config says none.
    pub family: String,
    /// What its numbers are, such as `scene-linear` or `log`; empty if the config does not say.
    pub encoding: String,
    /// What the config says of it.
    pub description: String,
    /// Whether it holds numbers that are no colour, which nothing converts.
    pub is_data: bool,
}

impl Space {
    /// Whether numbers are proportional to the light of the scene, as far as the config says.
    pub fn is_scene_linear(&self) -> bool {
        self.encoding == "scene-linear"
    }
}

/// A display of a config.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Display {
    /// Its name.
    pub name: String,
    /// The views there are on it.
    pub views: Vec<String>,
}

/// The space that the file rules of a config give a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileSpace {
    /// Its name.
    pub space: String,
    /// Whether no rule but the last, which is for all files, spoke of it.
    pub is_default: bool,
}

/// An implementation of OpenColorIO.
pub trait ColourEngine: Send + Sync {
    /// Which one, with its version.
    fn name(&self) -> String;

    /// Reads a config; why not, in the engine's words.
    fn load(&self, source: &Source) -> EngineResult<Box<dyn EngineConfig>>;
}

/// A config in memory.
pub trait EngineConfig: Send + Sync {
    /// Its active colour spaces, in the order of the config.
    fn spaces(&self) -> Vec<Space>;

    /// Its roles, each with the name of a space.
    fn roles(&self) -> Vec<(String, String)>;

    /// Its active displays.
    fn displays(&self) -> Vec<Display>;

    /// The space with this name, alias or role, those not active included.
    fn space(&self, name: &str) -> Option<Space>;

    /// What the file rules say of a file by its path.
    fn file_space(&self, path: &Path) -> Option<FileSpace>;

    /// What turns colours of the space `from` into those of `to`; why not, in the engine's words.
    fn processor(&self, from: &str, to: &str) -> EngineResult<Box<dyn EngineProcessor>>;

    /// What turns colours of the space `from` into what `display` is to be sent for `view`.
    fn display_processor(
        &self,
        from: &str,
        display: &str,
        view: &str,
    ) -> EngineResult<Box<dyn EngineProcessor>>;
}

/// Result of an engine, which on failure gives its own words.
pub type EngineResult<T> = std::result::Result<T, String>;

/// What turns colours of one space into those of another.
pub trait EngineProcessor: Send + Sync {
    /// Whether it leaves all colours as they are.
    fn is_no_op(&self) -> bool;

    /// Puts what becomes of pixels in their place.
    fn apply(&self, pixels: &mut [Pixel]);
}

/// The engine that this was built with.
#[cfg(feature = "ocio-native")]
pub(crate) fn built_in() -> crate::Result<Box<dyn ColourEngine>> {
    Ok(Box::new(native::Native::new()?))
}

/// The engine that this was built with.
#[cfg(all(feature = "ocio", not(feature = "ocio-native")))]
pub(crate) fn built_in() -> crate::Result<Box<dyn ColourEngine>> {
    Ok(Box::new(port::Port::new()))
}
