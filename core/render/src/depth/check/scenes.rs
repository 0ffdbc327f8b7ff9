//! Synthetic scenes with exact depth: a floor, walls, boxes and balls before a sky, in perspective.

use seidel_optics::field::ImagePoint;
use seidel_optics::numeric::SplitMix64;

/// Columns and rows of synthetic passes.
pub(super) const SIZE: (usize, usize) = (320, 180);

/// A camera and the objects in front of it. World axes: x right, y down, z ahead; the camera is at the origin.
pub(super) struct TestScene {
    /// Focal length, px.
    pub focal_px: f64,
    /// World directions of the camera's axes.
    axes: [[f64; 3]; 3],
    /// Planes n . p = c with c > 0: the camera is on their inner side.
    planes: Vec<([f64; 3], f64)>,
    boxes: Vec<Block>,
    /// Centre and radius of each.
    balls: Vec<([f64; 3], f64)>,
}

/// A box rotated about the vertical.
struct Block {
    middle: [f64; 3],
    half: [f64; 3],
    cos: f64,
    sin: f64,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn between(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

impl TestScene {
    /// A random room or open ground with a half field of 12 to 42 degrees.
    pub(super) fn random(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let r = &mut random;
        let half_field = between(r, 12.0, 42.0).to_radians();
        let (pitch, roll) = (between(r, -0.1, 0.3), between(r, -0.05, 0.05));
        let size = between(r, 1.0, 3.0);
        let mut planes = vec![([0.0, 1.0, 0.0], between(r, 1.0, 2.0) * size)];
        if r.unit() < 0.5 {
            let turn = between(r, -0.6, 0.6);
            planes.push(([turn.sin(), 0.0, turn.cos()], between(r, 6.0, 15.0) * size));
            planes.push(([-1.0, 0.0, 0.1], between(r, 2.0, 5.0) * size));
        }
        let boxes = (0..3 + r.below(5))
            .map(|_| Block::random(r, size))
            .collect();
        let balls = (0..r.below(4))
            .map(|_| {
                let z = between(r, 4.0, 12.0) * size;
                let middle = [between(r, -0.5, 0.5) * z, between(r, -0.2, 0.2) * z, z];
                (middle, between(r, 0.2, 1.0) * size)
            })
            .collect();
        Self::new(half_field, pitch, roll, planes, boxes, balls)
    }

    /// Random balls before an empty background.
    pub(super) fn balls(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let r = &mut random;
        let balls = (0..5 + r.below(4))
            .map(|_| {
                let z = between(r, 4.0, 9.0);
                let middle = [between(r, -0.5, 0.5) * z, between(r, -0.3, 0.3) * z, z];
                (middle, between(r, 0.5, 1.5))
            })
            .collect();
        let half_field = between(r, 12.0, 42.0).to_radians();
        Self::new(half_field, 0.0, 0.0, Vec::new(), Vec::new(), balls)
    }

    fn new(
        half_field: f64,
        pitch: f64,
        roll: f64,
        planes: Vec<([f64; 3], f64)>,
        boxes: Vec<Block>,
        balls: Vec<([f64; 3], f64)>,
    ) -> Self {
        let (down, ahead) = (pitch.sin(), pitch.cos());
        let (cos, sin) = (roll.cos(), roll.sin());
        let (right, below) = ([1.0, 0.0, 0.0], [0.0, ahead, -down]);
        let turned = |a: f64, b: f64| std::array::from_fn(|k| a * right[k] + b * below[k]);
        Self {
            focal_px: SIZE.0 as f64 / 2.0 / half_field.tan(),
            axes: [turned(cos, sin), turned(-sin, cos), [0.0, down, ahead]],
            planes,
            boxes,
            balls,
        }
    }

    pub(super) fn axis() -> ImagePoint {
        ImagePoint::new(SIZE.0 as f64 / 2.0, SIZE.1 as f64 / 2.0)
    }

    /// Returns the length of the ray through an image point per unit along the axis.
    pub(super) fn ray_length(&self, x: f64, y: f64) -> f64 {
        let (x, y) = self.slopes(x, y);
        (1.0 + x * x + y * y).sqrt()
    }

    fn slopes(&self, x: f64, y: f64) -> (f64, f64) {
        let axis = Self::axis();
        (
            (x - axis.x_px) / self.focal_px,
            (y - axis.y_px) / self.focal_px,
        )
    }

    /// Returns the distance along the axis at image point (`x`, `y`); infinite on the background.
    pub(super) fn depth(&self, x: f64, y: f64) -> f64 {
        let (sx, sy) = self.slopes(x, y);
        let [right, below, ahead] = self.axes;
        let ray = std::array::from_fn(|k| sx * right[k] + sy * below[k] + ahead[k]);
        let planes = self.planes.iter().map(|(n, c)| c / dot(*n, ray));
        let boxes = self.boxes.iter().filter_map(|b| b.hit(ray));
        let balls = self.balls.iter().filter_map(|(m, radius)| {
            let (along, square) = (dot(*m, ray), dot(ray, ray));
            let rest = along * along - square * (dot(*m, *m) - radius * radius);
            (rest > 0.0).then(|| (along - rest.sqrt()) / square)
        });
        planes
            .chain(boxes)
            .chain(balls)
            .filter(|t| *t > 0.05 && *t < 2000.0)
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns `value` at every pixel centre.
    pub(super) fn pass<T>(&self, value: &dyn Fn(f64, f64) -> T) -> Vec<T> {
        let (width, height) = SIZE;
        (0..width * height)
            .map(|k| value((k % width) as f64 + 0.5, (k / width) as f64 + 0.5))
            .collect()
    }
}

impl Block {
    fn random(r: &mut SplitMix64, size: f64) -> Self {
        let z = between(r, 3.0, 14.0) * size;
        let turn = between(r, -0.8, 0.8);
        Self {
            middle: [between(r, -0.5, 0.5) * z, between(r, 0.0, 1.0) * size, z],
            half: std::array::from_fn(|_| between(r, 0.2, 1.2) * size),
            cos: turn.cos(),
            sin: turn.sin(),
        }
    }

    /// Returns how far along `ray` from the origin the box begins, by the slab method.
    fn hit(&self, ray: [f64; 3]) -> Option<f64> {
        let turned = |v: [f64; 3]| {
            [
                self.cos * v[0] + self.sin * v[2],
                v[1],
                self.cos * v[2] - self.sin * v[0],
            ]
        };
        let (ray, middle) = (turned(ray), turned(self.middle));
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let a = (middle[k] - self.half[k]) / ray[k];
            let b = (middle[k] + self.half[k]) / ray[k];
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near < far && near > 0.0).then_some(near)
    }
}
