//! How a lens draws a point of light.

use std::ptr::{null, null_mut};

use seidel_c::{
    SeidelKernel, SeidelPlate, SeidelRect, SeidelSettings, SeidelStatus, seidel_kernel,
};

use super::Lens;
use crate::ffi;
use crate::host::Result;

/// Columns and rows of points that are looked at over a frame.
const COLUMNS: i32 = 7;
const ROWS: i32 = 5;

/// Where they are: middles of pixels, from the top left corner of the frame's first pixel.
pub(crate) fn points(format: SeidelRect) -> impl Iterator<Item = (f64, f64)> {
    let at = |k: i32, count: i32, size: i32| {
        ((f64::from(k) + 0.5) / f64::from(count) * f64::from(size)).floor() + 0.5
    };
    (0..ROWS * COLUMNS).map(move |k| {
        (
            at(k % COLUMNS, COLUMNS, format.width),
            at(k / COLUMNS, ROWS, format.height),
        )
    })
}

/// Where the light of one source pixel lands.
pub(crate) struct Kernel {
    /// Row by row, their sum one.
    pub(crate) weights: Vec<f32>,
    /// From the source pixel.
    pub(crate) window: SeidelRect,
}

impl Lens {
    /// The channel called `name`; else the green one, else the first.
    pub(crate) fn channel(&self, name: &str) -> u32 {
        let names = &self.info.channels;
        let find = |name: &str| names.iter().position(|one| one == name);
        find(name).or_else(|| find("G")).unwrap_or(0) as u32
    }

    /// The kernel of a channel at a place of a frame, `distance` metres away.
    ///
    /// # Errors
    /// What the library says.
    pub(crate) fn kernel(
        &self,
        settings: &SeidelSettings,
        (format, channel): (SeidelRect, u32),
        (x, y): (f64, f64),
        distance: f64,
    ) -> Result<Kernel> {
        let plate = SeidelPlate {
            size: size_of::<SeidelPlate>() as u64,
            format,
            extent: format,
            source: null(),
            depth: null(),
            matte: null(),
            matte_depth: null(),
            alphas: null(),
        };
        let distance = if self.info.knows_depth {
            distance
        } else {
            f64::NAN
        };
        let mut kernel = SeidelKernel {
            size: size_of::<SeidelKernel>() as u64,
            weights: null_mut(),
            capacity: 0,
            left: 0,
            top: 0,
            width: 0,
            height: 0,
        };
        let lens = self.handle();
        let ask = |kernel: &mut SeidelKernel| {
            // SAFETY: everything is held until the call ends; the weights are as many as is said.
            unsafe { seidel_kernel(lens, settings, &plate, channel, x, y, distance, kernel) }
        };
        let mut status = ask(&mut kernel);
        let mut weights = Vec::new();
        if status == SeidelStatus::TooSmall {
            weights = vec![0.0_f32; kernel.width as usize * kernel.height as usize];
            kernel.weights = weights.as_mut_ptr();
            kernel.capacity = weights.len() as u64;
            status = ask(&mut kernel);
        }
        ffi::done(status)?;
        let window = SeidelRect {
            left: kernel.left,
            top: kernel.top,
            width: kernel.width as i32,
            height: kernel.height as i32,
        };
        Ok(Kernel { weights, window })
    }
}
