//! The plugin's binary and what it exports.

use std::ffi::{CStr, CString, c_int, c_void};
use std::path::{Path, PathBuf};

use libloading::Symbol;
use openfx::sys::generic::core::*;

use crate::host::Entered;

/// A binary, loaded.
pub struct Library {
    inner: libloading::Library,
    path: PathBuf,
}

/// One plugin of a binary. It must not outlive it.
#[derive(Clone)]
pub struct Plugin {
    raw: *const OfxPlugin,
    /// Its identifier.
    pub id: String,
    /// Major and minor version.
    pub version: (u32, u32),
    /// The API it is for, and that API's version.
    pub api: (String, i32),
}

// SAFETY: hosts call plugins from any thread.
unsafe impl Send for Plugin {}
// SAFETY: as above.
unsafe impl Sync for Plugin {}

type Count = unsafe extern "C" fn() -> c_int;
type Get = unsafe extern "C" fn(c_int) -> *const OfxPlugin;

/// The binary in a bundle, or the file itself.
#[must_use]
pub fn binary_of(path: &Path) -> PathBuf {
    if !path.is_dir() {
        return path.to_owned();
    }
    let folder = if cfg!(target_os = "macos") {
        "MacOS"
    } else if cfg!(windows) {
        "Win64"
    } else if cfg!(target_arch = "aarch64") {
        "Linux-aarch64"
    } else {
        "Linux-x86-64"
    };
    // Both are called the same, but for the last extension.
    let name = path.file_stem().unwrap_or_default();
    path.join("Contents").join(folder).join(name)
}

impl Library {
    /// Loads the binary, or the one in the bundle.
    ///
    /// # Errors
    /// If it cannot be loaded or lacks an export.
    pub fn open(path: &Path) -> Result<Self, String> {
        let path = binary_of(path);
        // SAFETY: a plugin's initialisers are run, as hosts do.
        let inner = unsafe { libloading::Library::new(&path) }
            .map_err(|why| format!("{}: cannot be loaded: {why}", path.display()))?;
        let library = Self { inner, path };
        library.export::<Count>(c"OfxGetNumberOfPlugins")?;
        library.export::<Get>(c"OfxGetPlugin")?;
        Ok(library)
    }

    fn export<T>(&self, name: &CStr) -> Result<Symbol<'_, T>, String> {
        // SAFETY: the types are those of the header.
        unsafe { self.inner.get(name.to_bytes_with_nul()) }.map_err(|_| {
            format!(
                "{}: does not export {}",
                self.path.display(),
                name.to_string_lossy()
            )
        })
    }

    /// How many plugins it says it has.
    #[must_use]
    pub fn count(&self) -> c_int {
        self.export::<Count>(c"OfxGetNumberOfPlugins")
            // SAFETY: takes nothing.
            .map_or(0, |count| unsafe { count() })
    }

    /// The plugin of that number, nothing if the binary gives NULL.
    #[must_use]
    pub fn plugin(&self, nth: c_int) -> Option<Plugin> {
        let get = self.export::<Get>(c"OfxGetPlugin").ok()?;
        // SAFETY: any number may be asked for.
        let raw = unsafe { get(nth) };
        if raw.is_null() {
            return None;
        }
        let text = |at: *const std::ffi::c_char| {
            if at.is_null() {
                String::new()
            } else {
                // SAFETY: the strings of the structure end in a zero.
                unsafe { CStr::from_ptr(at) }.to_string_lossy().into_owned()
            }
        };
        // SAFETY: valid as long as the binary is loaded.
        let plugin = unsafe { &*raw };
        Some(Plugin {
            raw,
            id: text(plugin.pluginIdentifier),
            version: (plugin.pluginVersionMajor, plugin.pluginVersionMinor),
            api: (text(plugin.pluginApi), plugin.apiVersion),
        })
    }

    /// All plugins.
    #[must_use]
    pub fn plugins(&self) -> Vec<Plugin> {
        (0..self.count()).filter_map(|n| self.plugin(n)).collect()
    }

    /// The plugin with that identifier, or the first.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(&self, id: Option<&str>) -> Result<Plugin, String> {
        let all = self.plugins();
        (all.iter())
            .find(|plugin| id.is_none_or(|id| plugin.id == id))
            .cloned()
            .ok_or_else(|| {
                let ids: Vec<_> = all.iter().map(|p| p.id.as_str()).collect();
                format!("{}: has {ids:?}", self.path.display())
            })
    }

    /// Takes it out of the process again.
    ///
    /// # Errors
    /// If that fails.
    pub fn close(self) -> Result<(), String> {
        (self.inner.close()).map_err(|why| format!("cannot be unloaded: {why}"))
    }
}

impl Plugin {
    /// Tells the plugin of its host, and the host of where the plugin is.
    pub fn set_host(&self, host: &Entered) {
        // SAFETY: the binary is loaded.
        if let Some(set) = unsafe { (*self.raw).setHost } {
            // SAFETY: the structure stays for good.
            unsafe { set(host.raw()) };
        }
    }

    /// Whether it has both functions.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        // SAFETY: the binary is loaded.
        unsafe { (*self.raw).setHost.is_some() && (*self.raw).mainEntry.is_some() }
    }

    /// Its main entry point, with handles as numbers.
    pub(crate) fn main_entry(
        &self,
        action: &CStr,
        handle: usize,
        given: usize,
        wanted: usize,
    ) -> OfxStatus {
        // SAFETY: the binary is loaded.
        let Some(entry) = (unsafe { (*self.raw).mainEntry }) else {
            return kOfxStatFailed;
        };
        // A copy that ends with the call: plugins must not keep it.
        let action: CString = action.to_owned();
        // SAFETY: handles are never followed, only handed back.
        unsafe {
            entry(
                action.as_ptr(),
                handle as *const c_void,
                given as *mut _,
                wanted as *mut _,
            )
        }
    }
}
