//! `pupil`: the light of all rays through the pupil, where they land.
//!
//! The exact density of the ray map over the pupil, integrated over pixels, from defocus far below a
//! pixel to hundreds of pixels, through focus and caustics: a mesh over the pupil (`mesh`) whose
//! triangles are spread over the pixels by area (`splat`), then the symmetric blur (`taps`).
//! No ray is a sample, so there is neither noise nor moire. Derivatives by whatever the wavefront and
//! the stops depend on come with it, for fitting.

mod mesh;
mod splat;
mod taps;
#[cfg(test)]
mod tests;

use crate::lens::{LocalPupil, MOST_STOPS, Stop, Transmission, Wavefront};
use crate::psf::rows::grid_about;
use crate::psf::{KernelRows, LocalBlur, PsfModel, Reach, Window};
use mesh::{Mesh, Ring};
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

/// Rings per root of the extent's radius (px): keeps the rim's polygon within a fiftieth of a pixel.
const RIM_FINENESS: f64 = 2.7;
/// Neighbours on a plate whose rays land within this many px of where those of the first land, shift
/// and blur included, share a kernel: that in their middle, so that most rays are half as far off and
/// errors cancel from neighbour to neighbour. What that costs: [`Detail::PICTURE`].
const ALIKE_PX: f64 = 0.1;
/// Rays on the pupil's rim, where they move most, that are compared for it.
const RIM_POINTS: usize = 8;
/// Least number of rings, and the largest that is ever needed by what can be drawn, and by what fits.
const LEAST_RINGS: usize = 8;
const MOST_RINGS: usize = 1000;
const MOST_FIT_RINGS: usize = 120;

/// Buffers of [`draw`], to be used again.
#[derive(Debug, Default)]
pub struct Workspace {
    inner: Ring,
    outer: Ring,
    canvas: Canvas,
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
/// # Panics
/// If a tangent that moves stops comes before one that does not.
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
    let moving = tangents.iter().filter(|t| t.moves_stops()).count();
    assert!(
        tangents[tangents.len() - moving..]
            .iter()
            .all(Tangent::moves_stops),
        "tangents that move stops come last"
    );
    let factor = extent.cells_per_pixel(pupil.blur_variance_px2);
    let taps = (factor > 1 || pupil.blur_variance_px2 > 0.0 || !tangents.is_empty())
        .then(|| Taps::new(pupil.blur_variance_px2, factor));
    let margin = taps.as_ref().map_or(0, |t| t.margin);
    let cells = (width * factor + 2 * margin, height * factor + 2 * margin);
    let scale = factor as f64;
    space.canvas.clear(cells, scale, tangents.len());
    let origin = [
        corner.0 - margin as f64 / scale,
        corner.1 - margin as f64 / scale,
    ];
    pulp::Arch::new().dispatch(Spreading {
        mesh: &Mesh::new(pupil, tangents, moving, extent.rings(detail)),
        origin,
        transmission: pupil.transmission,
        space,
    });
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

/// The box about the chief ray in which rays land, px.
#[derive(Debug, Clone, Copy)]
struct Extent {
    low: [f64; 2],
    high: [f64; 2],
    /// Largest second derivative of the landing point by the pupil point, px.
    bend: f64,
}

impl Extent {
    fn of(pupil: &LocalPupil) -> Self {
        const ANGLES: usize = 24;
        let (centre, depth) = pupil.inside();
        let first = pupil.landing(centre);
        let mut extent = Self {
            low: first,
            high: first,
            bend: 0.0,
        };
        for k in 0..ANGLES {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / ANGLES as f64).sin_cos();
            let reach = if depth > crate::lens::LEAST_REACH {
                pupil.edge(centre, cos, sin).0
            } else {
                crate::lens::LEAST_REACH
            };
            let rim = [centre[0] + reach * cos, centre[1] + reach * sin];
            extent.bend = extent.bend.max(pupil.wavefront.bend(rim));
            for share in [0.3, 0.55, 0.75, 0.9, 1.0] {
                let r = reach * share;
                let p = pupil.landing([centre[0] + r * cos, centre[1] + r * sin]);
                extent.low = [0, 1].map(|axis| extent.low[axis].min(p[axis]));
                extent.high = [0, 1].map(|axis| extent.high[axis].max(p[axis]));
            }
        }
        extent
    }

    /// The box about `centroid` that holds all light.
    fn reach(&self, centroid: [f64; 2], blur_variance_px2: f64) -> Reach {
        // What the extent's few rays missed, the blur, and the pixel of the outermost ray.
        let margin = 0.04 * self.radius() + 5.0 * blur_variance_px2.sqrt() + 0.5;
        Reach {
            left_px: centroid[0] - self.low[0] + margin,
            right_px: self.high[0] - centroid[0] + margin,
            up_px: centroid[1] - self.low[1] + margin,
            down_px: self.high[1] - centroid[1] + margin,
        }
    }

    /// Half the larger side, px.
    fn radius(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1]) / 2.0
    }

    /// Rings of the mesh. Within a triangle the map is taken as linear: what matters is how much it
    /// bends, and how round the rim is.
    fn rings(&self, detail: Detail) -> usize {
        let inside = detail.0 * self.bend.sqrt();
        let rim = RIM_FINENESS * self.radius().sqrt();
        let most = if detail == Detail::FULL {
            MOST_RINGS
        } else {
            MOST_FIT_RINGS
        };
        (inside.max(rim).ceil() as usize).clamp(LEAST_RINGS, most)
    }

    /// Cells per pixel on which light is spread before it is blurred: more where the picture has
    /// detail within a pixel and there is a blur that would see it.
    fn cells_per_pixel(&self, blur_variance_px2: f64) -> usize {
        if blur_variance_px2 <= 0.0 || blur_variance_px2 > 4.0 {
            1
        } else if self.radius() < 3.0 {
            4
        } else if self.radius() < 16.0 {
            2
        } else {
            1
        }
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
        Extent::of(&pupil).reach(pupil.centroid(), pupil.blur_variance_px2)
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
        let rest = |p: &LocalPupil| (p.transmission, p.squeeze, p.wave_px, p.sensor);
        if a.stops().len() != b.stops().len() || rest(&a) != rest(&b) {
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
        let reach = extent.reach(centroid, pupil.blur_variance_px2);
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
