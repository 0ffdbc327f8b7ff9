//! The optical PSF of a point as a spectrum, to which sensors are applied.
//!
//! Diffraction gives the spectrum directly. Rays are rasterised on cells finer than pixels, whose spectrum
//! approximates that of the PSF. Streak, box and copies of a sensor are factors of the spectrum; the halo is a
//! convolution of pixels. A PSF drawn once can be combined with any number of sensors.

use std::f64::consts::TAU;
use std::fmt;

use super::extent::{Extent, half_width};
use super::fourier::{C, Fourier, Grid};
use super::halo::Moffat;
use super::mesh::Mesh;
use super::rasterise::Deposit;
use super::spectrum::{Spectrum, View, signed, sinc};
use super::{CellGrid, Detail, TileGrid, Workspace, rasterise, wave};
use crate::lens::LocalPupil;
use crate::sensor::{Halo, Sensor};
use seidel_fourier::fast_length;

/// Cells along the side of a pixel for rays; odd, so that one lies at the centre of the pixel.
const CELLS: usize = 3;
/// [`CELLS`] for a small PSF.
const SMALL_CELLS: usize = 5;
/// Radius of the rays below which a PSF is small, px.
const SMALL_PX: f64 = 3.0;
/// Half width of the symmetric blur, standard deviations: 1e-8 of the light lies outside.
const BLUR_REACH: f64 = 5.7;

/// The PSF of a lens at one point before the sensor, to which any [`Sensor`] can be applied.
pub struct OpticalPsf {
    spectrum: Spectrum,
    size: [usize; 2],
    pixels: Grid,
    /// Transforms with padding for the convolution with a halo, if one is expected.
    padded: Option<Grid>,
}

impl fmt::Debug for OpticalPsf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OpticalPsf")
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
}

impl OpticalPsf {
    /// Draws the PSF of `pupil` without its sensor on the pixels of `grid`.
    ///
    /// `largest` must blur at least as widely as any sensor that will be applied: it determines the margin around
    /// the tile. With a halo the margin holds all rays that land no farther from the tile than its size.
    pub fn draw(
        pupil: &LocalPupil,
        grid: &TileGrid,
        largest: &Sensor,
        detail: Detail,
        space: &mut Workspace,
    ) -> Self {
        let extent = Extent::of(pupil);
        Self::within(&extent, pupil, grid, largest, detail, space)
    }

    /// Draws like [`OpticalPsf::draw`], with the extent of the rays already known.
    pub(super) fn within(
        extent: &Extent,
        pupil: &LocalPupil,
        grid: &TileGrid,
        largest: &Sensor,
        detail: Detail,
        space: &mut Workspace,
    ) -> Self {
        let blur = (pupil.blur_variances_px2()).map(|v| BLUR_REACH * v.max(0.0).sqrt());
        let reach = largest.blur_radius_px();
        let size = [grid.width, grid.height];
        let view = View {
            corner: grid.corner_px,
            size,
            room: [0, 1].map(|axis| reach[axis] + blur[axis]),
        };
        let spectrum = if let Some(half_width) = half_width(pupil, extent) {
            wave::spectrum(pupil, half_width, extent, &view, &mut space.fourier)
        } else {
            let scatters = largest.halo.share != 0.0;
            ray_spectrum(pupil, extent, &view, scatters, detail, space)
        };
        let mut picture = Self {
            pixels: space.fourier.grid(spectrum.pixels),
            padded: None,
            spectrum,
            size,
        };
        if largest.halo.share != 0.0 {
            picture.padded = Some(picture.plan_padded(&mut space.fourier));
        }
        picture
    }

    fn plan_padded(&self, fourier: &mut Fourier) -> Grid {
        let pixels = self.spectrum.pixels;
        fourier.grid([0, 1].map(|axis| fast_length(pixels[axis] + self.size[axis])))
    }

    /// Returns the share of the light in each pixel of the tile behind `sensor`, row-major. The tone is not applied.
    pub fn through(&self, sensor: &Sensor) -> Vec<f64> {
        let mut folded = self.spectrum.folded(sensor, &self.pixels);
        let picture = self.pixels.inverse(&mut folded);
        let mut tile = self.tile(&picture);
        if sensor.halo.share != 0.0 {
            let share = sensor.halo.share;
            let scattered = self.scattered(&picture, &sensor.halo);
            for (value, scattered) in tile.iter_mut().zip(scattered) {
                *value = (1.0 - share) * *value + share * scattered;
            }
        }
        tile
    }

    /// Returns the index of row or column `k` of the window in the inverse transform.
    fn place(&self, k: i64, axis: usize) -> usize {
        let from_origin = k + self.spectrum.first[axis] - self.spectrum.origin[axis];
        from_origin.rem_euclid(self.spectrum.pixels[axis] as i64) as usize
    }

    /// Returns the tile cut out of `picture`; zero outside the window.
    fn tile(&self, picture: &[f64]) -> Vec<f64> {
        let [width, height] = self.size;
        let mut tile = vec![0.0; width * height];
        let inside = |t: usize, axis: usize| {
            let k = t as i64 - self.spectrum.first[axis];
            (0..self.spectrum.pixels[axis] as i64)
                .contains(&k)
                .then(|| self.place(k, axis))
        };
        for (y, row) in tile.chunks_exact_mut(width.max(1)).enumerate() {
            let Some(from) = inside(y, 1) else { continue };
            let from = &picture[from * self.pixels.columns..(from + 1) * self.pixels.columns];
            for (x, value) in row.iter_mut().enumerate() {
                if let Some(column) = inside(x, 0) {
                    *value = from[column];
                }
            }
        }
        tile
    }

    /// Returns the tile cut out of the convolution of `picture` with `halo`.
    fn scattered(&self, picture: &[f64], halo: &Halo) -> Vec<f64> {
        let window = self.spectrum.pixels;
        let unplanned;
        let grid = if let Some(grid) = &self.padded {
            grid
        } else {
            unplanned = self.plan_padded(&mut Fourier::default());
            &unplanned
        };
        let mut light = vec![0.0; grid.columns * grid.rows];
        for y in 0..window[1] {
            let from = self.place(y as i64, 1) * self.pixels.columns;
            for x in 0..window[0] {
                light[y * grid.columns + x] = picture[from + self.place(x as i64, 0)];
            }
        }
        // Offsets from the last pixel of the window to the first of the tile, and the reverse.
        let ends = [0, 1].map(|axis| {
            let first = self.spectrum.first[axis];
            let last = first + window[axis] as i64 - 1;
            (-last, self.size[axis] as i64 - 1 - first)
        });
        let mut kernel = vec![0.0; grid.columns * grid.rows];
        let most = ends.map(|(low, high)| low.abs().max(high.abs()) as usize + 1);
        let table = Moffat::new(halo).table(most);
        for dy in ends[1].0..=ends[1].1 {
            let row = dy.rem_euclid(grid.rows as i64) as usize * grid.columns;
            let from = dy.unsigned_abs() as usize * most[0];
            for dx in ends[0].0..=ends[0].1 {
                let column = dx.rem_euclid(grid.columns as i64) as usize;
                kernel[row + column] = table[from + dx.unsigned_abs() as usize];
            }
        }
        let mut lines = Vec::new();
        let mut product = grid.forward(&mut light, usize::MAX, &mut lines);
        let kernel = grid.forward(&mut kernel, usize::MAX, &mut lines);
        let share = 1.0 / (grid.columns * grid.rows) as f64;
        for (a, b) in product.iter_mut().zip(&kernel) {
            *a *= b * share;
        }
        let all = grid.inverse(&mut product);
        let place = |t: usize, axis: usize, count: usize| {
            (t as i64 - self.spectrum.first[axis]).rem_euclid(count as i64) as usize
        };
        let [width, height] = self.size;
        let mut tile = Vec::with_capacity(width * height);
        for y in 0..height {
            let row = place(y, 1, grid.rows) * grid.columns;
            tile.extend((0..width).map(|x| all[row + place(x, 0, grid.columns)]));
        }
        tile
    }
}

/// Returns the spectrum of the PSF of rays.
fn ray_spectrum(
    pupil: &LocalPupil,
    extent: &Extent,
    view: &View,
    scatters: bool,
    detail: Detail,
    space: &mut Workspace,
) -> Spectrum {
    let cells = if extent.radius() < SMALL_PX {
        SMALL_CELLS
    } else {
        CELLS
    };
    let (mut first, mut pixels) = ([0; 2], [0; 2]);
    for axis in 0..2 {
        let size = view.size[axis] as f64;
        let (mut low, mut high) = (-view.room[axis], size + view.room[axis]);
        if scatters {
            let from_corner = |x: f64| (x - view.corner[axis]).clamp(-size, 2.0 * size);
            low = low.min(from_corner(extent.low[axis]) - 1.0);
            high = high.max(from_corner(extent.high[axis]) + 1.0);
        }
        first[axis] = low.floor() as i64;
        pixels[axis] = fast_length((high.ceil() as i64 - first[axis]) as usize);
    }
    let grid = space.fourier.grid(pixels.map(|n| n * cells));
    let origin = [0, 1].map(|axis| view.corner[axis] + first[axis] as f64);
    let mesh = Mesh::new(pupil, &[], 0, extent.rings(detail));
    let variances = (pupil.blur_variances_px2()).map(|v| v.max(0.0) * (cells * cells) as f64);
    let least = variances[0].min(variances[1]);
    let deposit = Deposit::choose(detail, cells as f64 * extent.radius(), least);
    let cell_grid = CellGrid {
        origin,
        columns: grid.columns,
        rows: grid.rows,
        per_pixel: cells,
        deposit,
    };
    rasterise(&mesh, pupil.transmission.clone(), &cell_grid, space);
    let mut lines = space.fourier.buffer(0);
    let mut values = grid.forward(&mut space.canvas.light, usize::MAX, &mut lines);
    space.fourier.keep(lines);
    // The transfer function of summing cells into pixels and of the discrete Gaussian.
    let passes = |axis: usize, k: i64| {
        let f = k as f64 / pixels[axis] as f64;
        let gathered = sinc(f) / sinc(f / cells as f64);
        let t = variances[axis] - deposit.excess_variance();
        let blurred = (t * ((TAU * f / cells as f64).cos() - 1.0)).exp();
        let middle = TAU * f * ((cells - 1) / 2) as f64 / cells as f64;
        C::from_polar(gathered * blurred, middle)
    };
    let down: Vec<C> = (0..grid.rows)
        .map(|k| passes(1, signed(k, grid.rows)))
        .collect();
    for (k, line) in values.chunks_exact_mut(grid.rows).enumerate() {
        let across = passes(0, k as i64);
        for (value, down) in line.iter_mut().zip(&down) {
            *value *= across * down;
        }
    }
    Spectrum {
        values,
        columns: grid.columns,
        rows: grid.rows,
        pixels,
        first,
        origin: first,
    }
}
