//! Float images, and regions in pixels and in canonical coordinates.

/// A rectangle of pixels, y up. `x2` and `y2` are exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Left.
    pub x1: i32,
    /// Bottom.
    pub y1: i32,
    /// Right, exclusive.
    pub x2: i32,
    /// Top, exclusive.
    pub y2: i32,
}

impl Rect {
    /// Creates a rectangle from its corners.
    #[must_use]
    pub const fn new(x1: i32, y1: i32, x2: i32, y2: i32) -> Self {
        Self { x1, y1, x2, y2 }
    }

    /// Returns the number of columns; 0 if it is empty.
    #[must_use]
    pub fn width(&self) -> usize {
        usize::try_from(i64::from(self.x2) - i64::from(self.x1)).unwrap_or(0)
    }

    /// Returns the number of rows; 0 if it is empty.
    #[must_use]
    pub fn height(&self) -> usize {
        usize::try_from(i64::from(self.y2) - i64::from(self.y1)).unwrap_or(0)
    }

    /// Returns whether it contains no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.width() == 0 || self.height() == 0
    }

    /// Returns whether it contains the pixel.
    #[must_use]
    pub fn contains(&self, x: i32, y: i32) -> bool {
        (self.x1..self.x2).contains(&x) && (self.y1..self.y2).contains(&y)
    }

    /// Returns the intersection. If it is empty, it lies at the lower left corner of `self`.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let both = Self::new(
            self.x1.max(other.x1),
            self.y1.max(other.y1),
            self.x2.min(other.x2),
            self.y2.min(other.y2),
        );
        if both.is_empty() {
            Self::new(self.x1, self.y1, self.x1, self.y1)
        } else {
            both
        }
    }

    /// Returns the smallest rectangle that contains both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        if self.is_empty() {
            return *other;
        }
        if other.is_empty() {
            return *self;
        }
        Self::new(
            self.x1.min(other.x1),
            self.y1.min(other.y1),
            self.x2.max(other.x2),
            self.y2.max(other.y2),
        )
    }

    /// Translates it by `(dx, dy)`.
    #[must_use]
    pub fn translated(&self, dx: i32, dy: i32) -> Self {
        Self::new(self.x1 + dx, self.y1 + dy, self.x2 + dx, self.y2 + dy)
    }

    /// Expands it by `margin` on every side; negative margins shrink it.
    #[must_use]
    pub fn expanded(&self, margin: i32) -> Self {
        Self::new(
            self.x1 - margin,
            self.y1 - margin,
            self.x2 + margin,
            self.y2 + margin,
        )
    }

    /// Returns x1, y1, x2, y2, as in properties.
    #[must_use]
    pub fn corners(&self) -> [i32; 4] {
        [self.x1, self.y1, self.x2, self.y2]
    }

    /// Iterates over its pixels, row by row from the bottom.
    pub fn pixels(self) -> impl Iterator<Item = (i32, i32)> {
        (self.y1..self.y2).flat_map(move |y| (self.x1..self.x2).map(move |x| (x, y)))
    }
}

/// A rectangle in canonical coordinates: square pixels at full resolution, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Left.
    pub x1: f64,
    /// Bottom.
    pub y1: f64,
    /// Right.
    pub x2: f64,
    /// Top.
    pub y2: f64,
}

impl Region {
    /// Creates a rectangle from its corners.
    #[must_use]
    pub const fn new(x1: f64, y1: f64, x2: f64, y2: f64) -> Self {
        Self { x1, y1, x2, y2 }
    }

    /// Returns the region of `pixels` at a render scale (x, y) and pixel aspect ratio.
    #[must_use]
    pub fn from_pixels(pixels: &Rect, scale: (f64, f64), par: f64) -> Self {
        let [x1, y1, x2, y2] = pixels.corners().map(f64::from);
        let (width, height) = (par / scale.0, 1.0 / scale.1);
        Self::new(x1 * width, y1 * height, x2 * width, y2 * height)
    }

    /// Returns the region with the sides of `project` in place of those that are infinitely far away, as of a generator.
    #[must_use]
    pub fn or_project(&self, project: &Self) -> Self {
        let side = |own: f64, of_project: f64| {
            if own.abs() < Self::FARTHEST {
                own
            } else {
                of_project
            }
        };
        Self::new(
            side(self.x1, project.x1),
            side(self.y1, project.y1),
            side(self.x2, project.x2),
            side(self.y2, project.y2),
        )
    }

    /// Coordinate from which sides count as infinitely far away: no picture of a check is as large.
    const FARTHEST: f64 = 1e6;

    /// Returns the pixels that it touches, at a render scale (x, y) and pixel aspect ratio.
    #[must_use]
    pub fn pixels(&self, scale: (f64, f64), par: f64) -> Rect {
        // The tolerance absorbs rounding errors at pixel boundaries.
        let floor = |v: f64| (v + 1e-6).floor().clamp(-1e9, 1e9) as i32;
        let ceil = |v: f64| (v - 1e-6).ceil().clamp(-1e9, 1e9) as i32;
        Rect::new(
            floor(self.x1 * scale.0 / par),
            floor(self.y1 * scale.1),
            ceil(self.x2 * scale.0 / par),
            ceil(self.y2 * scale.1),
        )
    }

    /// Returns x1, y1, x2, y2, as in properties.
    #[must_use]
    pub fn corners(&self) -> [f64; 4] {
        [self.x1, self.y1, self.x2, self.y2]
    }
}

/// A float image with interleaved channels, row by row from the bottom.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Its pixels.
    pub bounds: Rect,
    /// Channels per pixel.
    pub channels: usize,
    /// Its samples.
    pub samples: Vec<f32>,
}

impl Picture {
    /// Creates a picture from a function of x, y and channel.
    pub fn from_fn(bounds: Rect, channels: usize, sample: impl Fn(i32, i32, usize) -> f32) -> Self {
        let mut samples = Vec::with_capacity(bounds.width() * bounds.height() * channels);
        for (x, y) in bounds.pixels() {
            samples.extend((0..channels).map(|c| sample(x, y, c)));
        }
        Self {
            bounds,
            channels,
            samples,
        }
    }

    /// Creates a picture with one value everywhere.
    #[must_use]
    pub fn constant(bounds: Rect, channels: usize, value: f32) -> Self {
        Self::from_fn(bounds, channels, |_, _, _| value)
    }

    /// Returns the index of the first sample of a pixel, or nothing outside the bounds.
    #[must_use]
    pub fn index(&self, x: i32, y: i32) -> Option<usize> {
        self.bounds.contains(x, y).then(|| {
            let column = (x - self.bounds.x1) as usize;
            let row = (y - self.bounds.y1) as usize;
            (row * self.bounds.width() + column) * self.channels
        })
    }

    /// Returns the samples of a pixel; none outside the bounds.
    #[must_use]
    pub fn pixel(&self, x: i32, y: i32) -> &[f32] {
        self.index(x, y)
            .map_or(&[], |i| &self.samples[i..i + self.channels])
    }

    /// Translates it by `(dx, dy)`.
    #[must_use]
    pub fn translated(&self, dx: i32, dy: i32) -> Self {
        Self {
            bounds: self.bounds.translated(dx, dy),
            channels: self.channels,
            samples: self.samples.clone(),
        }
    }

    /// Downsamples it by means of two by two pixels. Its bounds must be even.
    #[must_use]
    pub fn half_scale(&self) -> Self {
        let b = self.bounds;
        let half = Rect::new(b.x1 / 2, b.y1 / 2, b.x2 / 2, b.y2 / 2);
        Self::from_fn(half, self.channels, |x, y, c| {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let sum: f32 = four
                .iter()
                .filter_map(|(i, j)| self.pixel(2 * x + i, 2 * y + j).get(c))
                .sum();
            sum / 4.0
        })
    }

    /// Describes how many pixels in `within` differ in any bit, and the first of them; nothing if none does.
    #[must_use]
    pub fn difference(&self, other: &Self, within: Rect) -> Option<String> {
        self.compare(other, within, |a, b| a.to_bits() == b.to_bits())
    }

    /// Like [`Self::difference`], but samples may differ by up to `tolerance`.
    #[must_use]
    pub fn difference_beyond(&self, other: &Self, within: Rect, tolerance: f32) -> Option<String> {
        self.compare(other, within, |a, b| (a - b).abs() <= tolerance)
    }

    fn compare(
        &self,
        other: &Self,
        within: Rect,
        is_same: impl Fn(f32, f32) -> bool,
    ) -> Option<String> {
        if self.channels != other.channels {
            return Some(format!(
                "{} channels against {}",
                self.channels, other.channels
            ));
        }
        let mut first = None;
        let mut count = 0_usize;
        for (x, y) in within.pixels() {
            let (a, b) = (self.pixel(x, y), other.pixel(x, y));
            if a.len() != b.len() || !a.iter().zip(b).all(|(a, b)| is_same(*a, *b)) {
                count += 1;
                if first.is_none() {
                    first = Some(format!("at ({x}, {y}) {a:?} against {b:?}"));
                }
            }
        }
        first.map(|text| {
            let all = within.width() * within.height();
            format!("{count} of {all} pixels differ, the first {text}")
        })
    }
}

/// Returns a number from 0 to 1: an integer hash of the arguments.
#[must_use]
pub fn noise(x: i32, y: i32, c: usize, seed: u32) -> f32 {
    let mut v = (x as u32)
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add((y as u32).wrapping_mul(0x85eb_ca6b))
        .wrapping_add((c as u32).wrapping_mul(0xc2b2_ae35))
        .wrapping_add(seed.wrapping_mul(0x27d4_eb2f));
    v ^= v >> 15;
    v = v.wrapping_mul(0x2c1b_3c6d);
    v ^= v >> 12;
    v = v.wrapping_mul(0x297a_2d39);
    v ^= v >> 15;
    (v >> 8) as f32 / 16_777_216.0
}

/// Returns a test image of noise, a gradient and a few highlights, premultiplied by a varying alpha unless it has three
/// channels.
#[must_use]
pub fn plate(bounds: Rect, channels: usize, seed: u32) -> Picture {
    Picture::from_fn(bounds, channels, |x, y, c| {
        let (u, v) = (x - bounds.x1, y - bounds.y1);
        let alpha = if channels == 3 {
            1.0
        } else {
            0.5 + 0.5 * noise(u / 5, v / 5, 7, seed)
        };
        if channels != 3 && c + 1 == channels {
            return alpha;
        }
        let gradient =
            0.1 + 0.3 * (u + 2 * v) as f32 / (bounds.width() + 2 * bounds.height()) as f32;
        let highlight = if noise(u, v, 9, seed) > 0.985 {
            6.0
        } else {
            0.0
        };
        alpha * (gradient + 0.4 * noise(u, v, c, seed) + highlight)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinite_regions_end_with_the_project() {
        let project = Region::new(0.0, 0.0, 45.0, 37.0);
        let infinite = Region::new(-2147483648.0, 5.0, f64::INFINITY, f64::NAN);
        let finite = infinite.or_project(&project);
        assert_eq!(finite, Region::new(0.0, 5.0, 45.0, 37.0));
        assert_eq!(project.or_project(&finite), project);
    }

    #[test]
    fn pixels_of_regions_round_trip() {
        let pixels = Rect::new(-3, 2, 7, 9);
        for (scale, par) in [
            ((1.0, 1.0), 1.0),
            ((0.5, 0.5), 2.0),
            ((0.5, 0.25), 1.0 / 3.0),
        ] {
            assert_eq!(
                Region::from_pixels(&pixels, scale, par).pixels(scale, par),
                pixels
            );
        }
        assert_eq!(
            Region::new(0.2, 0.0, 3.1, 4.0).pixels((1.0, 1.0), 1.0),
            Rect::new(0, 0, 4, 4)
        );
    }

    #[test]
    fn differences_of_one_bit_are_counted() {
        let bounds = Rect::new(0, 0, 4, 3);
        let a = plate(bounds, 4, 1);
        let mut b = a.clone();
        assert_eq!(a.difference(&b, bounds), None);
        let index = b.index(2, 1).expect("inside");
        b.samples[index] = f32::from_bits(b.samples[index].to_bits() + 1);
        assert!(
            a.difference(&b, bounds)
                .is_some_and(|text| text.starts_with("1 of 12"))
        );
        assert_eq!(a.difference_beyond(&b, bounds, 1e-3), None);
        assert_eq!(a.difference(&b, Rect::new(0, 0, 2, 3)), None);
    }

    #[test]
    fn half_scale_averages_two_by_two_pixels() {
        let full = Picture::from_fn(Rect::new(-2, 0, 2, 2), 1, |x, _, _| x as f32);
        assert_eq!(full.half_scale().samples, [-1.5, 0.5]);
        assert_eq!(full.half_scale().bounds, Rect::new(-1, 0, 1, 1));
    }
}
