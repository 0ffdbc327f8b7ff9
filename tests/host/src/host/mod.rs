//! The host as plugins see it: handles, property sets, suites; and what it noticed that plugins must not do.

pub mod effect;
pub mod images;
mod objects;
pub mod profile;
pub mod profiles;
pub mod properties;
pub mod suites;
pub mod under;

use std::collections::{BTreeSet, HashMap};
use std::ffi::{CStr, CString};
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, RwLock};

use openfx::sys::generic::core::OfxHost;

pub(crate) use objects::{Kept, Object};
use profile::Profile;
use properties::{PropertySet, Values};

/// What a mutex holds, whoever panicked before.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// One access of a property: what was done, to what kind of set, which property.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Access {
    /// Whether it was set rather than read.
    pub set: bool,
    /// The kind of set.
    pub kind: String,
    /// The property.
    pub property: String,
}

/// A message of the plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// `error`, `warning`..., as OpenFX calls it.
    pub kind: String,
    /// The printf format that was handed over.
    pub format: String,
    /// What it says, if the format is `%s`.
    pub text: String,
    /// Whether it stays until it is cleared.
    pub persistent: bool,
}

/// What has been handed out and not come back.
#[derive(Debug, Default)]
pub struct Counts {
    /// Images fetched in all.
    pub images: AtomicUsize,
    /// Images not released.
    pub images_out: AtomicI64,
    /// Blocks of memory not freed.
    pub memory_out: AtomicI64,
    /// Mutexes not destroyed.
    pub mutexes_out: AtomicI64,
    /// Times the plugin asked whether to stop.
    pub polls: AtomicUsize,
    /// Of these, times it was told to.
    pub polls_told: AtomicUsize,
    /// Edits of parameters begun and not ended.
    pub edits_open: AtomicI64,
    /// Progress begun and not ended.
    pub progress_open: AtomicI64,
}

/// A host of one kind.
pub struct Host {
    /// Its kind.
    pub profile: Profile,
    objects: objects::Objects,
    misuse: Mutex<Vec<String>>,
    log: Mutex<BTreeSet<Access>>,
    hidden: Mutex<Option<Access>>,
    spoils: AtomicBool,
    pub(crate) messages: Mutex<Vec<Message>>,
    pub(crate) persistent: Mutex<Option<Message>>,
    /// What is handed out.
    pub counts: Counts,
    /// Polls that are answered with no; less than 0: all.
    pub(crate) patience: AtomicI64,
    pub(crate) path: Mutex<CString>,
    pub(crate) processors: AtomicUsize,
    pub(crate) threads_fail: AtomicBool,
    pub(crate) images: Mutex<HashMap<usize, images::Fetched>>,
    pub(crate) blocks: Mutex<HashMap<usize, usize>>,
    pub(crate) strokes: Mutex<suites::Strokes>,
    pub(crate) properties: Arc<PropertySet>,
    suites: &'static suites::Suites,
}

static CURRENT: RwLock<Option<Arc<Host>>> = RwLock::new(None);

/// Hosts take turns: suite functions are told nothing of the host that they belong to.
static TURN: Mutex<()> = Mutex::new(());

/// The host whose turn it is.
pub(crate) fn current() -> Option<Arc<Host>> {
    CURRENT
        .read()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
        .clone()
}

/// A host for as long as it has its turn.
pub struct Entered {
    host: Arc<Host>,
    raw: usize,
    _turn: MutexGuard<'static, ()>,
}

impl Deref for Entered {
    type Target = Host;

    fn deref(&self) -> &Host {
        &self.host
    }
}

impl Drop for Entered {
    fn drop(&mut self) {
        *CURRENT
            .write()
            .unwrap_or_else(std::sync::PoisonError::into_inner) = None;
    }
}

impl Entered {
    /// What plugins get by `setHost`; it stays valid for good.
    pub(crate) fn raw(&self) -> *mut OfxHost {
        self.raw as *mut OfxHost
    }

    /// The host, to be shared with threads.
    #[must_use]
    pub fn shared(&self) -> Arc<Host> {
        Arc::clone(&self.host)
    }
}

impl Host {
    /// A host of this kind, as soon as no other has its turn.
    #[must_use]
    pub fn enter(profile: Profile) -> Entered {
        let turn = locked(&TURN);
        let values = properties::of_host(&profile);
        let set = Arc::new(PropertySet::new("host", "the host", values, false));
        let suites = suites::Suites::made(&profile);
        let host = Arc::new(Self {
            objects: objects::Objects::default(),
            misuse: Mutex::default(),
            log: Mutex::default(),
            hidden: Mutex::default(),
            spoils: AtomicBool::new(true),
            messages: Mutex::default(),
            persistent: Mutex::default(),
            counts: Counts::default(),
            patience: AtomicI64::new(-1),
            path: Mutex::new(CString::default()),
            processors: AtomicUsize::new(profile.processors as usize),
            threads_fail: AtomicBool::new(false),
            images: Mutex::default(),
            blocks: Mutex::default(),
            strokes: Mutex::default(),
            properties: Arc::clone(&set),
            suites,
            profile,
        });
        let handle = host
            .objects
            .keep("the host", Object::Properties(Arc::clone(&set)));
        set.known_as(handle);
        let raw = suites::for_good(OfxHost {
            host: handle as *mut _,
            fetchSuite: Some(suites::fetch),
        });
        *CURRENT
            .write()
            .unwrap_or_else(std::sync::PoisonError::into_inner) = Some(Arc::clone(&host));
        Entered {
            host,
            raw: raw as usize,
            _turn: turn,
        }
    }

    /// Notes something that plugins must not do.
    pub fn misused(&self, text: String) {
        let mut all = locked(&self.misuse);
        if all.len() < 50 && !all.contains(&text) {
            all.push(text);
        }
    }

    /// What was noted, which is forgotten thereby.
    pub fn take_misuse(&self) -> Vec<String> {
        std::mem::take(&mut locked(&self.misuse))
    }

    /// All accesses of properties so far, which are forgotten thereby.
    pub fn take_log(&self) -> BTreeSet<Access> {
        std::mem::take(&mut locked(&self.log))
    }

    /// From now on there is no such property on sets of that kind.
    pub fn hide(&self, what: Option<Access>) {
        *locked(&self.hidden) = what;
    }

    /// Whether strings lent to the plugin are overwritten at the next suite call on the same object, as they may be.
    pub fn spoil_strings(&self, spoils: bool) {
        self.spoils.store(spoils, Ordering::SeqCst);
    }

    pub(crate) fn spoils(&self) -> bool {
        self.spoils.load(Ordering::SeqCst)
    }

    pub(crate) fn accessed(&self, set: &PropertySet, property: &str, write: bool) -> bool {
        let access = Access {
            set: write,
            kind: set.kind.clone(),
            property: property.to_owned(),
        };
        let there = !self
            .profile
            .lacks
            .iter()
            .any(|name| name.to_bytes() == property.as_bytes())
            && locked(&self.hidden).as_ref() != Some(&access);
        locked(&self.log).insert(access);
        there
    }

    /// Makes a property set known to the plugin.
    pub(crate) fn property_set(
        &self,
        kind: &str,
        name: &str,
        values: Values,
        open: bool,
    ) -> Arc<PropertySet> {
        let set = Arc::new(PropertySet::new(kind, name, values, open));
        let handle = self
            .objects
            .keep(name, Object::Properties(Arc::clone(&set)));
        set.known_as(handle);
        set
    }

    /// Makes an object known to the plugin; the handle.
    pub(crate) fn keep(&self, name: &str, object: Object) -> usize {
        self.objects.keep(name, object)
    }

    /// A handle is valid no longer; whether it was.
    pub(crate) fn end(&self, handle: usize) -> bool {
        self.objects.end(handle)
    }

    /// What a handle stands for; that it stands for nothing, or something else, is noted.
    pub(crate) fn find<T: Kept>(&self, handle: usize, call: &str) -> Option<Arc<T>> {
        match self.objects.find(handle) {
            Ok(object) => T::of(&object).or_else(|| {
                self.misused(format!("{call} was given the handle of something else"));
                None
            }),
            Err(why) => {
                self.misused(format!("{call} was given {why}"));
                None
            }
        }
    }

    /// Messages so far, which are forgotten thereby.
    pub fn take_messages(&self) -> Vec<Message> {
        std::mem::take(&mut locked(&self.messages))
    }

    /// The message that stands now.
    pub fn persistent_message(&self) -> Option<Message> {
        locked(&self.persistent).clone()
    }

    /// Answers no to the next `polls` questions whether to stop, and yes from then on; nothing: never yes.
    pub fn lose_patience_after(&self, polls: Option<usize>) {
        let left = polls.map_or(-1, |n| i64::try_from(n).unwrap_or(i64::MAX));
        self.counts.polls.store(0, Ordering::SeqCst);
        self.counts.polls_told.store(0, Ordering::SeqCst);
        self.patience.store(left, Ordering::SeqCst);
    }

    /// How many processors the plugin is told of, and whether the thread suite fails.
    pub fn set_threads(&self, processors: usize, fail: bool) {
        self.processors.store(processors, Ordering::SeqCst);
        self.threads_fail.store(fail, Ordering::SeqCst);
    }

    /// Where the plugin is told that its bundle is.
    pub fn set_path(&self, path: &CStr) {
        path.clone_into(&mut locked(&self.path));
    }

    /// What has been handed out and not come back, in words.
    #[must_use]
    pub fn outstanding(&self) -> Vec<String> {
        let c = &self.counts;
        let rows = [
            ("images not released", &c.images_out),
            ("memory blocks not freed", &c.memory_out),
            ("mutexes not destroyed", &c.mutexes_out),
            ("edits of parameters not ended", &c.edits_open),
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
