//! `pupil`: the light of all rays through the pupil, where they land.
//!
//! The exact density of the ray map over the pupil, integrated over pixels, from defocus far below a
//! pixel to hundreds of pixels, through focus and caustics: a mesh over the pupil (`mesh`) whose
//! triangles are spread over the pixels by area (`splat`), then the symmetric blur (`taps`).
//! No ray is a sample, so there is neither noise nor moire. Derivatives by whatever the wavefront and
//! the stops depend on come with it, for fitting.

mod extent;
mod fourier;
mod halo;
mod mesh;
mod respond;
#[cfg(test)]
mod respond_tests;
mod splat;
mod taps;
#[cfg(test)]
mod tests;
mod wave;
#[cfg(test)]
mod wave_tests;

use crate::lens::{LocalPupil, MAX_STOPS, Stop, Transmission, Wavefront};
use crate::psf::rows::grid_about;
use crate::psf::{KernelBounds, KernelRows, LocalBlur, PsfModel, SampleGrid};
use extent::Extent;
use fourier::Fourier;
use mesh::{Mesh, Ring};
pub use respond::OpticalPsf;
use splat::{Canvas, Scratch};
use taps::Taps;

/// The ray-exact PSF of [`LocalBlur::pupil`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Pupil;

/// A direction in which a pupil can change: how its wavefront and its stops move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PupilDerivative {
    /// Rate of the wavefront.
    pub wavefront: Wavefront,
    /// Rates of centre and radius of each of [`LocalPupil::stops`].
    pub stops: [Stop; MAX_STOPS],
}

impl PupilDerivative {
    /// A change of the wavefront alone.
    pub fn from_wavefront(wavefront: Wavefront) -> Self {
        let still = Stop {
            centre: [0.0, 0.0],
            radius: 0.0,
        };
        Self {
            wavefront,
            stops: [still; MAX_STOPS],
        }
    }

    fn moves_stops(&self) -> bool {
        self.stops
            .iter()
            .any(|s| s.radius != 0.0 || s.centre != [0.0, 0.0])
    }
}

/// How fine the mesh is: rings per root of the map's bend (px).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail(f64);

impl Detail {
    /// Keeps the error of every lens tried, caustics included, 70 dB below the light.
    pub const FULL: Self = Self(12.0);
    /// For fits: 60 dB with strong caustics, 70 dB with weak ones. The error falls by 12 dB with
    /// every doubling.
    pub const FIT: Self = Self(6.0);
    /// For the first steps of fits.
    pub const COARSE: Self = Self(4.0);
    /// For plates. With kernels shared as `SHARING_TOLERANCE_PX` says, a plate of bright points in the corner of
    /// a fast lens comes out 57 dB from one fine kernel a pixel; a test holds 45 dB.
    pub const RENDER: Self = Self(3.0);
}

/// Neighbours on a plate whose rays land within this many px of where those of the first land, shift
/// and blur included, share a kernel: that in their middle, so that most rays are half as far off and
/// errors cancel from neighbour to neighbour. What that costs: [`Detail::RENDER`].
const SHARING_TOLERANCE_PX: f64 = 0.1;
/// Rays on the pupil's rim, where they move most, that are compared for it.
const RIM_POINTS: usize = 8;

/// Buffers of [`draw`], to be used again.
#[derive(Debug, Default)]
pub struct Workspace {
    inner: Ring,
    outer: Ring,
    canvas: Canvas,
    fourier: Fourier,
}

/// What [`draw`] drew; row-major.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PsfImage {
    /// Share of the light that each pixel gets.
    pub light: Vec<f64>,
    /// Its derivatives, pixel by pixel, one along each tangent and room for more: [`PsfImage::stride`].
    pub derivatives: Vec<f64>,
    /// Its derivative by the variance of the symmetric blur, per px².
    pub blur_derivative: Vec<f64>,
}

impl PsfImage {
    /// Values of `slopes` per pixel for `derivatives` derivatives; those beyond are of no meaning.
    pub fn stride(derivatives: usize) -> usize {
        mesh::packs(derivatives) * mesh::LANES
    }
}

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
/// If a derivative that moves stops comes before one that does not. If there are derivatives and the pupil
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
    let moving = derivatives.iter().filter(|t| t.moves_stops()).count();
    assert!(
        derivatives[derivatives.len() - moving..]
            .iter()
            .all(PupilDerivative::moves_stops),
        "derivatives that move stops come last"
    );
    let variances = pupil.blur_variances_px2();
    let least = variances[0].min(variances[1]);
    let factor = extent.cells_per_pixel(least);
    let taps = (factor > 1 || least > 0.0 || !derivatives.is_empty())
        .then(|| Taps::new(variances, factor));
    let margin = taps.as_ref().map_or(0, |t| t.margin);
    let (width, height) = (grid.width, grid.height);
    let cells = (width * factor + 2 * margin, height * factor + 2 * margin);
    let scale = factor as f64;
    let origin = [
        grid.corner_px[0] - margin as f64 / scale,
        grid.corner_px[1] - margin as f64 / scale,
    ];
    let rings = extent.rings(detail);
    spread(
        pupil,
        derivatives,
        moving,
        rings,
        origin,
        cells,
        factor,
        space,
    );
    let pixels = width * height;
    out.light.resize(pixels, 0.0);
    out.derivatives
        .resize(pixels * PsfImage::stride(derivatives.len()), 0.0);
    out.derivatives.fill(0.0);
    let Some(taps) = taps else {
        out.light.copy_from_slice(&space.canvas.light);
        out.blur_derivative.clear();
        return;
    };
    let size = (width, height);
    taps.apply(&space.canvas.light, 1, size, false, &mut out.light);
    if !derivatives.is_empty() {
        let depth = PsfImage::stride(derivatives.len());
        taps.apply(
            space.canvas.slopes.as_flattened(),
            depth,
            size,
            false,
            &mut out.derivatives,
        );
        out.blur_derivative.resize(pixels, 0.0);
        taps.apply(&space.canvas.light, 1, size, true, &mut out.blur_derivative);
    }
}

/// Spreads light and its derivatives over the canvas of `space`: `cells` (columns, rows) of which `factor`
/// make up a pixel's side, from `origin` px from the chief ray on.
#[allow(clippy::too_many_arguments)] // One more than `draw`.
fn spread(
    pupil: &LocalPupil,
    derivatives: &[PupilDerivative],
    moving: usize,
    rings: usize,
    origin: [f64; 2],
    cells: (usize, usize),
    factor: usize,
    space: &mut Workspace,
) {
    space.canvas.clear(cells, factor as f64, derivatives.len());
    pulp::Arch::new().dispatch(Spreading {
        mesh: &Mesh::new(pupil, derivatives, moving, rings),
        origin,
        transmission: pupil.transmission,
        space,
    });
}

/// Walks through the mesh and spreads its light, compiled for the machine's vector instructions.
struct Spreading<'a, 'b> {
    mesh: &'a Mesh<'b>,
    origin: [f64; 2],
    transmission: Transmission,
    space: &'a mut Workspace,
}

impl pulp::WithSimd for Spreading<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Workspace {
            inner,
            outer,
            canvas,
            ..
        } = self.space;
        self.mesh.ring(0, inner);
        let (mut total, mut scratch) = (0.0, Scratch::default());
        for k in 1..=self.mesh.rings() {
            self.mesh.ring(k, outer);
            let rings = (&*inner, &*outer);
            total += canvas.spread(k, rings, self.origin, self.transmission, &mut scratch);
            std::mem::swap(inner, outer);
        }
        // All light is one. What moving stops do to the total is left in the slopes: the light of a
        // tile is free in a fit, and a prediction has no derivatives.
        let share = 1.0 / total;
        canvas.light.iter_mut().for_each(|v| *v *= share);
        let slopes = canvas.slopes.as_flattened_mut();
        slopes.iter_mut().for_each(|v| *v *= share);
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
        Extent::of(&pupil).reach(&pupil, pupil.centroid())
    }

    fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]) {
        assert_eq!(out.len(), window.len(), "one sample a pixel");
        let pupil = rays(blur);
        let centroid = pupil.centroid();
        let mut drawn = PsfImage::default();
        draw(
            &pupil,
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

    /// True where no ray lands more than [`SHARING_TOLERANCE_PX`] from where the other blur puts it.
    fn can_share_kernel(
        &self,
        blur: &LocalBlur,
        shift_px: (f64, f64),
        other: &LocalBlur,
        other_shift_px: (f64, f64),
    ) -> bool {
        let (a, b) = (rays(blur), rays(other));
        let grid = blur.pixel_aspect == other.pixel_aspect;
        let rest = |p: &LocalPupil| (p.transmission, p.squeeze, p.wave_px, p.sensor);
        if !grid || a.stops().len() != b.stops().len() || rest(&a) != rest(&b) {
            return false;
        }
        let shifted = (shift_px.0 - other_shift_px.0).hypot(shift_px.1 - other_shift_px.1);
        let blurred = (a.blur_variance_px2.sqrt() - b.blur_variance_px2.sqrt()).abs();
        // Of pupil radii; the light is some two deviations wide on either side.
        let clipped: f64 = (a.stops().iter().zip(b.stops()))
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

    /// Draws with [`Detail::RENDER`]: a plate asks for a kernel a pixel.
    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        let pupil = rays(blur);
        let centroid = pupil.centroid();
        let extent = Extent::of(&pupil);
        let reach = extent.reach(&pupil, centroid);
        let (left, top, window) = grid_about(&reach, shift_px);
        let (mut space, mut drawn) = std::mem::take(&mut rows.scratch);
        draw_within(
            &extent,
            &pupil,
            &tile_grid(&window, centroid),
            &[],
            Detail::RENDER,
            &mut space,
            &mut drawn,
        );
        rows.take_over(&drawn.light, (left, top), window.width);
        rows.scratch = (space, drawn);
    }
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

/// The rays of `blur`.
///
/// # Panics
/// Where it has none: callers ask [`PsfModel::needs_rays`] and the lens first.
fn rays(blur: &LocalBlur) -> LocalPupil {
    blur.pupil
        .expect("the pupil model is asked only of lenses known ray by ray")
}
