//! Suite members that take a variable number of arguments.
//!
//! Rust calls such functions but does not define them, and building the tests must need no C compiler. What the caller
//! does is fixed by the platform's calling convention, though, so a function of a fixed number of arguments that looks
//! where they are put receives them:
//!
//! - x86-64 but Windows (System V ABI, 3.2.3) and AArch64 but Apple's (AAPCS64, 6.4): integers and pointers go through
//!   one kind of registers, doubles through another, each in its own order, named or not.
//! - Windows on x86-64 (Microsoft, "x64 calling convention"): by position, doubles beyond the named arguments in
//!   integer registers too.
//! - Apple on AArch64 ("Writing ARM64 code for Apple platforms"): what is not named lies on the stack, eight bytes each,
//!   behind the eight integer registers.
//!
//! Only as many arguments are looked at as the parameter's type says there are.

use std::ffi::{c_char, c_void};

use openfx::sys::generic::core::OfxStatus;
use openfx::sys::image_effect_v1::param::OfxParamHandle;

use super::message::said;
use super::parameter;

/// Arguments beyond the named ones, as they arrived.
pub(super) struct Rest {
    integers: [usize; 4],
    doubles: [f64; 4],
}

impl Rest {
    pub(super) fn pointer<T>(&self, i: usize) -> *mut T {
        self.integers
            .get(i)
            .map_or(std::ptr::null_mut(), |at| *at as *mut T)
    }

    pub(super) fn int(&self, i: usize) -> i32 {
        // The upper half of the register is anybody's.
        self.integers.get(i).map_or(0, |v| *v as i32)
    }

    pub(super) fn double(&self, i: usize) -> f64 {
        self.doubles.get(i).copied().unwrap_or(f64::NAN)
    }
}

type OfHandle = unsafe extern "C" fn(OfxParamHandle, ...) -> OfxStatus;
type OfTime = unsafe extern "C" fn(OfxParamHandle, f64, ...) -> OfxStatus;
type OfTimes = unsafe extern "C" fn(OfxParamHandle, f64, f64, ...) -> OfxStatus;
type OfText = unsafe extern "C" fn(
    *mut c_void,
    *const c_char,
    *const c_char,
    *const c_char,
    ...
) -> OfxStatus;

#[cfg(all(
    not(windows),
    any(
        target_arch = "x86_64",
        all(target_arch = "aarch64", not(target_vendor = "apple"))
    )
))]
mod received {
    //! By kind of register.

    use super::*;

    macro_rules! by_register {
        ($($name:ident $times:literal $work:path;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                handle: usize, i1: usize, i2: usize, i3: usize, i4: usize,
                d1: f64, d2: f64, d3: f64, d4: f64, d5: f64, d6: f64,
            ) -> OfxStatus {
                let doubles = [d1, d2, d3, d4, d5, d6];
                let mut rest = [0.0; 4];
                rest.copy_from_slice(&doubles[$times..$times + 4]);
                let rest = Rest { integers: [i1, i2, i3, i4], doubles: rest };
                // SAFETY: the arguments are as the plugin gave them.
                unsafe { $work(handle, &doubles[..$times], &rest) }
            }
        )*};
    }

    by_register! {
        get_value 0 parameter::get;
        get_value_at_time 1 parameter::get;
        get_derivative 1 parameter::get_derivative;
        get_integral 2 parameter::get_integral;
        set_value 0 parameter::set;
        set_value_at_time 1 parameter::set;
    }
}

#[cfg(windows)]
mod received {
    //! By position.

    use super::*;

    macro_rules! by_position {
        ($($name:ident($($time:ident)*) $work:path;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                handle: usize, $($time: f64,)* i1: usize, i2: usize, i3: usize, i4: usize,
            ) -> OfxStatus {
                let integers = [i1, i2, i3, i4];
                let rest = Rest { integers, doubles: integers.map(|v| f64::from_bits(v as u64)) };
                // SAFETY: the arguments are as the plugin gave them.
                unsafe { $work(handle, &[$($time),*], &rest) }
            }
        )*};
    }

    by_position! {
        get_value() parameter::get;
        get_value_at_time(time) parameter::get;
        get_derivative(time) parameter::get_derivative;
        get_integral(from to) parameter::get_integral;
        set_value() parameter::set;
        set_value_at_time(time) parameter::set;
    }
}

#[cfg(all(target_arch = "aarch64", target_vendor = "apple"))]
mod received {
    //! Behind the registers.

    use super::*;

    macro_rules! on_the_stack {
        ($($name:ident $times:literal $work:path;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                handle: usize, _1: usize, _2: usize, _3: usize, _4: usize, _5: usize, _6: usize, _7: usize,
                d1: f64, d2: f64, s1: usize, s2: usize, s3: usize, s4: usize,
            ) -> OfxStatus {
                let integers = [s1, s2, s3, s4];
                let rest = Rest { integers, doubles: integers.map(|v| f64::from_bits(v as u64)) };
                // SAFETY: the arguments are as the plugin gave them.
                unsafe { $work(handle, &[d1, d2][..$times], &rest) }
            }
        )*};
    }

    on_the_stack! {
        get_value 0 parameter::get;
        get_value_at_time 1 parameter::get;
        get_derivative 1 parameter::get_derivative;
        get_integral 2 parameter::get_integral;
        set_value 0 parameter::set;
        set_value_at_time 1 parameter::set;
    }
}

#[cfg(not(all(target_arch = "aarch64", target_vendor = "apple")))]
mod texts {
    //! All are pointers; the one after the format is the fifth.

    use super::*;

    pub(super) unsafe extern "C" fn message(
        _effect: *mut c_void,
        kind: *const c_char,
        _id: *const c_char,
        format: *const c_char,
        argument: usize,
    ) -> OfxStatus {
        // SAFETY: the plugin gives strings.
        unsafe { said(kind, format, argument, false) }
    }

    pub(super) unsafe extern "C" fn persistent(
        _effect: *mut c_void,
        kind: *const c_char,
        _id: *const c_char,
        format: *const c_char,
        argument: usize,
    ) -> OfxStatus {
        // SAFETY: the plugin gives strings.
        unsafe { said(kind, format, argument, true) }
    }
}

#[cfg(all(target_arch = "aarch64", target_vendor = "apple"))]
mod texts {
    //! Four registers lie before what is looked at.

    use super::*;

    macro_rules! behind {
        ($($name:ident $persistent:literal;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                _effect: *mut c_void, kind: *const c_char, _id: *const c_char, format: *const c_char,
                _4: usize, _5: usize, _6: usize, _7: usize, argument: usize,
            ) -> OfxStatus {
                // SAFETY: the plugin gives strings.
                unsafe { said(kind, format, argument, $persistent) }
            }
        )*};
    }

    behind! {
        message false;
        persistent true;
    }
}

macro_rules! slots {
    ($($slot:ident: $type:ty = $function:path;)*) => {$(
        /// The suite member.
        pub(super) fn $slot() -> Option<$type> {
            // SAFETY: called as a variadic function it finds its arguments as said above, and looks at no others.
            Some(unsafe { std::mem::transmute::<*const (), $type>($function as *const ()) })
        }
    )*};
}

slots! {
    get_value: OfHandle = received::get_value;
    get_value_at_time: OfTime = received::get_value_at_time;
    get_derivative: OfTime = received::get_derivative;
    get_integral: OfTimes = received::get_integral;
    set_value: OfHandle = received::set_value;
    set_value_at_time: OfTime = received::set_value_at_time;
    message: OfText = texts::message;
    persistent_message: OfText = texts::persistent;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::effect::{Effect, Setting};
    use crate::host::profile::Profile;
    use crate::host::properties::PropertySet;
    use crate::host::under::{Under, doing};
    use crate::host::{Entered, Host};
    use openfx::sys::generic::core::*;
    use openfx::sys::image_effect_v1::message::kOfxMessageError;
    use openfx::sys::image_effect_v1::param::*;
    use std::ffi::{CStr, c_int};
    use std::sync::Arc;

    fn effect(host: &Entered) -> Arc<Effect> {
        let values = std::collections::BTreeMap::new();
        Effect::new(host, host.property_set("test", "test", values, true), true)
    }

    fn parameter(host: &Host, effect: &Effect, kind: &CStr, name: &str) -> OfxParamHandle {
        let values = std::collections::BTreeMap::new();
        let set: Arc<PropertySet> = host.property_set("test", "test", values, true);
        effect.parameters.add(host, kind, name, set).handle() as OfxParamHandle
    }

    fn in_an_edit<T>(work: impl FnOnce() -> T) -> T {
        let under = Under {
            action: kOfxActionInstanceChanged.to_string_lossy().into_owned(),
            rendering: None,
        };
        doing(Some(under), work)
    }

    #[test]
    fn ints_and_doubles_arrive_as_they_were_given() {
        let host = Host::enter(Profile::complete());
        let effect = effect(&host);
        let colour = parameter(&host, &effect, kOfxParamTypeRGBA, "colour");
        let three = parameter(&host, &effect, kOfxParamTypeInteger3D, "three");
        let (set, set_at) = (
            set_value().expect("there"),
            set_value_at_time().expect("there"),
        );
        let (get, get_at) = (
            get_value().expect("there"),
            get_value_at_time().expect("there"),
        );
        in_an_edit(|| {
            // SAFETY: as many arguments of the types that the parameters have.
            unsafe {
                assert_eq!(set(colour, 0.25_f64, -1.5_f64, 1e300_f64, 4.0_f64), 0);
                assert_eq!(set(three, 7 as c_int, -8 as c_int, c_int::MIN), 0);
            }
        });
        let mut four = [0.0_f64; 4];
        let [a, b, c, d] = &mut four;
        let mut ints = [0 as c_int; 3];
        let [i, j, k] = &mut ints;
        // SAFETY: room for as many values as the parameters have.
        unsafe {
            assert_eq!(
                get(colour, &raw mut *a, &raw mut *b, &raw mut *c, &raw mut *d),
                0
            );
            assert_eq!(
                get_at(three, 12.5_f64, &raw mut *i, &raw mut *j, &raw mut *k),
                0
            );
        }
        assert_eq!(four, [0.25, -1.5, 1e300, 4.0]);
        assert_eq!(ints, [7, -8, c_int::MIN]);
        in_an_edit(|| {
            // SAFETY: a time, then as above.
            unsafe {
                assert_eq!(
                    set_at(colour, 99.0_f64, 1.0_f64, 2.0_f64, 3.0_f64, 5.0_f64),
                    0
                );
                assert_eq!(
                    set_at(three, 99.0_f64, 1 as c_int, 2 as c_int, 3 as c_int),
                    0
                );
            }
        });
        let value = |name| effect.parameters.get(name).map(|p| p.value());
        assert_eq!(
            value("colour"),
            Some(Setting::Doubles(vec![1.0, 2.0, 3.0, 5.0]))
        );
        assert_eq!(value("three"), Some(Setting::Ints(vec![1, 2, 3])));
        assert!(host.take_misuse().is_empty());
    }

    #[test]
    fn times_go_before_and_strings_through() {
        let host = Host::enter(Profile::complete());
        let effect = effect(&host);
        let text = parameter(&host, &effect, kOfxParamTypeString, "text");
        let slope = parameter(&host, &effect, kOfxParamTypeDouble2D, "slope");
        let (set, get_at) = (
            set_value().expect("there"),
            get_value_at_time().expect("there"),
        );
        let integral = get_integral().expect("there");
        in_an_edit(|| {
            // SAFETY: a string, and two doubles.
            unsafe {
                assert_eq!(set(text, c"two words".as_ptr()), 0);
                assert_eq!(set(slope, 3.0_f64, -4.0_f64), 0);
            }
        });
        let mut at: *mut c_char = std::ptr::null_mut();
        let (mut x, mut y) = (0.0_f64, 0.0_f64);
        // SAFETY: room for a pointer, which stays valid until the next call; room for two doubles.
        unsafe {
            assert_eq!(get_at(text, 1.0_f64, &raw mut at), 0);
            assert_eq!(CStr::from_ptr(at), c"two words");
            assert_eq!(integral(slope, 1.0_f64, 3.5_f64, &raw mut x, &raw mut y), 0);
        }
        assert_eq!((x, y), (7.5, -10.0));
    }

    #[test]
    fn the_argument_of_a_message_is_the_one_after_its_format() {
        let host = Host::enter(Profile::complete());
        let effect = effect(&host);
        let (say, stay) = (
            message().expect("there"),
            persistent_message().expect("there"),
        );
        let at = effect.handle() as *mut c_void;
        let (kind, id) = (kOfxMessageError.as_ptr(), c"id".as_ptr());
        // SAFETY: strings all.
        unsafe {
            assert_eq!(say(at, kind, id, c"%s".as_ptr(), c"100 % sure".as_ptr()), 0);
            assert_eq!(stay(at, kind, id, c"%s".as_ptr(), c"for good".as_ptr()), 0);
            // Its arguments are not looked at.
            assert_eq!(say(at, kind, id, c"%d %f".as_ptr(), 3 as c_int, 4.0_f64), 0);
        }
        let texts: Vec<_> = host
            .take_messages()
            .into_iter()
            .map(|m| (m.text, m.persistent))
            .collect();
        assert_eq!(
            texts,
            [
                ("100 % sure".to_owned(), false),
                ("for good".to_owned(), true),
                (String::new(), false)
            ]
        );
        assert_eq!(
            host.persistent_message().map(|m| m.text),
            Some("for good".to_owned())
        );
        assert_eq!(host.take_misuse().len(), 1);
    }

    #[test]
    fn stale_handles_are_told_from_wrong_ones() {
        let host = Host::enter(Profile::complete());
        let effect = effect(&host);
        let text = parameter(&host, &effect, kOfxParamTypeString, "text");
        effect.end(&host);
        let get = get_value().expect("there");
        let mut at: *mut c_char = std::ptr::null_mut();
        // SAFETY: room for a pointer; handles are never followed.
        unsafe {
            assert_eq!(get(text, &raw mut at), kOfxStatErrBadHandle);
            assert_eq!(get(std::ptr::null_mut(), &raw mut at), kOfxStatErrBadHandle);
            assert_eq!(get(8 as OfxParamHandle, &raw mut at), kOfxStatErrBadHandle);
        }
        let misuse = host.take_misuse();
        assert!(
            misuse[0].contains("parameter text that is no longer valid"),
            "{misuse:?}"
        );
        assert!(misuse[1].contains("a NULL handle"), "{misuse:?}");
        assert!(misuse[2].contains("no handle of this host"), "{misuse:?}");
    }
}
