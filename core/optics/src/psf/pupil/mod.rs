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

use crate::lens::{LocalPupil, MOST_STOPS, Stop, Transmission, Wavefront};
use crate::psf::rows::grid_about;
use crate::psf::{KernelRows, LocalBlur, PsfModel, Reach, Window};
use extent::Extent;
use fourier::Fourier;
use mesh::{Mesh, Ring};
pub use respond::Picture;
use splat::{Canvas, Scratch};
use taps::Taps;

/// The ray-exact PSF of [`LocalBlur::pupil`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Pupil;

/// A direction in which a pupil can change: how its wavefront and its stops move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// Rate of the wavefront.
    pub wavefront: Wavefront,
    /// Rates of centre and radius of each of [`LocalPupil::stops`].
    pub stops: [Stop; MOST_STOPS],
}

impl Tangent {
    /// A change of the wavefront alone.
    pub fn of_wavefront(wavefront: Wavefront) -> Self {
        let still = Stop {
            centre: [0.0, 0.0],
            radius: 0.0,
        };
        Self {
            wavefront,
            stops: [still; MOST_STOPS],
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
    /// For plates. With kernels shared as `ALIKE_PX` says, a plate of bright points in the corner of
    /// a fast lens comes out 57 dB from one fine kernel a pixel; a test holds 45 dB.
    pub const PICTURE: Self = Self(3.0);
}

/// Neighbours on a plate whose rays land within this many px of where those of the first land, shift
/// and blur included, share a kernel: that in their middle, so that most rays are half as far off and
/// errors cancel from neighbour to neighbour. What that costs: [`Detail::PICTURE`].
const ALIKE_PX: f64 = 0.1;
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
pub struct Drawn {
    /// Share of the light that each pixel gets.
    pub light: Vec<f64>,
    /// Its derivatives, pixel by pixel, one along each tangent and room for more: [`Drawn::stride`].
    pub slopes: Vec<f64>,
    /// Its derivative by the variance of the symmetric blur, per px².
    pub by_blur: Vec<f64>,
}

impl Drawn {
    /// Values of `slopes` per pixel for `tangents` tangents; those beyond are of no meaning.
    pub fn stride(tangents: usize) -> usize {
        mesh::packs(tangents) * mesh::LANES
    }
}

/// Draws `pupil` on `width` x `height` pixels whose top-left outer corner lies at `corner` (x, y) px
/// from the chief ray, with derivatives along `tangents` and, if there are any, by the blur's variance.
/// The whole plane's light is one.
///
/// Where light is a wave or the sensor is not ideal, both are drawn, but there are no derivatives; the
/// sensor's tone is not applied.
///
/// # Panics
/// If a tangent that moves stops comes before one that does not; if there are tangents and light is a
/// wave or the sensor not ideal.
pub fn draw(
    pupil: &LocalPupil,
    corner: (f64, f64),
    (width, height): (usize, usize),
    tangents: &[Tangent],
    detail: Detail,
    space: &mut Workspace,
    out: &mut Drawn,
) {
    let extent = Extent::of(pupil);
    draw_within(
        &extent,
        pupil,
        corner,
        (width, height),
        tangents,
        detail,
        space,
        out,
    );
}

/// As [`draw`], of which the extent is known.
#[allow(clippy::too_many_arguments)] // Those of `draw` and one more.
fn draw_within(
    extent: &Extent,
    pupil: &LocalPupil,
    corner: (f64, f64),
    (width, height): (usize, usize),
    tangents: &[Tangent],
    detail: Detail,
    space: &mut Workspace,
    out: &mut Drawn,
) {
    if pupil.is_wavy() || !pupil.sensor.is_ideal() {
        assert!(
            tangents.is_empty(),
            "derivatives are those of rays on an ideal sensor"
        );
        let view = ([corner.0, corner.1], [width, height]);
        let picture = Picture::within(extent, pupil, view, &pupil.sensor, detail, space);
        out.light = picture.through(&pupil.sensor);
        out.slopes.clear();
        out.by_blur.clear();
        return;
    }
    let moving = tangents.iter().filter(|t| t.moves_stops()).count();
    assert!(
        tangents[tangents.len() - moving..]
            .iter()
            .all(Tangent::moves_stops),
        "tangents that move stops come last"
    );
    let variances = pupil.blur_variances_px2();
    let least = variances[0].min(variances[1]);
    let factor = extent.cells_per_pixel(least);
    let taps =
        (factor > 1 || least > 0.0 || !tangents.is_empty()).then(|| Taps::new(variances, factor));
    let margin = taps.as_ref().map_or(0, |t| t.margin);
    let cells = (width * factor + 2 * margin, height * factor + 2 * margin);
    let scale = factor as f64;
    let origin = [
        corner.0 - margin as f64 / scale,
        corner.1 - margin as f64 / scale,
    ];
    let rings = extent.rings(detail);
    spread(pupil, tangents, moving, rings, origin, cells, factor, space);
    let pixels = width * height;
    out.light.resize(pixels, 0.0);
    out.slopes
        .resize(pixels * Drawn::stride(tangents.len()), 0.0);
    out.slopes.fill(0.0);
    let Some(taps) = taps else {
        out.light.copy_from_slice(&space.canvas.light);
        out.by_blur.clear();
        return;
    };
    let size = (width, height);
    taps.apply(&space.canvas.light, 1, size, false, &mut out.light);
    if !tangents.is_empty() {
        let depth = Drawn::stride(tangents.len());
        taps.apply(
            space.canvas.slopes.as_flattened(),
            depth,
            size,
            false,
            &mut out.slopes,
        );
        out.by_blur.resize(pixels, 0.0);
        taps.apply(&space.canvas.light, 1, size, true, &mut out.by_blur);
    }
}

/// Spreads light and its derivatives over the canvas of `space`: `cells` (columns, rows) of which `factor`
/// make up a pixel's side, from `origin` px from the chief ray on.
#[allow(clippy::too_many_arguments)] // One more than `draw`.
fn spread(
    pupil: &LocalPupil,
    tangents: &[Tangent],
    moving: usize,
    rings: usize,
    origin: [f64; 2],
    cells: (usize, usize),
    factor: usize,
    space: &mut Workspace,
) {
    space.canvas.clear(cells, factor as f64, tangents.len());
    pulp::Arch::new().dispatch(Spreading {
        mesh: &Mesh::new(pupil, tangents, moving, rings),
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
        // tile is free in a fit, and a prediction has no tangents.
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

    fn reach_px(&self, blur: &LocalBlur) -> Reach {
        let pupil = rays(blur);
        Extent::of(&pupil).reach(&pupil, pupil.centroid())
    }

    fn sample(&self, blur: &LocalBlur, window: &Window, out: &mut [f64]) {
        assert_eq!(out.len(), window.len(), "one sample a pixel");
        let pupil = rays(blur);
        let centroid = pupil.centroid();
        let corner = (
            centroid[0] + window.first_x_px - 0.5,
            centroid[1] + window.first_y_px - 0.5,
        );
        let mut drawn = Drawn::default();
        draw(
            &pupil,
            corner,
            (window.width, window.height),
            &[],
            Detail::FULL,
            &mut Workspace::default(),
            &mut drawn,
        );
        out.copy_from_slice(&drawn.light);
    }

    fn sample_f32(&self, blur: &LocalBlur, window: &Window, out: &mut [f32]) {
        let mut samples = vec![0.0; window.len()];
        self.sample(blur, window, &mut samples);
        for (out, sample) in out.iter_mut().zip(samples) {
            *out = sample as f32;
        }
    }

    /// Where no ray lands more than `ALIKE_PX` from where the other blur puts it.
    fn alike(&self, one: (&LocalBlur, (f64, f64)), other: (&LocalBlur, (f64, f64))) -> bool {
        let (a, b) = (rays(one.0), rays(other.0));
        let grid = one.0.pixel_aspect == other.0.pixel_aspect;
        let rest = |p: &LocalPupil| (p.transmission, p.squeeze, p.wave_px, p.sensor);
        if !grid || a.stops().len() != b.stops().len() || rest(&a) != rest(&b) {
            return false;
        }
        let shifted = (one.1.0 - other.1.0).hypot(one.1.1 - other.1.1);
        let blurred = (a.blur_variance_px2.sqrt() - b.blur_variance_px2.sqrt()).abs();
        // Of pupil radii; the light is some two deviations wide on either side.
        let clipped: f64 = (a.stops().iter().zip(b.stops()))
            .map(|(s, t)| {
                let moved = (s.centre[0] - t.centre[0]).hypot(s.centre[1] - t.centre[1]);
                moved + (s.radius - t.radius).abs()
            })
            .sum();
        let clipped = 2.0 * clipped * one.0.moments.trace().max(0.0).sqrt();
        let left = ALIKE_PX - shifted - blurred - clipped;
        if left <= 0.0 {
            return false;
        }
        let change = a.wavefront.plus(-1.0, &b.wavefront);
        let mean = change.mean_slope();
        (0..RIM_POINTS).all(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / RIM_POINTS as f64).sin_cos();
            let [x, y] = change.slope([cos, sin]);
            (x - mean[0]).hypot(y - mean[1]) <= left
        })
    }

    /// Draws with [`Detail::PICTURE`]: a plate asks for a kernel a pixel.
    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        let pupil = rays(blur);
        let centroid = pupil.centroid();
        let extent = Extent::of(&pupil);
        let reach = extent.reach(&pupil, centroid);
        let (left, top, window) = grid_about(&reach, shift_px);
        let corner = (
            centroid[0] + window.first_x_px - 0.5,
            centroid[1] + window.first_y_px - 0.5,
        );
        let (mut space, mut drawn) = std::mem::take(&mut rows.scratch);
        draw_within(
            &extent,
            &pupil,
            corner,
            (window.width, window.height),
            &[],
            Detail::PICTURE,
            &mut space,
            &mut drawn,
        );
        rows.take_over(&drawn.light, (left, top), window.width);
        rows.scratch = (space, drawn);
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
