//! Effects with their clips and parameters, as descriptors and as instances.

use std::ffi::{CStr, CString, c_char};
use std::sync::{Arc, Mutex, Weak};

use openfx::sys::image_effect_v1::param::*;

use super::images::ActiveRender;
use super::properties::{
    LentStrings, PropertySet, Schema, Value, Values, c_string, numeric_type, property_name,
};
use super::{Host, Object, OwnHandle, locked};
use crate::scene::Scene;

/// The role of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectRole {
    /// A descriptor, which the plugin fills in.
    Descriptor,
    /// An instance.
    Instance,
}

/// A descriptor or an instance of a plugin.
pub struct Effect {
    handle: OwnHandle,
    /// Its properties.
    pub properties: Arc<PropertySet>,
    /// Its parameters.
    pub parameters: Arc<ParameterSet>,
    clips: Mutex<Vec<Arc<Clip>>>,
    /// Its role.
    pub role: EffectRole,
    /// The scene that its clips are connected to.
    pub(crate) scene: Mutex<Scene>,
    /// Renders in progress.
    pub(crate) renders: Mutex<Vec<Arc<ActiveRender>>>,
}

impl Effect {
    /// Creates an effect without clips and parameters.
    pub(crate) fn new(host: &Host, properties: Arc<PropertySet>, role: EffectRole) -> Arc<Self> {
        let name = properties.name.clone();
        let parameters_name = format!("parameters of {name}");
        let values = Values::from([
            (
                property_name(kOfxPropParamSetNeedsSyncing),
                vec![Value::Int(0)],
            ),
            (property_name(kOfxPluginPropParamPageOrder), Vec::new()),
        ]);
        let parameters = Arc::new(ParameterSet {
            handle: OwnHandle::default(),
            properties: host.property_set("parameter set", &parameters_name, values, Schema::Fixed),
            all: Mutex::default(),
            role,
        });
        let object = Object::Parameters(Arc::clone(&parameters));
        parameters
            .handle
            .set(host.register(&parameters_name, object));
        let effect = Arc::new(Self {
            handle: OwnHandle::default(),
            properties,
            parameters,
            clips: Mutex::default(),
            role,
            scene: Mutex::default(),
            renders: Mutex::default(),
        });
        let object = Object::Effect(Arc::clone(&effect));
        effect.handle.set(host.register(&name, object));
        effect
    }

    pub(crate) fn handle(&self) -> usize {
        self.handle.get()
    }

    /// Returns all clips, in the order of their definition.
    pub fn clips(&self) -> Vec<Arc<Clip>> {
        locked(&self.clips).clone()
    }

    /// Returns the clip of that name.
    pub fn clip(&self, name: &str) -> Option<Arc<Clip>> {
        locked(&self.clips).iter().find(|c| c.name == name).cloned()
    }

    /// Adds a clip.
    pub(crate) fn add_clip(self: &Arc<Self>, host: &Host, name: &str, set: Arc<PropertySet>) {
        let clip = Arc::new(Clip {
            handle: OwnHandle::default(),
            name: name.to_owned(),
            properties: set,
            effect: Arc::downgrade(self),
        });
        let title = format!("clip {name} of {}", self.properties.name);
        let handle = host.register(&title, Object::Clip(Arc::clone(&clip)));
        clip.handle.set(handle);
        locked(&self.clips).push(clip);
    }

    /// Invalidates its handle and those of all that belongs to it.
    pub(crate) fn invalidate(&self, host: &Host) {
        for clip in self.clips() {
            host.invalidate(clip.properties.handle());
            host.invalidate(clip.handle());
        }
        for parameter in self.parameters.all() {
            host.invalidate(parameter.properties.handle());
            host.invalidate(parameter.handle());
        }
        host.invalidate(self.parameters.properties.handle());
        host.invalidate(self.parameters.handle());
        host.invalidate(self.properties.handle());
        host.invalidate(self.handle());
    }
}

/// A clip of an effect.
pub struct Clip {
    handle: OwnHandle,
    /// Its name.
    pub name: String,
    /// Its properties.
    pub properties: Arc<PropertySet>,
    pub(crate) effect: Weak<Effect>,
}

impl Clip {
    pub(crate) fn handle(&self) -> usize {
        self.handle.get()
    }
}

/// The parameters of an effect.
pub struct ParameterSet {
    handle: OwnHandle,
    pub(crate) properties: Arc<PropertySet>,
    all: Mutex<Vec<Arc<Parameter>>>,
    pub(crate) role: EffectRole,
}

impl ParameterSet {
    pub(crate) fn handle(&self) -> usize {
        self.handle.get()
    }

    /// Returns all parameters, in the order of their definition.
    pub fn all(&self) -> Vec<Arc<Parameter>> {
        locked(&self.all).clone()
    }

    /// Returns the parameter of that name.
    pub fn get(&self, name: &str) -> Option<Arc<Parameter>> {
        locked(&self.all).iter().find(|p| p.name == name).cloned()
    }

    /// Adds a parameter with its default value.
    pub(crate) fn add(
        &self,
        host: &Host,
        kind: &CStr,
        name: &str,
        properties: Arc<PropertySet>,
    ) -> Arc<Parameter> {
        let value = ParameterValue::default_of(kind, &properties);
        let parameter = Arc::new(Parameter {
            handle: OwnHandle::default(),
            name: name.to_owned(),
            kind: kind.to_owned(),
            properties,
            value: Mutex::new(value),
            lent: LentStrings::default(),
        });
        let object = Object::Parameter(Arc::clone(&parameter));
        let handle = host.register(&format!("parameter {name}"), object);
        parameter.handle.set(handle);
        locked(&self.all).push(Arc::clone(&parameter));
        parameter
    }
}

/// A parameter.
pub struct Parameter {
    handle: OwnHandle,
    /// Its name.
    pub name: String,
    /// Its OpenFX type.
    pub kind: CString,
    /// Its properties.
    pub properties: Arc<PropertySet>,
    value: Mutex<ParameterValue>,
    lent: LentStrings,
}

impl Parameter {
    pub(crate) fn handle(&self) -> usize {
        self.handle.get()
    }

    /// Returns its value.
    pub fn value(&self) -> ParameterValue {
        locked(&self.value).clone()
    }

    /// Sets its value. Returns false, without effect, if the value is of another type.
    pub fn set(&self, new: ParameterValue) -> bool {
        let mut value = locked(&self.value);
        let fits = value.has_type_of(&new);
        if fits {
            *value = new;
        }
        fits
    }

    /// Overwrites the strings lent by earlier calls.
    pub(crate) fn overwrite_lent_strings(&self) {
        self.lent.overwrite();
    }

    /// Lends a string until [`Self::overwrite_lent_strings`].
    pub(crate) fn lend(&self, text: &str) -> *mut c_char {
        self.lent.lend(&c_string(text))
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// None: the parameter is a group, a page or a button.
    None,
    /// Integers, a choice or a boolean.
    Ints(Vec<i32>),
    /// Doubles or a colour.
    Doubles(Vec<f64>),
    /// A string.
    Text(String),
}

impl ParameterValue {
    /// Returns whether both have the same type and number of components, and hold values at all.
    pub(crate) fn has_type_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Ints(a), Self::Ints(b)) => a.len() == b.len(),
            (Self::Doubles(a), Self::Doubles(b)) => a.len() == b.len(),
            (Self::Text(_), Self::Text(_)) => true,
            _ => false,
        }
    }

    /// Returns the default of a parameter of OpenFX type `kind`.
    fn default_of(kind: &CStr, properties: &PropertySet) -> Self {
        let defaults = properties.get(kOfxParamPropDefault).unwrap_or_default();
        if let Some(numeric) = numeric_type(kind) {
            let numbers = (0..numeric.components).map(|i| match defaults.get(i) {
                Some(Value::Int(v)) => f64::from(*v),
                Some(Value::Double(v)) => *v,
                _ => 0.0,
            });
            return if numeric.is_integer {
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
        if !strings.contains(&kind) {
            return Self::None;
        }
        Self::Text(match defaults.first() {
            Some(Value::Text(text)) => text.to_string_lossy().into_owned(),
            _ => String::new(),
        })
    }
}
