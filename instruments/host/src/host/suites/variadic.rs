//! Suite functions with variadic arguments.
//!
//! Rust can call variadic C functions but not define them, and the tests must build without a C compiler. The calling
//! convention fixes where the caller puts each argument, though. A function with a fixed number of arguments therefore
//! receives them if it looks in the right places:
//!
//! - x86-64 except Windows (System V ABI, 3.2.3) and AArch64 except Apple's (AAPCS64, 6.4): integers and pointers are in
//!   one set of registers, doubles in another, each in order, variadic or not.
//! - Windows on x86-64 (Microsoft, "x64 calling convention"): arguments go by position; variadic doubles are in integer
//!   registers too.
//! - Apple on AArch64 ("Writing ARM64 code for Apple platforms"): variadic arguments are on the stack, eight bytes each,
//!   after the eight integer registers.
//!
//! Only as many arguments are used as the parameter's type has components.

use std::ffi::{c_char, c_void};

use openfx::sys::generic::core::OfxStatus;
use openfx::sys::image_effect_v1::param::OfxParamHandle;

use super::message::{Duration, post};
use super::parameter;

/// Variadic arguments, each read both as an integer and as a double.
pub(super) struct Arguments {
    integers: [usize; 4],
    doubles: [f64; 4],
}

impl Arguments {
    pub(super) fn pointer<T>(&self, i: usize) -> *mut T {
        self.integers
            .get(i)
            .map_or(std::ptr::null_mut(), |v| *v as *mut T)
    }

    pub(super) fn int(&self, i: usize) -> i32 {
        // The upper half of the register is undefined.
        self.integers.get(i).map_or(0, |v| *v as i32)
    }

    pub(super) fn double(&self, i: usize) -> f64 {
        self.doubles.get(i).copied().unwrap_or(f64::NAN)
    }
}

type Variadic = unsafe extern "C" fn(OfxParamHandle, ...) -> OfxStatus;
type VariadicWithTime = unsafe extern "C" fn(OfxParamHandle, f64, ...) -> OfxStatus;
type VariadicWithTimes = unsafe extern "C" fn(OfxParamHandle, f64, f64, ...) -> OfxStatus;
type VariadicMessage = unsafe extern "C" fn(
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
mod values {
    //! Arguments by type of register.

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
                let arguments = Arguments { integers: [i1, i2, i3, i4], doubles: rest };
                // SAFETY: these are the plugin's arguments.
                unsafe { $work(handle, &doubles[..$times], &arguments) }
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
mod values {
    //! Arguments by position.

    use super::*;

    macro_rules! by_position {
        ($($name:ident($($time:ident)*) $work:path;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                handle: usize, $($time: f64,)* i1: usize, i2: usize, i3: usize, i4: usize,
            ) -> OfxStatus {
                let integers = [i1, i2, i3, i4];
                let doubles = integers.map(|v| f64::from_bits(v as u64));
                let arguments = Arguments { integers, doubles };
                // SAFETY: these are the plugin's arguments.
                unsafe { $work(handle, &[$($time),*], &arguments) }
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
mod values {
    //! Arguments on the stack.

    use super::*;

    macro_rules! on_the_stack {
        ($($name:ident $times:literal $work:path;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                handle: usize, _1: usize, _2: usize, _3: usize, _4: usize, _5: usize, _6: usize, _7: usize,
                d1: f64, d2: f64, s1: usize, s2: usize, s3: usize, s4: usize,
            ) -> OfxStatus {
                let integers = [s1, s2, s3, s4];
                let doubles = integers.map(|v| f64::from_bits(v as u64));
                let arguments = Arguments { integers, doubles };
                // SAFETY: these are the plugin's arguments.
                unsafe { $work(handle, &[d1, d2][..$times], &arguments) }
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
mod messages {
    //! All arguments are pointers; the text is the fifth.

    use super::*;

    pub(super) unsafe extern "C" fn message(
        _effect: *mut c_void,
        kind: *const c_char,
        _id: *const c_char,
        format: *const c_char,
        argument: usize,
    ) -> OfxStatus {
        // SAFETY: the plugin passes strings.
        unsafe { post(kind, format, argument, Duration::Transient) }
    }

    pub(super) unsafe extern "C" fn persistent(
        _effect: *mut c_void,
        kind: *const c_char,
        _id: *const c_char,
        format: *const c_char,
        argument: usize,
    ) -> OfxStatus {
        // SAFETY: the plugin passes strings.
        unsafe { post(kind, format, argument, Duration::Persistent) }
    }
}

#[cfg(all(target_arch = "aarch64", target_vendor = "apple"))]
mod messages {
    //! The text is on the stack, after four unused registers.

    use super::*;

    macro_rules! on_the_stack {
        ($($name:ident $duration:ident;)*) => {$(
            pub(super) unsafe extern "C" fn $name(
                _effect: *mut c_void, kind: *const c_char, _id: *const c_char, format: *const c_char,
                _4: usize, _5: usize, _6: usize, _7: usize, argument: usize,
            ) -> OfxStatus {
                // SAFETY: the plugin passes strings.
                unsafe { post(kind, format, argument, Duration::$duration) }
            }
        )*};
    }

    on_the_stack! {
        message Transient;
        persistent Persistent;
    }
}

macro_rules! suite_functions {
    ($($name:ident: $type:ty = $function:path;)*) => {$(
        /// Returns the suite function.
        pub(super) fn $name() -> Option<$type> {
            // The optimiser must not see which function is called: it would find the types different and assume that
            // the call never happens.
            let function = std::hint::black_box($function as *const ());
            // SAFETY: called as a variadic function, it finds its arguments as described above and uses no others.
            Some(unsafe { std::mem::transmute::<*const (), $type>(function) })
        }
    )*};
}

suite_functions! {
    get_value: Variadic = values::get_value;
    get_value_at_time: VariadicWithTime = values::get_value_at_time;
    get_derivative: VariadicWithTime = values::get_derivative;
    get_integral: VariadicWithTimes = values::get_integral;
    set_value: Variadic = values::set_value;
    set_value_at_time: VariadicWithTime = values::set_value_at_time;
    message: VariadicMessage = messages::message;
    persistent_message: VariadicMessage = messages::persistent;
}

#[cfg(test)]
mod tests {
    use std::ffi::{CStr, c_int};
    use std::sync::Arc;

    use openfx::sys::generic::core::*;
    use openfx::sys::image_effect_v1::message::kOfxMessageError;
    use openfx::sys::image_effect_v1::param::*;

    use super::*;
    use crate::host::action::{ActiveAction, within_action};
    use crate::host::effect::{Effect, EffectRole, ParameterValue};
    use crate::host::profile::Profile;
    use crate::host::properties::{Schema, Values};
    use crate::host::{ActiveHost, Host};

    fn effect(host: &ActiveHost) -> Arc<Effect> {
        let set = host.property_set("test", "test", Values::new(), Schema::Open);
        Effect::new(host, set, EffectRole::Instance)
    }

    fn parameter(host: &Host, effect: &Effect, kind: &CStr, name: &str) -> OfxParamHandle {
        let set = host.property_set("test", "test", Values::new(), Schema::Open);
        effect.parameters.add(host, kind, name, set).handle() as OfxParamHandle
    }

    fn within_edit<T>(work: impl FnOnce() -> T) -> T {
        within_action(Some(ActiveAction::new(kOfxActionInstanceChanged)), work)
    }

    #[test]
    fn ints_and_doubles_arrive() {
        let host = Host::activate(Profile::complete());
        let effect = effect(&host);
        let colour = parameter(&host, &effect, kOfxParamTypeRGBA, "colour");
        let three = parameter(&host, &effect, kOfxParamTypeInteger3D, "three");
        let set = set_value().expect("present");
        let set_at = set_value_at_time().expect("present");
        let get = get_value().expect("present");
        let get_at = get_value_at_time().expect("present");
        within_edit(|| {
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
        // SAFETY: memory for as many values as the parameters have.
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
        within_edit(|| {
            // SAFETY: a time, then arguments as above.
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
            Some(ParameterValue::Doubles(vec![1.0, 2.0, 3.0, 5.0]))
        );
        assert_eq!(value("three"), Some(ParameterValue::Ints(vec![1, 2, 3])));
        assert!(host.take_misuse().is_empty());
    }

    #[test]
    fn strings_arrive_and_times_are_skipped() {
        let host = Host::activate(Profile::complete());
        let effect = effect(&host);
        let text = parameter(&host, &effect, kOfxParamTypeString, "text");
        let pair = parameter(&host, &effect, kOfxParamTypeDouble2D, "pair");
        let set = set_value().expect("present");
        let get_at = get_value_at_time().expect("present");
        let integral = get_integral().expect("present");
        within_edit(|| {
            // SAFETY: a string, and two doubles.
            unsafe {
                assert_eq!(set(text, c"two words".as_ptr()), 0);
                assert_eq!(set(pair, 3.0_f64, -4.0_f64), 0);
            }
        });
        let mut lent: *mut c_char = std::ptr::null_mut();
        let (mut x, mut y) = (0.0_f64, 0.0_f64);
        // SAFETY: memory for a pointer, which stays valid until the next call, and for two doubles.
        unsafe {
            assert_eq!(get_at(text, 1.0_f64, &raw mut lent), 0);
            assert_eq!(CStr::from_ptr(lent), c"two words");
            assert_eq!(integral(pair, 1.0_f64, 3.5_f64, &raw mut x, &raw mut y), 0);
        }
        assert_eq!((x, y), (7.5, -10.0));
    }

    #[test]
    fn message_text_is_the_argument_after_the_format() {
        let host = Host::activate(Profile::complete());
        let effect = effect(&host);
        let message = message().expect("present");
        let persistent = persistent_message().expect("present");
        let instance = effect.handle() as *mut c_void;
        let (kind, id) = (kOfxMessageError.as_ptr(), c"id".as_ptr());
        let format = c"%s".as_ptr();
        // SAFETY: all arguments are strings, but for those of the last call, which are not read.
        unsafe {
            assert_eq!(
                message(instance, kind, id, format, c"100 % sure".as_ptr()),
                0
            );
            assert_eq!(persistent(instance, kind, id, format, c"stays".as_ptr()), 0);
            assert_eq!(message(instance, kind, id, c"50 %% sure".as_ptr()), 0);
            assert_eq!(
                message(instance, kind, id, c"%d %f".as_ptr(), 3 as c_int, 4.0_f64),
                0
            );
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
                ("stays".to_owned(), true),
                ("50 % sure".to_owned(), false),
                (String::new(), false)
            ]
        );
        assert_eq!(
            host.persistent_message().map(|m| m.text),
            Some("stays".to_owned())
        );
        assert_eq!(host.take_misuse().len(), 1);
    }

    #[test]
    fn stale_null_and_unknown_handles_are_distinguished() {
        let host = Host::activate(Profile::complete());
        let effect = effect(&host);
        let text = parameter(&host, &effect, kOfxParamTypeString, "text");
        effect.invalidate(&host);
        let get = get_value().expect("present");
        let mut lent: *mut c_char = std::ptr::null_mut();
        // SAFETY: memory for a pointer; handles are never dereferenced.
        unsafe {
            assert_eq!(get(text, &raw mut lent), kOfxStatErrBadHandle);
            assert_eq!(
                get(std::ptr::null_mut(), &raw mut lent),
                kOfxStatErrBadHandle
            );
            assert_eq!(
                get(8 as OfxParamHandle, &raw mut lent),
                kOfxStatErrBadHandle
            );
        }
        let misuse = host.take_misuse();
        assert!(
            misuse[0].contains("an invalidated handle of parameter text"),
            "{misuse:?}"
        );
        assert!(misuse[1].contains("a NULL handle"), "{misuse:?}");
        assert!(misuse[2].contains("an unknown handle"), "{misuse:?}");
    }
}
