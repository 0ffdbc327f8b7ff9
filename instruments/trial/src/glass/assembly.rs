//! A lens before a sensor, as built: surfaces in space, and the path of a ray through them.

use super::figure::Figure;
use super::surface::{Line, Surface, across};
use super::vector::{Vector, along, dot, minus, turned, unit};

/// Index of the channel that the lens is focused in.
pub(super) const GREEN: usize = 1;

/// A sensor plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SensorPlane {
    /// Its centre, mm.
    pub(super) centre: Vector,
    /// Its normal, a unit vector away from the scene.
    pub(super) normal: Vector,
    /// Distance of pixels, mm.
    pub(super) pitch_mm: f64,
    /// Frame position of its centre, px.
    pub(super) axis_px: [f64; 2],
}

/// A screen with a round hole about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hole {
    /// Index of the surface that it follows; `None` for one before the first.
    pub(super) behind: Option<usize>,
    /// Its position on the axis, mm.
    pub(super) z: f64,
    /// Its radius, mm.
    pub(super) radius: f64,
}

/// The scene as the designed lens sees it: the reference of distances and ideal positions, whatever is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    /// Position of the paraxial entrance pupil of the design in green, mm.
    pub(super) pupil_z: f64,
    /// Its radius, mm.
    pub(super) pupil_mm: f64,
    /// Height on the sensor of a paraxial chief ray over the tangent of its angle in the scene, mm.
    pub(super) chief_mm: f64,
}

/// A lens and a sensor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Assembly {
    pub(super) surfaces: Vec<Surface>,
    /// Index of the stop surface.
    pub(super) stop: usize,
    /// Radius of the stop, mm.
    pub(super) stop_mm: f64,
    pub(super) holes: Vec<Hole>,
    pub(super) sensor: SensorPlane,
    pub(super) view: View,
    /// True over stated object distance.
    pub(super) depth_factor: f64,
}

/// The end of a ray's path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landing {
    /// Landing point, frame px.
    pub(super) at: [f64; 2],
    /// Point in the stop, stop radii.
    pub(super) stop: [f64; 2],
    /// Least distance inside the clear apertures, mm; negative for a ray outside one.
    pub(super) inside_mm: f64,
}

/// A ray on its way to its [`Landing`].
struct Path {
    ray: Line,
    stop: [f64; 2],
    inside_mm: f64,
}

impl Assembly {
    /// Returns the object point at the stated distance `depth_m` whose ideal image is the frame position `ideal`.
    pub(super) fn object(&self, ideal: [f64; 2], depth_m: f64) -> Vector {
        let far = 1000.0 * depth_m * self.depth_factor;
        let scale = far * self.sensor.pitch_mm / self.view.chief_mm;
        let [ax, ay] = self.sensor.axis_px;
        [
            (ideal[0] - ax) * scale,
            (ideal[1] - ay) * scale,
            self.view.pupil_z - far,
        ]
    }

    /// Follows the ray from `object` towards the point `aim` of the designed entrance pupil, mm; `None` if it misses a
    /// surface or is totally reflected.
    pub(super) fn follow(&self, channel: usize, object: Vector, aim: [f64; 2]) -> Option<Landing> {
        self.follow_all(channel, object, [aim].into_iter()).pop()?
    }

    /// Follows rays as [`Assembly::follow`] does, all of them through one surface after the other: the processor works on several
    /// at a time, where a ray alone waits for each root and quotient.
    pub(super) fn follow_all(
        &self,
        channel: usize,
        object: Vector,
        aims: impl Iterator<Item = [f64; 2]>,
    ) -> Vec<Option<Landing>> {
        let start = |aim: [f64; 2]| {
            let point = [aim[0], aim[1], self.view.pupil_z];
            Some(Path {
                ray: Line {
                    point,
                    direction: unit(minus(point, object)),
                },
                stop: [0.0; 2],
                inside_mm: f64::INFINITY,
            })
        };
        let mut paths: Vec<Option<Path>> = aims.map(start).collect();
        let mut index = 1.0;
        self.pass_holes(None, &mut paths);
        for (i, surface) in self.surfaces.iter().enumerate() {
            let behind = surface.index[channel];
            for place in &mut paths {
                let Some(path) = place else { continue };
                let Some(ray) = surface.refract(path.ray, index / behind) else {
                    *place = None;
                    continue;
                };
                path.ray = ray;
                if i == self.stop || surface.clear_mm.is_some() {
                    let [x, y] = surface.local(ray.point);
                    if let Some(clear) = surface.clear_mm {
                        path.inside_mm = path.inside_mm.min(clear - x.hypot(y));
                    }
                    if i == self.stop {
                        path.stop = [x / self.stop_mm, y / self.stop_mm];
                    }
                }
            }
            index = behind;
            self.pass_holes(Some(i), &mut paths);
        }
        let land = |path: Path| Landing {
            at: self.land(path.ray),
            stop: path.stop,
            inside_mm: path.inside_mm,
        };
        paths.into_iter().map(|path| path.map(land)).collect()
    }

    fn pass_holes(&self, behind: Option<usize>, paths: &mut [Option<Path>]) {
        for hole in self.holes.iter().filter(|h| h.behind == behind) {
            for path in paths.iter_mut().flatten() {
                let s = (hole.z - path.ray.point[2]) / path.ray.direction[2];
                let [x, y, _] = along(path.ray.point, s, path.ray.direction);
                path.inside_mm = path.inside_mm.min(hole.radius - x.hypot(y));
            }
        }
    }

    /// Returns where a ray meets the sensor, frame px. The image is inverted; the frame shows it upright.
    fn land(&self, ray: Line) -> [f64; 2] {
        let SensorPlane {
            centre,
            normal,
            pitch_mm,
            axis_px,
        } = self.sensor;
        let s = dot(minus(centre, ray.point), normal) / dot(ray.direction, normal);
        let from = minus(along(ray.point, s, ray.direction), centre);
        let [ex, ey] = across(normal);
        [
            axis_px[0] - dot(from, ex) / pitch_mm,
            axis_px[1] - dot(from, ey) / pitch_mm,
        ]
    }

    /// Returns the elements: runs of surfaces with glass between them, cemented ones together. A plate in front of the
    /// sensor is not one.
    pub(super) fn elements(&self) -> Vec<std::ops::RangeInclusive<usize>> {
        let mut elements = Vec::new();
        let mut start = None;
        for (i, surface) in self.surfaces[..self.cover()].iter().enumerate() {
            match (surface.index[GREEN] > 1.0, start) {
                (true, None) => start = Some(i),
                (false, Some(first)) => {
                    elements.push(first..=i);
                    start = None;
                }
                _ => {}
            }
        }
        elements
    }

    /// Returns the index of the first surface of the plate in front of the sensor.
    pub(super) fn cover(&self) -> usize {
        self.surfaces.len() - 2
    }

    /// Moves surfaces across and along the axis by `by`, mm.
    pub(super) fn shift(&mut self, surfaces: std::ops::RangeInclusive<usize>, by: Vector) {
        for surface in &mut self.surfaces[surfaces] {
            surface.vertex = along(surface.vertex, 1.0, by);
        }
    }

    /// Turns surfaces by `angle` radians about the axis `about` through the middle of their first and last vertex.
    pub(super) fn tilt(
        &mut self,
        surfaces: std::ops::RangeInclusive<usize>,
        about: Vector,
        angle: f64,
    ) {
        let (first, last) = (
            self.surfaces[*surfaces.start()].vertex,
            self.surfaces[*surfaces.end()].vertex,
        );
        let middle = along(first, 0.5, minus(last, first));
        for surface in &mut self.surfaces[surfaces] {
            let from = turned(minus(surface.vertex, middle), about, angle);
            surface.vertex = along(middle, 1.0, from);
            surface.axis = unit(turned(surface.axis, about, angle));
        }
    }

    /// Adds a figure to a surface.
    pub(super) fn bend(&mut self, surface: usize, figure: Figure) {
        let bent = &mut self.surfaces[surface].figure;
        *bent = Some(bent.unwrap_or_default().plus(figure));
    }

    /// Moves the sensor along the axis to the least spread of rays from the axis point at `depth_m`, in green.
    pub(super) fn refocus(&mut self, depth_m: f64) {
        const RAYS: usize = 40;
        let object = self.object(self.sensor.axis_px, depth_m);
        let step = 0.05;
        let at = |assembly: &Self, aim: f64| -> Option<(f64, f64)> {
            let landing = assembly.follow(GREEN, object, [0.0, aim])?;
            let open = landing.stop[1].abs() <= 1.0 && landing.inside_mm >= 0.0;
            open.then_some((aim, landing.at[1]))
        };
        let mut behind = self.clone();
        behind.sensor.centre[2] += step;
        let pupil = self.view.pupil_mm;
        // Heights y and their growth m along the axis; rings have weights in proportion to their radius.
        let (mut along_m, mut whole) = (0.0, 0.0);
        for i in 0..RAYS {
            let aim = 1.1 * pupil * (i as f64 + 0.5) / RAYS as f64;
            if let (Some((_, near)), Some((_, far))) = (at(self, aim), at(&behind, aim)) {
                let (y, m) = (near - self.sensor.axis_px[1], (far - near) / step);
                along_m += aim * y * m;
                whole += aim * m * m;
            }
        }
        self.sensor.centre[2] -= along_m / whole;
    }

    /// Multiplies the dispersion of the glass behind a surface by `factor`; its index in green stays.
    pub(super) fn disperse(&mut self, surface: usize, factor: f64) {
        let index = &mut self.surfaces[surface].index;
        let green = index[GREEN];
        for value in index {
            *value = green + factor * (*value - green);
        }
    }
}
