//! Property sets.

mod defaults;
mod lent;
mod types;

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::sync::Mutex;

pub(crate) use defaults::{
    clip_descriptor, effect_descriptor, host_properties, interact, numeric_type,
    parameter_descriptor,
};
pub(crate) use lent::LentStrings;
pub(crate) use types::{PropertyType, type_of};

use super::{OwnHandle, locked};

/// A value of a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A C int.
    Int(i32),
    /// A double.
    Double(f64),
    /// A string.
    Text(CString),
    /// A pointer, as a number.
    Pointer(usize),
}

impl Value {
    /// Creates a string value from `text` up to its first NUL.
    #[must_use]
    pub fn text(text: &str) -> Self {
        Self::Text(c_string(text))
    }

    pub(crate) fn property_type(&self) -> PropertyType {
        match self {
            Self::Int(_) => PropertyType::Int,
            Self::Double(_) => PropertyType::Double,
            Self::Text(_) => PropertyType::Text,
            Self::Pointer(_) => PropertyType::Pointer,
        }
    }
}

/// Returns a C string of `text` up to its first NUL.
pub(crate) fn c_string(text: &str) -> CString {
    let before = text.split('\0').next().unwrap_or("");
    CString::new(before).unwrap_or_default()
}

/// Properties by name, each with its values.
pub type Values = BTreeMap<String, Vec<Value>>;

/// Returns the key of a property in [`Values`].
pub(crate) fn property_name(name: &CStr) -> String {
    name.to_string_lossy().into_owned()
}

/// The rule for properties that a set does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schema {
    /// Only properties that the set has from the start can be set.
    Fixed,
    /// Any property can be set.
    Open,
}

/// A property set with a handle.
#[derive(Debug)]
pub struct PropertySet {
    handle: OwnHandle,
    /// The kind of object it describes, such as `image`.
    pub kind: String,
    /// The object that it describes, for messages.
    pub name: String,
    values: Mutex<Values>,
    initial: Values,
    schema: Schema,
    lent: LentStrings,
}

impl PropertySet {
    /// Creates a set with these properties.
    pub(crate) fn new(kind: &str, name: &str, values: Values, schema: Schema) -> Self {
        Self {
            handle: OwnHandle::default(),
            kind: kind.to_owned(),
            name: name.to_owned(),
            initial: values.clone(),
            values: Mutex::new(values),
            schema,
            lent: LentStrings::default(),
        }
    }

    pub(crate) fn handle(&self) -> usize {
        self.handle.get()
    }

    pub(crate) fn set_handle(&self, handle: usize) {
        self.handle.set(handle);
    }

    /// Returns the values of a property, if the set has it.
    pub fn get(&self, name: &CStr) -> Option<Vec<Value>> {
        locked(&self.values)
            .get(name.to_string_lossy().as_ref())
            .cloned()
    }

    /// Returns all properties.
    pub fn all(&self) -> Values {
        locked(&self.values).clone()
    }

    /// Returns the first value, if it is an int.
    pub fn int(&self, name: &CStr) -> Option<i32> {
        match self.get(name)?.first()? {
            Value::Int(v) => Some(*v),
            _ => None,
        }
    }

    /// Returns all values that are doubles.
    pub fn doubles(&self, name: &CStr) -> Vec<f64> {
        (self.get(name).unwrap_or_default().iter())
            .filter_map(|value| match value {
                Value::Double(v) => Some(*v),
                _ => None,
            })
            .collect()
    }

    /// Returns all values that are strings.
    pub fn texts(&self, name: &CStr) -> Vec<String> {
        (self.get(name).unwrap_or_default().iter())
            .filter_map(|value| match value {
                Value::Text(v) => Some(v.to_string_lossy().into_owned()),
                _ => None,
            })
            .collect()
    }

    /// Returns the first value, if it is a pointer.
    pub fn pointer(&self, name: &CStr) -> Option<usize> {
        match self.get(name)?.first()? {
            Value::Pointer(v) => Some(*v),
            _ => None,
        }
    }

    /// Sets a property on behalf of the host.
    pub fn put(&self, name: &CStr, values: Vec<Value>) {
        locked(&self.values).insert(property_name(name), values);
    }

    /// Sets one value on behalf of the plugin. Returns false if the set cannot have the property.
    ///
    /// An index beyond the end fills the gap with the value.
    pub(crate) fn set(&self, name: &str, index: usize, value: Value) -> bool {
        let mut values = locked(&self.values);
        if self.schema == Schema::Fixed && !values.contains_key(name) {
            return false;
        }
        let list = values.entry(name.to_owned()).or_default();
        while list.len() < index {
            list.push(value.clone());
        }
        if list.len() == index {
            list.push(value);
        } else {
            list[index] = value;
        }
        true
    }

    /// Restores the initial values. Returns false if the set lacks the property.
    pub(crate) fn reset(&self, name: &str) -> bool {
        let mut values = locked(&self.values);
        match self.initial.get(name) {
            Some(initial) => {
                values.insert(name.to_owned(), initial.clone());
                true
            }
            None => self.schema == Schema::Open && values.remove(name).is_some(),
        }
    }

    /// Overwrites the strings lent by earlier calls.
    pub(crate) fn overwrite_lent_strings(&self) {
        self.lent.overwrite();
    }

    /// Lends a string until [`Self::overwrite_lent_strings`].
    pub(crate) fn lend(&self, text: &CStr) -> *mut c_char {
        self.lent.lend(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_sets_reject_new_properties() {
        let values = Values::from([("a".to_owned(), vec![Value::Int(1)])]);
        let fixed = PropertySet::new("test", "test", values.clone(), Schema::Fixed);
        assert!(fixed.set("a", 2, Value::Int(5)));
        assert!(!fixed.set("b", 0, Value::Int(5)));
        assert_eq!(fixed.get(c"a").map(|list| list.len()), Some(3));
        assert!(fixed.reset("a"));
        assert_eq!(fixed.int(c"a"), Some(1));
        let open = PropertySet::new("test", "test", values, Schema::Open);
        assert!(open.set("b", 0, Value::Int(5)));
    }
}
