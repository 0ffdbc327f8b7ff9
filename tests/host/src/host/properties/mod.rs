//! Property sets: what they hold, what of it is hidden, and how the strings lent from them are spoilt.

mod defaults;
mod known;

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::sync::{Mutex, OnceLock};

pub(crate) use defaults::{
    clip_descriptor, effect_descriptor, host as of_host, interact, numbers, parameter_descriptor,
};
pub(crate) use known::{Type, type_of};

use super::locked;

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
    /// A string value; what follows a zero is left out.
    #[must_use]
    pub fn text(text: &str) -> Self {
        Self::Text(c_string(text))
    }

    pub(crate) fn kind(&self) -> Type {
        match self {
            Self::Int(_) => Type::Int,
            Self::Double(_) => Type::Double,
            Self::Text(_) => Type::Text,
            Self::Pointer(_) => Type::Pointer,
        }
    }
}

/// A C string of what comes before the first zero.
pub(crate) fn c_string(text: &str) -> CString {
    let before = text.split('\0').next().unwrap_or("");
    CString::new(before).unwrap_or_default()
}

/// Properties by name, each with its values.
pub type Values = BTreeMap<String, Vec<Value>>;

/// A property set that the plugin holds a handle of.
#[derive(Debug)]
pub struct PropertySet {
    handle: OnceLock<usize>,
    /// What kind of thing it describes, such as `image`: accesses are told apart by it.
    pub kind: String,
    /// Which one, for messages.
    pub name: String,
    values: Mutex<Values>,
    initial: Values,
    /// Whether properties that are not in it yet may be set.
    open: bool,
    lent: Mutex<Lent>,
}

/// Strings handed to the plugin: those it may still read, and those that have been spoilt.
#[derive(Debug, Default)]
struct Lent {
    valid: Vec<CString>,
    spoilt: Vec<Vec<u8>>,
}

impl PropertySet {
    /// A set with these properties to begin with.
    pub(crate) fn new(kind: &str, name: &str, values: Values, open: bool) -> Self {
        Self {
            handle: OnceLock::new(),
            kind: kind.to_owned(),
            name: name.to_owned(),
            initial: values.clone(),
            values: Mutex::new(values),
            open,
            lent: Mutex::default(),
        }
    }

    /// The number that the plugin knows it by, 0 before it has one.
    pub(crate) fn handle(&self) -> usize {
        self.handle.get().copied().unwrap_or(0)
    }

    pub(crate) fn known_as(&self, handle: usize) {
        let _ = self.handle.set(handle);
    }

    /// Values of a property, nothing if it is not there.
    pub fn get(&self, name: &CStr) -> Option<Vec<Value>> {
        locked(&self.values)
            .get(name.to_string_lossy().as_ref())
            .cloned()
    }

    /// All properties.
    pub fn all(&self) -> Values {
        locked(&self.values).clone()
    }

    /// The first value, if it is an int.
    pub fn int(&self, name: &CStr) -> Option<i32> {
        match self.get(name)?.first()? {
            Value::Int(v) => Some(*v),
            _ => None,
        }
    }

    /// All values that are doubles.
    pub fn doubles(&self, name: &CStr) -> Vec<f64> {
        (self.get(name).unwrap_or_default().iter())
            .filter_map(|value| match value {
                Value::Double(v) => Some(*v),
                _ => None,
            })
            .collect()
    }

    /// All values that are strings.
    pub fn texts(&self, name: &CStr) -> Vec<String> {
        (self.get(name).unwrap_or_default().iter())
            .filter_map(|value| match value {
                Value::Text(v) => Some(v.to_string_lossy().into_owned()),
                _ => None,
            })
            .collect()
    }

    /// The first value, if it is a pointer.
    pub fn pointer(&self, name: &CStr) -> Option<usize> {
        match self.get(name)?.first()? {
            Value::Pointer(v) => Some(*v),
            _ => None,
        }
    }

    /// Sets a property, as the host.
    pub fn put(&self, name: &CStr, values: Vec<Value>) {
        locked(&self.values).insert(name.to_string_lossy().into_owned(), values);
    }

    /// Sets one value, as the plugin; whether the set takes it.
    pub(crate) fn set(&self, name: &str, index: usize, value: Value) -> bool {
        let mut values = locked(&self.values);
        if !self.open && !values.contains_key(name) {
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

    /// As it was to begin with; whether there is such a property.
    pub(crate) fn reset(&self, name: &str) -> bool {
        let mut values = locked(&self.values);
        match self.initial.get(name) {
            Some(first) => {
                values.insert(name.to_owned(), first.clone());
                true
            }
            None => self.open && values.remove(name).is_some(),
        }
    }

    /// A suite call on this set begins: the strings lent before are no longer valid.
    pub(crate) fn spoil(&self) {
        let mut lent = locked(&self.lent);
        let valid = std::mem::take(&mut lent.valid);
        for string in valid {
            let mut bytes = string.into_bytes_with_nul();
            // Still a string, so that who reads it sees something wrong rather than crashes.
            let end = bytes.len() - 1;
            bytes[..end].fill(b'#');
            lent.spoilt.push(bytes);
        }
    }

    /// Lends a string until the next suite call.
    pub(crate) fn lend(&self, text: &CStr) -> *mut c_char {
        let mut lent = locked(&self.lent);
        lent.valid.push(text.to_owned());
        // The bytes of a `CString` stay where they are when it moves.
        lent.valid
            .last()
            .map_or(std::ptr::null_mut(), |kept| kept.as_ptr().cast_mut())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_sets_take_only_what_they_have() {
        let values = Values::from([("a".to_owned(), vec![Value::Int(1)])]);
        let closed = PropertySet::new("test", "test", values.clone(), false);
        assert!(closed.set("a", 2, Value::Int(5)));
        assert!(!closed.set("b", 0, Value::Int(5)));
        assert_eq!(closed.get(c"a").map(|list| list.len()), Some(3));
        assert!(closed.reset("a"));
        assert_eq!(closed.int(c"a"), Some(1));
        assert!(PropertySet::new("test", "test", values, true).set("b", 0, Value::Int(5)));
    }

    #[test]
    fn lent_strings_are_overwritten_by_the_next_call() {
        let set = PropertySet::new("test", "test", Values::new(), true);
        let first = set.lend(c"first");
        set.spoil();
        let second = set.lend(c"second");
        // SAFETY: both are kept by the set until it goes.
        let (first, second) = unsafe { (CStr::from_ptr(first), CStr::from_ptr(second)) };
        assert_eq!(first, c"#####");
        assert_eq!(second, c"second");
    }
}
