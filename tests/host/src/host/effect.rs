//! Effects, their clips and their parameters: descriptors and instances alike.

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::sync::{Arc, Mutex, OnceLock, Weak};

use openfx::sys::image_effect_v1::param::*;

use super::images::Rendering;
use super::properties::{PropertySet, Value};
use super::{Host, Object, locked};
use crate::scene::Scene;

/// A descriptor or an instance of a plugin.
pub struct Effect {
    handle: OnceLock<usize>,
    /// Its properties.
    pub properties: Arc<PropertySet>,
    /// Its parameters.
    pub parameters: Arc<ParameterSet>,
    clips: Mutex<Vec<Arc<Clip>>>,
    /// Whether it is an instance rather than a descriptor.
    pub instance: bool,
    /// What its clips are connected to.
    pub(crate) scene: Mutex<Scene>,
    /// Renders under way.
    pub(crate) renderings: Mutex<Vec<Arc<Rendering>>>,
}

impl Effect {
    /// An effect that has no clips and parameters yet.
    pub(crate) fn new(host: &Host, properties: Arc<PropertySet>, instance: bool) -> Arc<Self> {
        let name = properties.name.clone();
        let set = Arc::new(ParameterSet {
            handle: OnceLock::new(),
            properties: host.property_set(
                "parameter set",
                &format!("parameters of {name}"),
                BTreeMap::from([
                    (text(kOfxPropParamSetNeedsSyncing), vec![Value::Int(0)]),
                    (text(kOfxPluginPropParamPageOrder), Vec::new()),
                ]),
                false,
            ),
            all: Mutex::default(),
            instance,
        });
        let handle = host.keep(
            &format!("parameters of {name}"),
            Object::Parameters(Arc::clone(&set)),
        );
        let _ = set.handle.set(handle);
        let effect = Arc::new(Self {
            handle: OnceLock::new(),
            properties,
            parameters: set,
            clips: Mutex::default(),
            instance,
            scene: Mutex::default(),
            renderings: Mutex::default(),
        });
        let handle = host.keep(&name, Object::Effect(Arc::clone(&effect)));
        let _ = effect.handle.set(handle);
        effect
    }

    /// The number that the plugin knows it by.
    pub(crate) fn handle(&self) -> usize {
        self.handle.get().copied().unwrap_or(0)
    }

    /// All clips, in the order they were defined.
    pub fn clips(&self) -> Vec<Arc<Clip>> {
        locked(&self.clips).clone()
    }

    /// The clip of that name.
    pub fn clip(&self, name: &str) -> Option<Arc<Clip>> {
        locked(&self.clips).iter().find(|c| c.name == name).cloned()
    }

    pub(crate) fn add_clip(
        self: &Arc<Self>,
        host: &Host,
        name: &str,
        properties: Arc<PropertySet>,
    ) -> Arc<Clip> {
        let clip = Arc::new(Clip {
            handle: OnceLock::new(),
            name: name.to_owned(),
            properties,
            effect: Arc::downgrade(self),
        });
        let handle = host.keep(
            &format!("clip {name} of {}", self.properties.name),
            Object::Clip(Arc::clone(&clip)),
        );
        let _ = clip.handle.set(handle);
        locked(&self.clips).push(Arc::clone(&clip));
        clip
    }

    /// All its handles are valid no longer.
    pub(crate) fn end(&self, host: &Host) {
        for clip in self.clips() {
            host.end(clip.properties.handle());
            host.end(clip.handle());
        }
        for parameter in self.parameters.all() {
            host.end(parameter.properties.handle());
            host.end(parameter.handle());
        }
        host.end(self.parameters.properties.handle());
        host.end(self.parameters.handle());
        host.end(self.properties.handle());
        host.end(self.handle());
    }
}

/// A clip of an effect.
pub struct Clip {
    handle: OnceLock<usize>,
    /// Its name.
    pub name: String,
    /// Its properties.
    pub properties: Arc<PropertySet>,
    pub(crate) effect: Weak<Effect>,
}

impl Clip {
    pub(crate) fn handle(&self) -> usize {
        self.handle.get().copied().unwrap_or(0)
    }
}

/// The parameters of an effect.
pub struct ParameterSet {
    handle: OnceLock<usize>,
    pub(crate) properties: Arc<PropertySet>,
    all: Mutex<Vec<Arc<Parameter>>>,
    pub(crate) instance: bool,
}

impl ParameterSet {
    pub(crate) fn handle(&self) -> usize {
        self.handle.get().copied().unwrap_or(0)
    }

    /// All of them, in the order they were defined.
    pub fn all(&self) -> Vec<Arc<Parameter>> {
        locked(&self.all).clone()
    }

    /// The one of that name.
    pub fn get(&self, name: &str) -> Option<Arc<Parameter>> {
        locked(&self.all).iter().find(|p| p.name == name).cloned()
    }

    pub(crate) fn add(
        &self,
        host: &Host,
        kind: &CStr,
        name: &str,
        properties: Arc<PropertySet>,
    ) -> Arc<Parameter> {
        let value = Setting::first(kind, &properties);
        let parameter = Arc::new(Parameter {
            handle: OnceLock::new(),
            name: name.to_owned(),
            kind: kind.to_owned(),
            properties,
            value: Mutex::new(value),
            lent: Mutex::default(),
        });
        let handle = host.keep(
            &format!("parameter {name}"),
            Object::Parameter(Arc::clone(&parameter)),
        );
        let _ = parameter.handle.set(handle);
        locked(&self.all).push(Arc::clone(&parameter));
        parameter
    }
}

/// A parameter.
pub struct Parameter {
    handle: OnceLock<usize>,
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: CString,
    /// Its properties.
    pub properties: Arc<PropertySet>,
    value: Mutex<Setting>,
    lent: Mutex<(Vec<CString>, Vec<Vec<u8>>)>,
}

impl Parameter {
    pub(crate) fn handle(&self) -> usize {
        self.handle.get().copied().unwrap_or(0)
    }

    /// Its value.
    pub fn value(&self) -> Setting {
        locked(&self.value).clone()
    }

    /// Sets its value; whether it is of its type.
    pub fn set(&self, setting: Setting) -> bool {
        let mut value = locked(&self.value);
        let fits = match (&*value, &setting) {
            (Setting::Ints(a), Setting::Ints(b)) => a.len() == b.len(),
            (Setting::Doubles(a), Setting::Doubles(b)) => a.len() == b.len(),
            (Setting::Text(_), Setting::Text(_)) => true,
            _ => false,
        };
        if fits {
            *value = setting;
        }
        fits
    }

    /// A suite call on this parameter begins: strings lent before are no longer valid.
    pub(crate) fn spoil(&self) {
        let mut lent = locked(&self.lent);
        for string in std::mem::take(&mut lent.0) {
            let mut bytes = string.into_bytes_with_nul();
            let end = bytes.len() - 1;
            bytes[..end].fill(b'#');
            lent.1.push(bytes);
        }
    }

    /// Lends a string until the next suite call.
    pub(crate) fn lend(&self, text: &str) -> *mut c_char {
        let mut lent = locked(&self.lent);
        lent.0.push(super::properties::c_string(text));
        (lent.0.last()).map_or(std::ptr::null_mut(), |kept| kept.as_ptr().cast_mut())
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// It has none: a group, a page, a button.
    None,
    /// Ints, choices, booleans.
    Ints(Vec<i32>),
    /// Doubles and colours.
    Doubles(Vec<f64>),
    /// Strings.
    Text(String),
}

impl Setting {
    /// The default of a parameter.
    fn first(kind: &CStr, properties: &PropertySet) -> Self {
        let defaults = properties.get(kOfxParamPropDefault).unwrap_or_default();
        if let Some((count, whole)) = super::properties::numbers(kind) {
            let numbers = (0..count).map(|i| match defaults.get(i) {
                Some(Value::Int(v)) => f64::from(*v),
                Some(Value::Double(v)) => *v,
                _ => 0.0,
            });
            return if whole {
                Self::Ints(numbers.map(|v| v as i32).collect())
            } else {
                Self::Doubles(numbers.collect())
            };
        }
        let strings = [
            kOfxParamTypeString,
            kOfxParamTypeCustom,
            kOfxParamTypeStrChoice,
        ];
        if strings.contains(&kind) {
            Self::Text(match defaults.first() {
                Some(Value::Text(text)) => text.to_string_lossy().into_owned(),
                _ => String::new(),
            })
        } else {
            Self::None
        }
    }
}

fn text(name: &CStr) -> String {
    name.to_string_lossy().into_owned()
}
