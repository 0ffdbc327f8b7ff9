//! The host that has loaded the plugin. A binary serves one at a time, and may be loaded by it several times.

use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{Props, Suites};
use crate::sys::OfxHost;
use crate::sys::property::NAME;

/// A host: its suites, and what it says of itself.
#[derive(Debug)]
pub(crate) struct Host {
    pub(crate) suites: Suites,
    /// Its name, reverse-DNS or not.
    pub(crate) name: String,
}

// SAFETY: pointers to functions and properties that the host lets any thread use.
unsafe impl Send for Host {}
// SAFETY: as above.
unsafe impl Sync for Host {}

/// What the host handed in as itself.
static GIVEN: AtomicPtr<OfxHost> = AtomicPtr::new(std::ptr::null_mut());

struct Loaded {
    host: Option<Arc<Host>>,
    /// Loads that were not undone yet.
    loads: u32,
}

static LOADED: Mutex<Loaded> = Mutex::new(Loaded {
    host: None,
    loads: 0,
});

fn lock() -> MutexGuard<'static, Loaded> {
    // It is whole wherever a thread may have died.
    LOADED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps the host, to be asked when the plugin is loaded.
pub(crate) fn set(host: *mut OfxHost) {
    if !host.is_null() {
        GIVEN.store(host, Ordering::Release);
    }
}

impl Host {
    fn new() -> Result<Self, String> {
        let given = GIVEN.load(Ordering::Acquire);
        if given.is_null() {
            return Err("no host was set".to_owned());
        }
        // SAFETY: the host vouches for itself for as long as the plugin is loaded.
        let host = unsafe { &*given };
        // SAFETY: as above.
        let suites = unsafe { Suites::of(host) };
        let suites =
            suites.map_err(|name| format!("the host has no {}", name.to_string_lossy()))?;
        let properties = Props::of(&suites.property, host.host);
        let name = properties.string(NAME, 0).unwrap_or_default();
        Ok(Self { suites, name })
    }

    /// Whether it is DaVinci Resolve: it says of every clip that it is connected, and its messages cannot be taken back.
    pub(crate) fn is_resolve(&self) -> bool {
        self.name.starts_with("DaVinciResolve")
    }
}

/// Counts a load; fetches the suites anew.
pub(crate) fn loaded() -> Result<Arc<Host>, String> {
    let host = Arc::new(Host::new()?);
    let mut loaded = lock();
    loaded.host = Some(Arc::clone(&host));
    loaded.loads += 1;
    Ok(host)
}

/// Undoes a load; whether it was the last.
pub(crate) fn unloaded() -> bool {
    let mut loaded = lock();
    loaded.loads = loaded.loads.saturating_sub(1);
    if loaded.loads == 0 {
        loaded.host = None;
    }
    loaded.loads == 0
}

/// The host, nothing while the plugin is not loaded.
pub(crate) fn current() -> Option<Arc<Host>> {
    lock().host.clone()
}
