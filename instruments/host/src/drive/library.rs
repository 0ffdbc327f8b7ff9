//! The plugin's binary and its exports.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};

use libloading::Symbol;
use openfx::sys::generic::core::*;

use crate::host::ActiveHost;

/// A loaded binary.
pub struct Library {
    inner: libloading::Library,
    path: PathBuf,
}

/// A plugin of a binary, which it must not outlive.
#[derive(Clone)]
pub struct Plugin {
    raw: *const OfxPlugin,
    /// Its identifier.
    pub id: String,
    /// Its major and minor version.
    pub version: (u32, u32),
    /// The API that it implements, with the version of that API.
    pub api: (String, i32),
}

// SAFETY: hosts may call plugins from any thread.
unsafe impl Send for Plugin {}
// SAFETY: as above.
unsafe impl Sync for Plugin {}

type GetNumberOfPlugins = unsafe extern "C" fn() -> c_int;
type GetPlugin = unsafe extern "C" fn(c_int) -> *const OfxPlugin;

/// Returns the binary in a bundle, or `path` itself if it is a file.
#[must_use]
pub fn binary_path(path: &Path) -> PathBuf {
    // The loader searches the folders of the system for a name without a folder.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    if !path.is_dir() {
        return path;
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
    // X.ofx.bundle contains X.ofx.
    let name = path.file_stem().unwrap_or_default();
    path.join("Contents").join(folder).join(name)
}

impl Library {
    /// Loads a binary, or that of a bundle.
    ///
    /// # Errors
    /// If it cannot be loaded or lacks an export.
    pub fn open(path: &Path) -> Result<Self, String> {
        let path = binary_path(path);
        // SAFETY: runs the initialisers of the plugin, as every host does.
        let inner = unsafe { libloading::Library::new(&path) }
            .map_err(|e| format!("{}: the binary cannot be loaded: {e}", path.display()))?;
        let library = Self { inner, path };
        library.export::<GetNumberOfPlugins>(c"OfxGetNumberOfPlugins")?;
        library.export::<GetPlugin>(c"OfxGetPlugin")?;
        Ok(library)
    }

    fn export<T>(&self, name: &CStr) -> Result<Symbol<'_, T>, String> {
        // SAFETY: the types are those of the OpenFX header.
        unsafe { self.inner.get(name.to_bytes_with_nul()) }.map_err(|_| {
            format!(
                "{}: the binary does not export {}",
                self.path.display(),
                name.to_string_lossy()
            )
        })
    }

    /// Calls OfxGetNumberOfPlugins.
    #[must_use]
    pub fn count(&self) -> c_int {
        self.export::<GetNumberOfPlugins>(c"OfxGetNumberOfPlugins")
            // SAFETY: takes no arguments.
            .map_or(0, |count| unsafe { count() })
    }

    /// Calls OfxGetPlugin and returns the address as it is: plugins give anything for an index that they do not have.
    #[must_use]
    pub fn plugin_address(&self, index: c_int) -> usize {
        let get = self.export::<GetPlugin>(c"OfxGetPlugin");
        // SAFETY: every index is allowed.
        get.map_or(0, |get| unsafe { get(index) } as usize)
    }

    /// Calls OfxGetPlugin with an index below [`Self::count`]; returns nothing for NULL and addresses that cannot be those of a
    /// plugin.
    #[must_use]
    pub fn plugin(&self, index: c_int) -> Option<Plugin> {
        let raw = self.plugin_address(index) as *const OfxPlugin;
        if raw.is_null() || !raw.is_aligned() {
            return None;
        }
        let text = |text: *const c_char| {
            if text.is_null() {
                String::new()
            } else {
                // SAFETY: strings of the structure are terminated.
                unsafe { CStr::from_ptr(text) }
                    .to_string_lossy()
                    .into_owned()
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

    /// Returns all plugins.
    #[must_use]
    pub fn plugins(&self) -> Vec<Plugin> {
        (0..self.count()).filter_map(|n| self.plugin(n)).collect()
    }

    /// Returns the plugin with an identifier, or the first without one.
    ///
    /// # Errors
    /// If the library has no such plugin.
    pub fn find(&self, id: Option<&str>) -> Result<Plugin, String> {
        let all = self.plugins();
        (all.iter())
            .find(|plugin| id.is_none_or(|id| plugin.id == id))
            .cloned()
            .ok_or_else(|| {
                let ids: Vec<_> = all.iter().map(|p| p.id.as_str()).collect();
                format!(
                    "{}: no such plugin; the binary has {ids:?}",
                    self.path.display()
                )
            })
    }

    /// Unloads the binary.
    ///
    /// # Errors
    /// If that fails.
    pub fn close(self) -> Result<(), String> {
        (self.inner.close()).map_err(|e| format!("the binary cannot be unloaded: {e}"))
    }
}

impl Plugin {
    /// Calls setHost.
    pub fn set_host(&self, host: &ActiveHost) {
        // SAFETY: the binary is loaded.
        if let Some(set_host) = unsafe { (*self.raw).setHost } {
            // SAFETY: the structure is never freed.
            unsafe { set_host(host.raw()) };
        }
    }

    /// Returns whether neither of its functions is NULL.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        // SAFETY: the binary is loaded.
        unsafe { (*self.raw).setHost.is_some() && (*self.raw).mainEntry.is_some() }
    }

    /// Calls mainEntry.
    pub(crate) fn main_entry(
        &self,
        action: &CStr,
        handle: usize,
        in_args: usize,
        out_args: usize,
    ) -> OfxStatus {
        // SAFETY: the binary is loaded.
        let Some(entry) = (unsafe { (*self.raw).mainEntry }) else {
            return kOfxStatFailed;
        };
        // A copy that is freed after the call, because plugins must not keep the pointer.
        let action: CString = action.to_owned();
        // SAFETY: handles are numbers that plugins only pass back.
        unsafe {
            entry(
                action.as_ptr(),
                handle as *const c_void,
                in_args as *mut _,
                out_args as *mut _,
            )
        }
    }
}
