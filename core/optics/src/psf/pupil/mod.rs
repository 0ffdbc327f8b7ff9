//! `pupil`: the PSF of the ray map over the pupil, and of diffraction.
//!
//! The ray density is integrated exactly over pixels, from defocus far below a pixel to hundreds of pixels, through
//! focus and caustics. A triangle mesh over the pupil (`mesh`) is mapped to the sensor and rasterised with exact area
//! coverage (`rasterise`), then the symmetric blur is applied (`gaussian_blur`). Rays are not sampled, so there is
//! neither noise nor moiré. Derivatives by parameters of the wavefront, the stops and
//! the transmission are available for fits.
//!
//! A pupil that diffracts is drawn by Fourier transform instead (`wave`). The sensor acts on the spectrum of either
//! ([`OpticalPsf`]).

mod edge_coverage;
mod extent;
mod fourier;
mod gaussian_blur;
mod halo;
mod mesh;
mod optical_psf;
mod polygon;
mod rasterise;
mod spectrum;
#[cfg(test)]
mod tests;
mod wave;
mod workspace;

use crate::lens::{LocalPupil, MAX_STOPS, Stop, Transmission, Wavefront};
use crate::psf::kernel::KernelGrid;
use crate::psf::{KernelBounds, KernelRows, LocalBlur, PsfModel, SampleGrid};
use extent::Extent;
use gaussian_blur::GaussianBlur;
use mesh::Mesh;
pub use optical_psf::OpticalPsf;
use polygon::Scratch;
use rasterise::{Deposit, Filter};
pub use workspace::{PsfImage, Workspace};

/// The PSF model that draws [`LocalBlur::pupil`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Pupil;

/// The derivative of a pupil with respect to one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct PupilDerivative {
    /// Derivative of the wavefront.
    pub wavefront: Wavefront,
    /// Derivatives of centre and radius of each of [`LocalPupil::stops`].
    pub stops: [Stop; MAX_STOPS],
    /// Derivatives of the numbers of [`LocalPupil::transmission`].
    pub transmission: Transmission,
}

impl PupilDerivative {
    /// Creates the derivative of a parameter that changes the wavefront only.
    pub fn from_wavefront(wavefront: Wavefront) -> Self {
        let still = Stop {
            centre: [0.0, 0.0],
            radius: 0.0,
        };
        Self {
            wavefront,
            stops: [still; MAX_STOPS],
            transmission: Transmission::default(),
        }
    }

    /// Returns whether the light changes on its way through the pupil: by stops that move, or by the transmission.
    pub fn changes_light(&self) -> bool {
        let moves = |s: &Stop| s.radius != 0.0 || s.centre != [0.0, 0.0];
        self.transmission != Transmission::default() || self.stops.iter().any(moves)
    }
}

/// The resolution of the mesh: rings per square root of the largest second derivative of the ray map (px).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail(f64);

impl Detail {
    /// For predictions: the error is 70 dB below the light for every lens tried, including caustics.
    pub const FULL: Self = Self(12.0);
    /// For fits: 60 dB with strong caustics, 70 dB with weak ones. Each doubling lowers the error by 12 dB.
    pub const FIT: Self = Self(6.0);
    /// For comparing starting points: 46 dB with strong caustics.
    pub const DRAFT: Self = Self(2.5);
    /// For the first iterations of fits.
    pub const COARSE: Self = Self(4.0);
    /// For rendering. With kernels shared within `SHARING_TOLERANCE_PX`, a plate of bright points in the corner of a
    /// fast lens is 57 dB from rendering with one fine kernel a pixel; a test holds 45 dB.
    pub const RENDER: Self = Self(3.0);
    /// For kernels that renderers interpolate: it misplaces up to 0.8 % of the light (the demo's lens), interpolation more.
    pub const INTERPOLATED: Self = Self(2.0);

    /// Returns whether kernels are drawn for a renderer rather than compared with observations.
    fn is_for_rendering(self) -> bool {
        self == Self::RENDER || self == Self::INTERPOLATED
    }
}

/// Largest difference between the landing points of the rays of two source pixels that share a kernel, px, including
/// shift and blur.
///
/// A run of pixels shares the kernel of its middle, so most rays are off by half as much and errors cancel between
/// neighbours. [`Detail::RENDER`] states the resulting error.
const SHARING_TOLERANCE_PX: f64 = 0.1;
/// Rays on the rim of the pupil, where they differ most, that [`Pupil`] compares for kernel sharing.
const RIM_POINTS: usize = 8;

/// The pixels of a tile, placed relative to the chief ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileGrid {
    /// Top-left outer corner (x, y) from the chief ray, px.
    pub corner_px: [f64; 2],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// Draws the PSF of `pupil` on the pixels of `grid`; the light of the whole plane sums to one.
///
/// With any `derivatives`, `out` also gets the derivative of each pixel along each of them, and by the
/// variance of the symmetric blur.
///
/// Diffraction and the sensor's blur are part of the PSF, but have no derivatives. The sensor's tone is not
/// applied.
///
/// # Panics
/// If a derivative that moves stops or changes the transmission comes before one of the wavefront alone. If there are derivatives and the pupil
/// diffracts or its sensor is not ideal.
pub fn draw(
    pupil: &LocalPupil,
    grid: &TileGrid,
    derivatives: &[PupilDerivative],
    detail: Detail,
    space: &mut Workspace,
    out: &mut PsfImage,
) {
    let extent = Extent::of(pupil);
    draw_within(&extent, pupil, grid, derivatives, detail, space, out);
}

/// Draws like [`draw`], with the extent of the rays already known.
fn draw_within(
    extent: &Extent,
    pupil: &LocalPupil,
    grid: &TileGrid,
    derivatives: &[PupilDerivative],
    detail: Detail,
    space: &mut Workspace,
    out: &mut PsfImage,
) {
    if pupil.diffracts() || !pupil.sensor.is_ideal() {
        assert!(
            derivatives.is_empty(),
            "derivatives are those of rays on an ideal sensor"
        );
        let picture = OpticalPsf::within(extent, pupil, grid, &pupil.sensor, detail, space);
        out.light = picture.through(&pupil.sensor);
        out.derivatives.clear();
        out.blur_derivative.clear();
        return;
    }
    let changing = derivatives.iter().filter(|t| t.changes_light()).count();
    assert!(
        derivatives[derivatives.len() - changing..]
            .iter()
            .all(PupilDerivative::changes_light),
        "derivatives that change the light come last"
    );
    let variances = pupil.blur_variances_px2();
    let least = variances[0].min(variances[1]);
    let factor = extent.cells_per_pixel(least, detail);
    let (width, height) = (grid.width, grid.height);
    let scale = factor as f64;
    let deposit = Deposit::choose(detail, scale * extent.radius(), scale * scale * least);
    let excess = deposit.excess_variance() / (scale * scale);
    let blur = (factor > 1 || least > 0.0 || !derivatives.is_empty())
        .then(|| GaussianBlur::new(variances.map(|v| v - excess), factor));
    let margin = blur.as_ref().map_or(0, |blur| blur.margin);
    let cells = CellGrid {
        origin: grid.corner_px.map(|x| x - margin as f64 / scale),
        columns: width * factor + 2 * margin,
        rows: height * factor + 2 * margin,
        per_pixel: factor,
        deposit,
    };
    let mesh = Mesh::new(pupil, derivatives, changing, extent.rings(detail));
    rasterise(&mesh, pupil.transmission.clone(), &cells, space);
    let pixels = width * height;
    out.light.resize(pixels, 0.0);
    out.derivatives
        .resize(pixels * PsfImage::stride(derivatives.len()), 0.0);
    out.derivatives.fill(0.0);
    let Some(blur) = blur else {
        out.light.copy_from_slice(&space.canvas.light);
        out.blur_derivative.clear();
        return;
    };
    let size = (width, height);
    blur.apply(&space.canvas.light, 1, size, &mut out.light);
    if !derivatives.is_empty() {
        let depth = PsfImage::stride(derivatives.len());
        let unblurred = space.canvas.derivatives.as_flattened();
        blur.apply(unblurred, depth, size, &mut out.derivatives);
        out.blur_derivative.resize(pixels, 0.0);
        blur.apply_variance_derivative(&space.canvas.light, size, &mut out.blur_derivative);
    }
}

/// A grid of cells, finer than the pixels, on which light is rasterised.
struct CellGrid {
    /// Top-left outer corner from the chief ray, px.
    origin: [f64; 2],
    columns: usize,
    rows: usize,
    /// Cells along the side of a pixel.
    per_pixel: usize,
    deposit: Deposit,
}

/// Rasterises the light of `mesh` and its derivatives on the canvas of `space`; the sum over the plane is one.
fn rasterise(mesh: &Mesh, transmission: Transmission, cells: &CellGrid, space: &mut Workspace) {
    space.canvas.clear(cells, mesh.derivative_count());
    pulp::Arch::new().dispatch(Rasterising {
        mesh,
        origin: cells.origin,
        filter: Filter {
            transmission,
            rates: mesh.transmission_rates(),
            shadow: mesh.part_shadow(),
        },
        space,
    });
}

/// [`rasterise`] for `pulp::Arch::dispatch`.
struct Rasterising<'a, 'b> {
    mesh: &'a Mesh<'b>,
    origin: [f64; 2],
    filter: Filter,
    space: &'a mut Workspace,
}

impl pulp::WithSimd for Rasterising<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Workspace {
            inner,
            outer,
            canvas,
            ..
        } = self.space;
        let first = self.mesh.first_ring();
        self.mesh.ring(simd, first, inner);
        let mut scratch = Scratch::default();
        for k in first + 1..=self.mesh.rings() {
            self.mesh.ring(simd, k, outer);
            canvas.add_ring(k, inner, outer, self.origin, &self.filter, &mut scratch);
            std::mem::swap(inner, outer);
        }
        canvas.finish(self.filter.rates.len());
    }
}

impl PsfModel for Pupil {
    fn id(&self) -> &'static str {
        "pupil"
    }

    fn needs_rays(&self) -> bool {
        true
    }

    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds {
        let pupil = rays(blur);
        Extent::of(pupil).kernel_bounds(pupil, pupil.centroid())
    }

    fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]) {
        assert_eq!(out.len(), window.len(), "one sample a pixel");
        let pupil = rays(blur);
        let centroid = pupil.centroid();
        let mut drawn = PsfImage::default();
        draw(
            pupil,
            &tile_grid(window, centroid),
            &[],
            Detail::FULL,
            &mut Workspace::default(),
            &mut drawn,
        );
        out.copy_from_slice(&drawn.light);
    }

    fn sample_f32(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f32]) {
        let mut samples = vec![0.0; window.len()];
        self.sample(blur, window, &mut samples);
        for (out, sample) in out.iter_mut().zip(samples) {
            *out = sample as f32;
        }
    }

    /// True where no ray lands more than `SHARING_TOLERANCE_PX` from where the other blur puts it.
    fn can_share_kernel(
        &self,
        blur: &LocalBlur,
        shift_px: (f64, f64),
        other: &LocalBlur,
        other_shift_px: (f64, f64),
    ) -> bool {
        let (a, b) = (rays(blur), rays(other));
        let grid = blur.pixel_aspect == other.pixel_aspect;
        let rest = |p: &LocalPupil| (p.squeeze, p.wave_px, p.sensor);
        let obstructed = [a, b].map(|pupil| pupil.obstruction());
        let stops = a.stops().len() == b.stops().len()
            && obstructed[0].is_some() == obstructed[1].is_some();
        if !grid || !stops || a.transmission != b.transmission || rest(a) != rest(b) {
            return false;
        }
        let shifted = (shift_px.0 - other_shift_px.0).hypot(shift_px.1 - other_shift_px.1);
        let blurred = (a.blur_variance_px2.sqrt() - b.blur_variance_px2.sqrt()).abs();
        // In pupil radii; the light extends about two standard deviations to either side.
        let of_b = b.stops().iter().chain(&obstructed[1]);
        let clipped: f64 = (a.stops().iter().chain(&obstructed[0]).zip(of_b))
            .map(|(s, t)| {
                let moved = (s.centre[0] - t.centre[0]).hypot(s.centre[1] - t.centre[1]);
                moved + (s.radius - t.radius).abs()
            })
            .sum();
        let clipped = 2.0 * clipped * blur.moments.trace().max(0.0).sqrt();
        let left = SHARING_TOLERANCE_PX - shifted - blurred - clipped;
        if left <= 0.0 {
            return false;
        }
        let change = a.wavefront.add_scaled(-1.0, &b.wavefront);
        let mean = change.mean_slope();
        (0..RIM_POINTS).all(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / RIM_POINTS as f64).sin_cos();
            let [x, y] = change.slope([cos, sin]);
            (x - mean[0]).hypot(y - mean[1]) <= left
        })
    }

    /// Draws with [`Detail::RENDER`].
    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        draw_rows_with(Detail::RENDER, blur, shift_px, None, rows);
    }

    /// Draws with [`Detail::INTERPOLATED`].
    fn draw_interpolated_rows(
        &self,
        blur: &LocalBlur,
        shift_px: (f64, f64),
        reach: Option<[i32; 2]>,
        rows: &mut KernelRows,
    ) {
        draw_rows_with(Detail::INTERPOLATED, blur, shift_px, reach, rows);
    }
}

/// Draws the kernel of `blur` with `detail`: all of it, or what lies within `reach` columns and rows of the source pixel.
fn draw_rows_with(
    detail: Detail,
    blur: &LocalBlur,
    shift_px: (f64, f64),
    reach: Option<[i32; 2]>,
    rows: &mut KernelRows,
) {
    let pupil = rays(blur);
    let centroid = pupil.centroid();
    let extent = Extent::of(pupil);
    let whole = KernelGrid::new(&extent.kernel_bounds(pupil, centroid), shift_px);
    // The light of diffraction and of the sensor is divided by its sum over the whole kernel.
    let of_rays = !pupil.diffracts() && pupil.sensor.is_ideal();
    let part = (reach.filter(|_| of_rays)).and_then(|reach| whole.cropped(reach));
    let grid = part.unwrap_or(whole);
    let window = grid.samples;
    let (mut space, mut drawn) = std::mem::take(&mut rows.scratch);
    let pixels = tile_grid(&window, centroid);
    draw_within(&extent, pupil, &pixels, &[], detail, &mut space, &mut drawn);
    rows.copy_from_image(&drawn.light, grid.left, grid.top, window.width);
    if part.is_some() {
        rows.set_sum(1.0);
    }
    rows.scratch = (space, drawn);
}

/// Returns the pixels of `window`, which is placed about the centroid, relative to the chief ray.
fn tile_grid(window: &SampleGrid, centroid: [f64; 2]) -> TileGrid {
    TileGrid {
        corner_px: [
            centroid[0] + window.first_x_px - 0.5,
            centroid[1] + window.first_y_px - 0.5,
        ],
        width: window.width,
        height: window.height,
    }
}

/// Returns wavefront and pupil of `blur`.
///
/// # Panics
/// If they are missing: callers check [`PsfModel::needs_rays`] against the lens first.
fn rays(blur: &LocalBlur) -> &LocalPupil {
    (blur.pupil.as_ref()).expect("the model `pupil` needs a lens of the kind `pupil`")
}
