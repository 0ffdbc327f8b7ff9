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
        self.integers.get(i).map_or(std::ptr::null_mut(), |at| *at as *mut T)
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
type OfText = unsafe extern "C" fn(*mut c_void, *const c_char, *const c_char, *const c_char, ...) -> OfxStatus;

#[cfg(all(
    not(windows),
    any(target_arch = "x86_64", all(target_arch = "aarch64", not(target_vendor = "apple")))
))]
mod received {
    //! By kind of register.

    use super::*;

    macro_rules! by_register {
        ($($name:ident $times:literal $work:path;)*) => {$(
            #[expect(clippy::too_many_arguments, reason = "every register that arguments come in")]
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
            #[allow(clippy::too_many_arguments, reason = "every place that arguments come in")]
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
            #[expect(clippy::too_many_arguments, reason = "seven registers lie before what is looked at")]
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
            #[expect(clippy::too_many_arguments, reason = "four registers lie before what is looked at")]
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
