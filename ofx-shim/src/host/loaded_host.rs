//! The host that loaded the plugin. A binary has one host at a time, which may load it several times.

use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{PropertySet, Suites};
use crate::sys::plugin::STATUS_OK;
use crate::sys::property::NAME;
use crate::sys::{Handle, OfxHost};

/// A host: its suites and its name.
#[derive(Debug)]
pub(crate) struct Host {
    pub(crate) suites: Suites,
    /// The host's name, reverse-DNS or not.
    pub(crate) name: String,
}

// SAFETY: the struct holds pointers to functions and properties that the host lets any thread use.
unsafe impl Send for Host {}
// SAFETY: as above.
unsafe impl Sync for Host {}

/// The pointer that the host passed to `OfxSetHost` or `setHost`.
static HOST_POINTER: AtomicPtr<OfxHost> = AtomicPtr::new(std::ptr::null_mut());

struct LoadState {
    host: Option<Arc<Host>>,
    /// Number of loads without an unload.
    loads: u32,
}

static LOAD_STATE: Mutex<LoadState> = Mutex::new(LoadState {
    host: None,
    loads: 0,
});

fn lock() -> MutexGuard<'static, LoadState> {
    // The state is consistent even if a thread panicked while it held the lock.
    LOAD_STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stores the host's pointer, from which [`load`] fetches suites.
pub(crate) fn set_host(host: *mut OfxHost) {
    if !host.is_null() {
        HOST_POINTER.store(host, Ordering::Release);
    }
}

impl Host {
    fn new() -> Result<Self, String> {
        let pointer = HOST_POINTER.load(Ordering::Acquire);
        if pointer.is_null() {
            return Err("no host was set".to_owned());
        }
        // SAFETY: the host's struct lives as long as the plugin is loaded.
        let host = unsafe { &*pointer };
        // SAFETY: as above.
        let suites = unsafe { Suites::fetch_all(host) };
        let suites =
            suites.map_err(|name| format!("the host has no {}", name.to_string_lossy()))?;
        let properties = PropertySet::new(&suites.property, host.host);
        let name = properties.string(NAME, 0).unwrap_or_default();
        Ok(Self { suites, name })
    }

    /// Returns the property set of a handle, which may be NULL.
    pub(crate) fn property_set(&self, handle: Handle) -> PropertySet<'_> {
        PropertySet::new(&self.suites.property, handle)
    }

    /// Returns whether the host is DaVinci Resolve, which reports every clip as connected and cannot clear messages.
    pub(crate) fn is_resolve(&self) -> bool {
        self.name.starts_with("DaVinciResolve")
    }

    /// Returns whether the host is MLT, whose images have their rows from the top.
    pub(crate) fn is_mlt(&self) -> bool {
        self.name == "MLT"
    }

    /// Returns the number of threads to use; 0 means all CPUs, also if the host sets no limit.
    pub(crate) fn threads(&self) -> u32 {
        // Resolve's suite is a stub that always reports one CPU (openfx-supportext).
        let suite = self.suites.multi_thread.filter(|_| !self.is_resolve());
        let Some(num_cpus) = suite.and_then(|suite| suite.num_cpus) else {
            return 0;
        };
        let mut threads = 0;
        // SAFETY: a function of the host, and memory for the number.
        let status = unsafe { num_cpus(&raw mut threads) };
        let available = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
        if status == STATUS_OK && (1..available).contains(&threads) {
            threads
        } else {
            0
        }
    }
}

/// Fetches the host's suites and counts a load.
///
/// # Errors
/// A required suite that the host does not have.
pub(crate) fn load() -> Result<Arc<Host>, String> {
    let host = Arc::new(Host::new()?);
    let mut state = lock();
    state.host = Some(Arc::clone(&host));
    state.loads += 1;
    Ok(host)
}

/// Counts an unload; returns whether it was the last.
pub(crate) fn unload() -> bool {
    let mut state = lock();
    state.loads = state.loads.saturating_sub(1);
    if state.loads == 0 {
        state.host = None;
    }
    state.loads == 0
}

/// Returns the host, or `None` if the plugin is not loaded.
pub(crate) fn current() -> Option<Arc<Host>> {
    lock().host.clone()
}
