//! The host as plugins see it: handles, property sets and suites. It records whatever a plugin does wrong.

pub mod action;
pub mod effect;
mod guarded;
mod handles;
pub mod images;
pub mod profile;
pub mod profiles;
pub mod properties;
pub mod render_time;
pub mod sample_type;
pub mod suites;

use std::collections::{BTreeSet, HashMap};
use std::ffi::{CStr, CString};
use std::fmt;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Instant;

use openfx::sys::generic::core::OfxHost;

pub(crate) use handles::{HandleTarget, Object, OwnHandle};
use profile::Profile;
use properties::{PropertySet, Schema, Values};
use render_time::ImageWork;

/// Locks a mutex, whether or not a thread panicked while holding it.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The most faults that are recorded between two calls of [`Host::take_misuse`].
const MAX_MISUSE: usize = 50;

/// The kind of access to a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AccessMode {
    /// Read, or its dimension asked for.
    Read,
    /// Set or reset.
    Set,
}

impl fmt::Display for AccessMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Set => "set",
        })
    }
}

/// An access of a property by the plugin.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Access {
    /// The kind of access.
    pub mode: AccessMode,
    /// The kind of property set.
    pub kind: String,
    /// The property.
    pub property: String,
}

/// The lifetime of strings that the host lends. OpenFX guarantees it only until the next suite call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StringLifetime {
    /// Until the next suite call on the same object, which overwrites them.
    NextCall,
    /// As long as the object.
    Object,
}

/// A message of the plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// `OfxMessageError`, `OfxMessageWarning` and so on.
    pub kind: String,
    /// The printf format.
    pub format: String,
    /// The text that is printed; empty if the format has conversions other than a single `%s`.
    pub text: String,
    /// Whether it stays until it is cleared.
    pub persistent: bool,
}

/// Numbers of resources that plugins hold, and of abort calls.
#[derive(Debug, Default)]
pub struct Counters {
    /// Images fetched in all.
    pub images_fetched: AtomicUsize,
    /// Images not yet released.
    pub images_held: AtomicI64,
    /// Memory blocks not yet freed.
    pub memory_held: AtomicI64,
    /// Mutexes not yet destroyed.
    pub mutexes_held: AtomicI64,
    /// Calls of `abort`.
    pub abort_polls: AtomicUsize,
    /// Calls of `abort` that returned yes.
    pub abort_replies: AtomicUsize,
    /// Steps of undo: edits begun, and values that an overlay sets outside them.
    pub undo_steps: AtomicUsize,
    /// Parameter edits begun and not yet ended.
    pub edits_open: AtomicI64,
    /// Progress begun and not yet ended.
    pub progress_open: AtomicI64,
}

/// A host that behaves as its profile says.
pub struct Host {
    /// The kind of host.
    pub profile: Profile,
    handles: handles::HandleTable,
    misuse: Mutex<Vec<String>>,
    accesses: Mutex<BTreeSet<Access>>,
    hidden_access: Mutex<Option<Access>>,
    overwrites_strings: AtomicBool,
    pub(crate) messages: Mutex<Vec<Message>>,
    pub(crate) persistent: Mutex<Option<Message>>,
    /// Resources that plugins hold.
    pub counters: Counters,
    /// Calls of `abort` that will return no; negative for all.
    pub(crate) polls_before_abort: AtomicI64,
    /// The moment from which `abort` returns yes.
    pub(crate) abort_from: Mutex<Option<Instant>>,
    /// Work on images in the render under way.
    pub(crate) image_work: Mutex<ImageWork>,
    pub(crate) path: Mutex<CString>,
    pub(crate) processors: AtomicUsize,
    pub(crate) threads_fail: AtomicBool,
    pub(crate) images: Mutex<HashMap<usize, images::FetchedImage>>,
    /// Handles of memory blocks, by address.
    pub(crate) blocks: Mutex<HashMap<usize, usize>>,
    pub(crate) drawing: Mutex<suites::Drawing>,
    pub(crate) properties: Arc<PropertySet>,
    suites: &'static suites::Suites,
}

static CURRENT: RwLock<Option<Arc<Host>>> = RwLock::new(None);

/// Held by the active host. Suite functions do not know which host they belong to, so one host is active at a time.
static ACTIVE: Mutex<()> = Mutex::new(());

/// Returns the active host.
pub(crate) fn current() -> Option<Arc<Host>> {
    CURRENT
        .read()
        .unwrap_or_else(PoisonError::into_inner)
        .clone()
}

fn set_current(host: Option<Arc<Host>>) {
    *CURRENT.write().unwrap_or_else(PoisonError::into_inner) = host;
}

/// A host that receives the calls of plugins until it is dropped.
pub struct ActiveHost {
    host: Arc<Host>,
    raw: usize,
    _active: MutexGuard<'static, ()>,
}

impl Deref for ActiveHost {
    type Target = Host;

    fn deref(&self) -> &Host {
        &self.host
    }
}

impl Drop for ActiveHost {
    fn drop(&mut self) {
        set_current(None);
    }
}

impl ActiveHost {
    /// Returns the structure for `setHost`, which is never freed.
    pub(crate) fn raw(&self) -> *mut OfxHost {
        self.raw as *mut OfxHost
    }
}

impl Host {
    /// Creates a host and activates it, after waiting for any active host to be dropped.
    #[must_use]
    pub fn activate(profile: Profile) -> ActiveHost {
        let active = locked(&ACTIVE);
        let values = properties::host_properties(&profile);
        let set = Arc::new(PropertySet::new("host", "the host", values, Schema::Fixed));
        let suites = suites::Suites::new(&profile);
        let host = Arc::new(Self {
            handles: handles::HandleTable::default(),
            misuse: Mutex::default(),
            accesses: Mutex::default(),
            hidden_access: Mutex::default(),
            overwrites_strings: AtomicBool::new(true),
            messages: Mutex::default(),
            persistent: Mutex::default(),
            counters: Counters::default(),
            polls_before_abort: AtomicI64::new(-1),
            abort_from: Mutex::default(),
            image_work: Mutex::default(),
            path: Mutex::new(CString::default()),
            processors: AtomicUsize::new(profile.processors as usize),
            threads_fail: AtomicBool::new(false),
            images: Mutex::default(),
            blocks: Mutex::default(),
            drawing: Mutex::default(),
            properties: Arc::clone(&set),
            suites,
            profile,
        });
        let handle = host.register("the host", Object::Properties(Arc::clone(&set)));
        set.set_handle(handle);
        let raw = suites::leak(OfxHost {
            host: handle as *mut _,
            fetchSuite: Some(suites::fetch),
        });
        set_current(Some(Arc::clone(&host)));
        ActiveHost {
            host,
            raw: raw as usize,
            _active: active,
        }
    }

    /// Records something that plugins must not do.
    pub fn record_misuse(&self, text: impl Into<String>) {
        let text = text.into();
        let mut all = locked(&self.misuse);
        if all.len() < MAX_MISUSE && !all.contains(&text) {
            all.push(text);
        }
    }

    /// Returns the recorded misuse and clears it.
    pub fn take_misuse(&self) -> Vec<String> {
        std::mem::take(&mut locked(&self.misuse))
    }

    /// Returns all property accesses so far and clears them.
    pub fn take_accesses(&self) -> BTreeSet<Access> {
        std::mem::take(&mut locked(&self.accesses))
    }

    /// Makes such accesses fail as if the property did not exist; `None` ends that.
    pub fn hide(&self, access: Option<Access>) {
        *locked(&self.hidden_access) = access;
    }

    /// Sets how long lent strings stay valid. The default is [`StringLifetime::NextCall`].
    pub fn set_string_lifetime(&self, lifetime: StringLifetime) {
        let overwrites = lifetime == StringLifetime::NextCall;
        self.overwrites_strings.store(overwrites, Ordering::SeqCst);
    }

    pub(crate) fn overwrites_strings(&self) -> bool {
        self.overwrites_strings.load(Ordering::SeqCst)
    }

    /// Records an access of a property. Returns whether this host has the property.
    pub(crate) fn access(&self, set: &PropertySet, property: &str, mode: AccessMode) -> bool {
        let access = Access {
            mode,
            kind: set.kind.clone(),
            property: property.to_owned(),
        };
        let missing = (self.profile.missing_properties.iter())
            .any(|name| name.to_bytes() == property.as_bytes());
        let hidden = locked(&self.hidden_access).as_ref() == Some(&access);
        locked(&self.accesses).insert(access);
        !missing && !hidden
    }

    /// Creates a property set with a handle.
    pub(crate) fn property_set(
        &self,
        kind: &str,
        name: &str,
        values: Values,
        schema: Schema,
    ) -> Arc<PropertySet> {
        let set = Arc::new(PropertySet::new(kind, name, values, schema));
        set.set_handle(self.register(name, Object::Properties(Arc::clone(&set))));
        set
    }

    /// Creates a handle of an object, which messages call `name`.
    pub(crate) fn register(&self, name: &str, object: Object) -> usize {
        self.handles.register(name, object)
    }

    /// Invalidates a handle. Returns whether it was valid.
    pub(crate) fn invalidate(&self, handle: usize) -> bool {
        self.handles.invalidate(handle)
    }

    /// Returns the object of a handle; records misuse if it is invalid or of another type.
    pub(crate) fn find<T: HandleTarget>(&self, handle: usize, call: &str) -> Option<Arc<T>> {
        match self.handles.find(handle) {
            Ok(object) => T::downcast(&object).or_else(|| {
                self.record_misuse(format!("{call} was given a handle of another type"));
                None
            }),
            Err(handle) => {
                self.record_misuse(format!("{call} was given {handle}"));
                None
            }
        }
    }

    /// Returns the messages so far and clears them.
    pub fn take_messages(&self) -> Vec<Message> {
        std::mem::take(&mut locked(&self.messages))
    }

    /// Returns the current persistent message.
    pub fn persistent_message(&self) -> Option<Message> {
        locked(&self.persistent).clone()
    }

    /// Returns whether `abort` will return yes sooner or later.
    pub(crate) fn aborts(&self) -> bool {
        self.polls_before_abort.load(Ordering::SeqCst) >= 0
    }

    /// Makes `abort` return no to the next `polls` calls and yes to all later ones; `None` means always no.
    pub fn abort_after(&self, polls: Option<usize>) {
        let left = polls.map_or(-1, |n| i64::try_from(n).unwrap_or(i64::MAX));
        self.counters.abort_polls.store(0, Ordering::SeqCst);
        self.counters.abort_replies.store(0, Ordering::SeqCst);
        self.polls_before_abort.store(left, Ordering::SeqCst);
    }

    /// Sets the number of processors that the multi-thread suite reports.
    pub fn set_processors(&self, processors: usize) {
        self.processors.store(processors, Ordering::SeqCst);
    }

    /// Makes the functions of the multi-thread suite fail.
    pub fn fail_threads(&self) {
        self.threads_fail.store(true, Ordering::SeqCst);
    }

    /// Sets the path of the bundle that plugins are given.
    pub fn set_path(&self, path: &CStr) {
        path.clone_into(&mut locked(&self.path));
    }

    /// Describes the resources that plugins still hold.
    #[must_use]
    pub fn held_resources(&self) -> Vec<String> {
        let c = &self.counters;
        let rows = [
            ("images not released", &c.images_held),
            ("memory blocks not freed", &c.memory_held),
            ("mutexes not destroyed", &c.mutexes_held),
            ("parameter edits not ended", &c.edits_open),
            ("progress not ended", &c.progress_open),
        ];
        rows.iter()
            .map(|(what, count)| (what, count.load(Ordering::SeqCst)))
            .filter(|(_, count)| *count != 0)
            .map(|(what, count)| format!("{count} {what}"))
            .collect()
    }

    pub(crate) fn suite(&self, name: &CStr, version: i32) -> *const std::ffi::c_void {
        self.suites.get(&self.profile, name, version)
    }
}
