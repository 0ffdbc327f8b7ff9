//! The picture of one point before the sensor, kept as a spectrum, and what sensors make of it.
//!
//! Waves give their spectrum as it is. Light of rays is spread over cells finer than pixels, and the
//! cells' spectrum stands for the picture's. Streak, box and copies are factors of it; the halo is a
//! convolution of pixels. Drawn once, a picture can be seen through any number of sensors.

use std::f64::consts::{PI, TAU};
use std::fmt;

use super::extent::Extent;
use super::fourier::{C, Fourier, Grid, quick_length};
use super::halo::Moffat;
use super::{Detail, TileGrid, Workspace, spread, wave};
use crate::lens::LocalPupil;
use crate::sensor::{Halo, Sensor};

/// Cells per pixel for rays: odd, so that a cell is in the middle of its pixel; more where the picture
/// is small.
const CELLS: usize = 3;
const SMALL_CELLS: usize = 5;
/// Radius of the rays below which a picture is small, px.
const SMALL_PX: f64 = 3.0;
/// KernelBounds of the symmetric blur, standard deviations: 1e-8 of the light is beyond.
const BLUR_REACH: f64 = 5.7;

/// The tile a picture is drawn for.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// Its top-left outer corner from the chief ray, px.
    pub(super) corner: [f64; 2],
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// From how far beyond its edges light comes in, px along x and y.
    pub(super) room: [f64; 2],
}

/// The spectrum of a picture on a window that repeats, integration over pixels included.
pub(super) struct Spectrum {
    /// Lines along y for the frequencies along x from 0 on, of all frequencies along y.
    pub(super) values: Vec<C>,
    /// Frequencies in all, along x (of which half or fewer are kept) and y.
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Pixels of the window; frequencies are in periods over it.
    pub(super) pixels: [usize; 2],
    /// The tile's pixel in the window's top-left corner.
    pub(super) first: [i64; 2],
    /// The tile's pixel whose middle has phase zero.
    pub(super) origin: [i64; 2],
}

/// The picture that a lens draws of one point, to be seen through any [`Sensor`].
pub struct OpticalPsf {
    spectrum: Spectrum,
    size: [usize; 2],
    pixels: Grid,
    /// Room for a picture and a halo beside each other, where one is expected.
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
    /// Draws `pupil`, its own sensor left out, for a tile of `width` x `height` pixels whose top-left outer
    /// corner lies at `corner` (x, y) px from the chief ray. `largest` is as wide as any sensor that is to be
    /// tried: light that it would bring into the tile is drawn too. For a halo that is all of the
    /// light, but for rays that land farther from the tile than it is wide.
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

    /// As [`OpticalPsf::draw`], of which the extent is known.
    pub(super) fn within(
        extent: &Extent,
        pupil: &LocalPupil,
        grid: &TileGrid,
        largest: &Sensor,
        detail: Detail,
        space: &mut Workspace,
    ) -> Self {
        let blur = (pupil.blur_variances_px2()).map(|v| BLUR_REACH * v.max(0.0).sqrt());
        let reach = largest.reach_px();
        let size = [grid.width, grid.height];
        let view = View {
            corner: grid.corner_px,
            size,
            room: [0, 1].map(|axis| reach[axis] + blur[axis]),
        };
        let spectrum = if let Some(half_width) = wave::half_width(pupil) {
            wave::spectrum(pupil, half_width, extent, &view, &mut space.fourier)
        } else {
            let scatters = largest.halo.share != 0.0;
            of_rays(pupil, extent, &view, scatters, detail, space)
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
        fourier.grid([0, 1].map(|axis| quick_length(pixels[axis] + self.size[axis])))
    }

    /// The tile, row-major, behind `sensor`, whose tone is not applied: each pixel's share of the light.
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

    /// Where the window's row or column `k` lies in the picture of a spectrum.
    fn place(&self, k: i64, axis: usize) -> usize {
        let from_origin = k + self.spectrum.first[axis] - self.spectrum.origin[axis];
        from_origin.rem_euclid(self.spectrum.pixels[axis] as i64) as usize
    }

    /// The tile's part of `picture`; dark beyond the window.
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

    /// The tile's part of all light of `picture` scattered by `halo`.
    fn scattered(&self, picture: &[f64], halo: &Halo) -> Vec<f64> {
        let window = self.spectrum.pixels;
        let unexpected;
        let grid = if let Some(grid) = &self.padded {
            grid
        } else {
            unexpected = self.plan_padded(&mut Fourier::default());
            &unexpected
        };
        let mut light = vec![0.0; grid.columns * grid.rows];
        for y in 0..window[1] {
            let from = self.place(y as i64, 1) * self.pixels.columns;
            for x in 0..window[0] {
                light[y * grid.columns + x] = picture[from + self.place(x as i64, 0)];
            }
        }
        // From the window's last pixel to the tile's first, and the other way.
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

/// The spectrum of what rays draw.
fn of_rays(
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
        pixels[axis] = quick_length((high.ceil() as i64 - first[axis]) as usize);
    }
    let grid = space.fourier.grid(pixels.map(|n| n * cells));
    let origin = [0, 1].map(|axis| view.corner[axis] + first[axis] as f64);
    let rings = extent.rings(detail);
    spread(
        pupil,
        &[],
        0,
        rings,
        origin,
        (grid.columns, grid.rows),
        cells,
        space,
    );
    let mut lines = space.fourier.buffer(0);
    let mut values = grid.forward(&mut space.canvas.light, usize::MAX, &mut lines);
    space.fourier.keep(lines);
    // Gathering cells into pixels, from the middle of the first; and the discrete Gaussian.
    let passes = |axis: usize, k: i64| {
        let f = k as f64 / pixels[axis] as f64;
        let gathered = sinc(f) / sinc(f / cells as f64);
        let t = pupil.blur_variances_px2()[axis].max(0.0) * (cells * cells) as f64;
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

impl Spectrum {
    /// The spectrum of the picture at pixels' centres behind streak, box and copies of `sensor`: what lies
    /// beyond the frequencies of `grid` folds back, as where a sensor samples.
    fn folded(&self, sensor: &Sensor, grid: &Grid) -> Vec<C> {
        let [width, height] = self.pixels;
        let mut folded = vec![C::default(); grid.half() * height];
        let share = 1.0 / (width * height) as f64;
        let through = Through::new(self, sensor);
        let lines = self.values.chunks_exact(self.rows).enumerate();
        for (k, line) in lines {
            let here = k % width;
            let there = (width - here) % width;
            let paired = k > 0 && 2 * k != self.columns;
            let target =
                |column: usize, wanted: bool| (wanted && column < grid.half()).then_some(column);
            let (here, there) = (target(here, true), target(there, paired));
            let across = through.across[k] * share;
            let mut put = |row: usize, value: C| {
                let (up, down) = through.rows[row];
                if let Some(column) = here {
                    folded[column * height + up as usize] += value;
                }
                if let Some(column) = there {
                    folded[column * height + down as usize] += value.conj();
                }
            };
            match &through.streak {
                None => {
                    for (row, value) in line.iter().enumerate() {
                        put(row, value * (across * through.down[row]));
                    }
                }
                Some(streak) => {
                    for (row, value) in line.iter().enumerate() {
                        let spread = streak.at(k, row);
                        put(row, value * (across * through.down[row] * spread));
                    }
                }
            }
        }
        folded
    }
}

/// What a sensor does to each frequency of a spectrum.
struct Through {
    /// Box and copies along x and y.
    across: Vec<f64>,
    down: Vec<f64>,
    /// Onto which frequencies of the pixels those along y and their opposites fold.
    rows: Vec<(u32, u32)>,
    streak: Option<Streak>,
}

impl Through {
    fn new(spectrum: &Spectrum, sensor: &Sensor) -> Self {
        let lines = spectrum.values.len() / spectrum.rows.max(1);
        let plain = |axis: usize, k: i64| {
            let f = k as f64 / spectrum.pixels[axis] as f64;
            sinc(f * sensor.box_px[axis]) * (PI * f * sensor.copies_px[axis]).cos()
        };
        let along = |axis: usize, k: i64| {
            let phase = PI * k as f64 / spectrum.pixels[axis] as f64 * sensor.streak_px[axis];
            (phase, phase.sin(), phase.cos())
        };
        let row = |k: usize| signed(k, spectrum.rows);
        let height = spectrum.pixels[1] as i64;
        let fold = |k: i64| k.rem_euclid(height) as u32;
        Self {
            across: (0..lines).map(|k| plain(0, k as i64)).collect(),
            down: (0..spectrum.rows).map(|k| plain(1, row(k))).collect(),
            rows: (0..spectrum.rows)
                .map(|k| (fold(row(k)), fold(-row(k))))
                .collect(),
            streak: (sensor.streak_px != [0.0; 2]).then(|| Streak {
                across: (0..lines).map(|k| along(0, k as i64)).collect(),
                down: (0..spectrum.rows).map(|k| along(1, row(k))).collect(),
            }),
        }
    }
}

/// The sinc of a streak by its phase along x and y, with sines and cosines.
struct Streak {
    across: Vec<(f64, f64, f64)>,
    down: Vec<(f64, f64, f64)>,
}

impl Streak {
    #[inline(always)]
    fn at(&self, k: usize, row: usize) -> f64 {
        let ((a, sin_a, cos_a), (b, sin_b, cos_b)) = (self.across[k], self.down[row]);
        let phase = a + b;
        if phase.abs() < 1e-4 {
            1.0 - phase * phase / 6.0
        } else {
            (sin_a * cos_b + cos_a * sin_b) / phase
        }
    }
}

/// `sin(pi x) / (pi x)`.
pub(super) fn sinc(x: f64) -> f64 {
    let phase = PI * x;
    if phase.abs() < 1e-4 {
        1.0 - phase * phase / 6.0
    } else {
        phase.sin() / phase
    }
}

/// The frequency at place `k` of `count`: the upper half are negative ones.
pub(super) fn signed(k: usize, count: usize) -> i64 {
    if 2 * k > count {
        k as i64 - count as i64
    } else {
        k as i64
    }
}
