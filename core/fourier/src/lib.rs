//! Plans of fast Fourier transforms.
//!
//! The algorithms of `rustfft` are generic, so each package that plans a transform compiles them all. They take longer to
//! compile than the rest of such a package. [`Planner`] has them compiled here, once for each type of sample.

#![forbid(unsafe_code)]

use std::fmt;
use std::sync::Arc;

pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;

/// Planner of one-dimensional transforms of samples of type `T`, `f32` or `f64`. Plans of one length share their tables.
pub struct Planner<T: rustfft::FftNum> {
    complex: rustfft::FftPlanner<T>,
    real: realfft::RealFftPlanner<T>,
}

impl<T: rustfft::FftNum> fmt::Debug for Planner<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Planner").finish_non_exhaustive()
    }
}

macro_rules! implement_planner {
    ($sample:ty) => {
        impl Planner<$sample> {
            /// Creates a planner without plans.
            // Never inlined: the caller would compile the algorithms.
            #[inline(never)]
            #[must_use]
            #[expect(
                clippy::new_without_default,
                reason = "a default would be generic and compile in each package"
            )]
            pub fn new() -> Self {
                Self {
                    complex: rustfft::FftPlanner::new(),
                    real: realfft::RealFftPlanner::new(),
                }
            }

            /// Returns the unnormalised forward transform of `length` complex samples.
            #[inline(never)]
            pub fn forward(&mut self, length: usize) -> Arc<dyn Fft<$sample>> {
                self.complex.plan_fft_forward(length)
            }

            /// Returns the unnormalised inverse transform of `length` complex samples.
            #[inline(never)]
            pub fn inverse(&mut self, length: usize) -> Arc<dyn Fft<$sample>> {
                self.complex.plan_fft_inverse(length)
            }

            /// Returns the unnormalised forward transform of `length` real samples, to frequencies 0..=length / 2.
            #[inline(never)]
            pub fn real_forward(&mut self, length: usize) -> Arc<dyn RealToComplex<$sample>> {
                self.real.plan_fft_forward(length)
            }

            /// Returns the unnormalised inverse transform to `length` real samples, from frequencies 0..=length / 2.
            #[inline(never)]
            pub fn real_inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<$sample>> {
                self.real.plan_fft_inverse(length)
            }
        }
    };
}

implement_planner!(f32);
implement_planner!(f64);

/// Returns the smallest even number of at least `least` with no prime factors but 2, 3 and 5, for which transforms are
/// fast.
#[must_use]
pub fn fast_length(least: usize) -> usize {
    let smooth = |mut n: usize| {
        for p in [2, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    let mut n = least.max(2).next_multiple_of(2);
    while !smooth(n) {
        n += 2;
    }
    n
}
