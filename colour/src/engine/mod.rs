//! The interface to an implementation of OpenColorIO.

#[cfg(feature = "ocio-native")]
mod native;
#[cfg(all(feature = "ocio", not(feature = "ocio-native")))]
mod port;

use std::path::Path;

use crate::Source;

/// A pixel for an engine: R, G, B and an alpha of 1, which is ignored on return.
pub type Pixel = [f32; 4];

/// A colour space of a config.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Space {
    /// Its name.
    pub name: String,
    /// Its other names.
    pub aliases: Vec<String>,
    /// Its place in menus, such as `Input/ARRI`; empty if the config does not say.
    pub family: String,
    /// Its encoding, such as `scene-linear` or `log`; empty if the config does not say.
    pub encoding: String,
    /// Its description in the config.
    pub description: String,
    /// Whether it holds data, such as depth, which is never converted.
    pub is_data: bool,
}

impl Space {
    /// Returns whether the config declares the space proportional to scene light.
    pub fn is_scene_linear(&self) -> bool {
        self.encoding == "scene-linear"
    }
}

/// A display of a config.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Display {
    /// Its name.
    pub name: String,
    /// The names of its views.
    pub views: Vec<String>,
}

/// The space that the file rules of a config assign to a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileSpace {
    /// Its name.
    pub space: String,
    /// Whether only the last rule matched, which matches every file.
    pub is_default: bool,
}

/// Result of an engine; the error is the engine's own message.
pub type EngineResult<T> = std::result::Result<T, String>;

/// An implementation of OpenColorIO.
pub trait ColourEngine: Send + Sync {
    /// Returns its name and version.
    fn name(&self) -> String;

    /// Reads a config.
    fn load(&self, source: &Source) -> EngineResult<Box<dyn EngineConfig>>;
}

/// A config in memory.
pub trait EngineConfig: Send + Sync {
    /// Returns its active colour spaces, in the order of the config.
    fn spaces(&self) -> Vec<Space>;

    /// Returns its roles, each with the name of a space.
    fn roles(&self) -> Vec<(String, String)>;

    /// Returns its active displays.
    fn displays(&self) -> Vec<Display>;

    /// Returns the space with this name, alias or role, whether active or not.
    fn space(&self, name: &str) -> Option<Space>;

    /// Applies the file rules to a path.
    fn file_space(&self, path: &Path) -> Option<FileSpace>;

    /// Creates the transform from the space `from` to the space `to`.
    fn processor(&self, from: &str, to: &str) -> EngineResult<Box<dyn EngineProcessor>>;

    /// Creates the transform from the space `from` to `display`, through `view`.
    fn display_processor(
        &self,
        from: &str,
        display: &str,
        view: &str,
    ) -> EngineResult<Box<dyn EngineProcessor>>;
}

/// A transform from one colour space to another.
pub trait EngineProcessor: Send + Sync {
    /// Returns whether it leaves every pixel unchanged.
    fn is_no_op(&self) -> bool;

    /// Converts pixels in place.
    fn apply(&self, pixels: &mut [Pixel]);
}

/// Returns the engine selected by the crate's features.
#[cfg(feature = "ocio-native")]
pub(crate) fn default_engine() -> crate::Result<Box<dyn ColourEngine>> {
    Ok(Box::new(native::Native::new()?))
}

/// Returns the engine selected by the crate's features.
#[cfg(all(feature = "ocio", not(feature = "ocio-native")))]
pub(crate) fn default_engine() -> crate::Result<Box<dyn ColourEngine>> {
    Ok(Box::new(port::Port::new()))
}
