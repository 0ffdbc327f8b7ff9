//! Pictures as numbers, and the rectangles of pixels they fill.

/// A rectangle of pixels, `x2` and `y2` being the first outside, y up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Left.
    pub x1: i32,
    /// Bottom.
    pub y1: i32,
    /// First column to the right of it.
    pub x2: i32,
    /// First row above it.
    pub y2: i32,
}

impl Rect {
    /// From its corners.
    #[must_use]
    pub const fn new(x1: i32, y1: i32, x2: i32, y2: i32) -> Self {
        Self { x1, y1, x2, y2 }
    }

    /// Columns, none if it is empty.
    #[must_use]
    pub fn width(&self) -> usize {
        usize::try_from(i64::from(self.x2) - i64::from(self.x1)).unwrap_or(0)
    }

    /// Rows, none if it is empty.
    #[must_use]
    pub fn height(&self) -> usize {
        usize::try_from(i64::from(self.y2) - i64::from(self.y1)).unwrap_or(0)
    }

    /// Whether no pixel is in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.width() == 0 || self.height() == 0
    }

    /// Whether the pixel is in it.
    #[must_use]
    pub fn contains(&self, x: i32, y: i32) -> bool {
        (self.x1..self.x2).contains(&x) && (self.y1..self.y2).contains(&y)
    }

    /// What is in both; empty at `self`'s corner if nothing is.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
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

    /// Moved by `(dx, dy)`.
    #[must_use]
    pub fn moved(&self, dx: i32, dy: i32) -> Self {
        Self::new(self.x1 + dx, self.y1 + dy, self.x2 + dx, self.y2 + dy)
    }

    /// Grown by `by` on every side.
    #[must_use]
    pub fn grown(&self, by: i32) -> Self {
        Self::new(self.x1 - by, self.y1 - by, self.x2 + by, self.y2 + by)
    }

    /// The four coordinates, as properties hold them.
    #[must_use]
    pub fn corners(&self) -> [i32; 4] {
        [self.x1, self.y1, self.x2, self.y2]
    }

    /// Every pixel, row by row from the bottom.
    pub fn pixels(self) -> impl Iterator<Item = (i32, i32)> {
        (self.y1..self.y2).flat_map(move |y| (self.x1..self.x2).map(move |x| (x, y)))
    }
}

/// A rectangle in canonical coordinates: square pixels at full size, y up.
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
    /// From its corners.
    #[must_use]
    pub const fn new(x1: f64, y1: f64, x2: f64, y2: f64) -> Self {
        Self { x1, y1, x2, y2 }
    }

    /// What `pixels` cover where a pixel is `par / scale` wide and `1 / scale` high.
    #[must_use]
    pub fn of(pixels: &Rect, scale: (f64, f64), par: f64) -> Self {
        let [x1, y1, x2, y2] = pixels.corners().map(f64::from);
        let (wide, high) = (par / scale.0, 1.0 / scale.1);
        Self::new(x1 * wide, y1 * high, x2 * wide, y2 * high)
    }

    /// All pixels that it touches.
    #[must_use]
    pub fn pixels(&self, scale: (f64, f64), par: f64) -> Rect {
        // What is a whole number but for rounding is that number.
        let down = |v: f64| (v + 1e-6).floor().clamp(-1e9, 1e9) as i32;
        let up = |v: f64| (v - 1e-6).ceil().clamp(-1e9, 1e9) as i32;
        Rect::new(
            down(self.x1 * scale.0 / par),
            down(self.y1 * scale.1),
            up(self.x2 * scale.0 / par),
            up(self.y2 * scale.1),
        )
    }

    /// The four coordinates, as properties hold them.
    #[must_use]
    pub fn corners(&self) -> [f64; 4] {
        [self.x1, self.y1, self.x2, self.y2]
    }

    /// Whether all of `other` is in it, up to rounding.
    #[must_use]
    pub fn covers(&self, other: &Self) -> bool {
        let slack = 1e-6;
        self.x1 <= other.x1 + slack
            && self.y1 <= other.y1 + slack
            && self.x2 >= other.x2 - slack
            && self.y2 >= other.y2 - slack
    }
}

/// Samples of a rectangle of pixels, row by row from the bottom, the channels of a pixel together.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The pixels.
    pub bounds: Rect,
    /// Samples of a pixel.
    pub channels: usize,
    /// The samples.
    pub samples: Vec<f32>,
}

impl Picture {
    /// A picture whose samples `of` gives by x, y and channel.
    pub fn made(bounds: Rect, channels: usize, of: impl Fn(i32, i32, usize) -> f32) -> Self {
        let mut samples = Vec::with_capacity(bounds.width() * bounds.height() * channels);
        for (x, y) in bounds.pixels() {
            samples.extend((0..channels).map(|c| of(x, y, c)));
        }
        Self {
            bounds,
            channels,
            samples,
        }
    }

    /// All samples alike.
    #[must_use]
    pub fn flat(bounds: Rect, channels: usize, value: f32) -> Self {
        Self::made(bounds, channels, |_, _, _| value)
    }

    /// Where the samples of a pixel begin, nothing outside.
    #[must_use]
    pub fn at(&self, x: i32, y: i32) -> Option<usize> {
        self.bounds.contains(x, y).then(|| {
            let column = (x - self.bounds.x1) as usize;
            let row = (y - self.bounds.y1) as usize;
            (row * self.bounds.width() + column) * self.channels
        })
    }

    /// The samples of a pixel, none outside.
    #[must_use]
    pub fn pixel(&self, x: i32, y: i32) -> &[f32] {
        self.at(x, y)
            .map_or(&[], |at| &self.samples[at..at + self.channels])
    }

    /// The part of it in `bounds`, 0 outside it.
    #[must_use]
    pub fn cut(&self, bounds: Rect) -> Self {
        Self::made(bounds, self.channels, |x, y, c| {
            self.pixel(x, y).get(c).copied().unwrap_or(0.0)
        })
    }

    /// The same samples elsewhere.
    #[must_use]
    pub fn moved(&self, dx: i32, dy: i32) -> Self {
        Self {
            bounds: self.bounds.moved(dx, dy),
            channels: self.channels,
            samples: self.samples.clone(),
        }
    }

    /// Means of two by two pixels: the picture at half scale. Its bounds must be even.
    #[must_use]
    pub fn halved(&self) -> Self {
        let b = self.bounds;
        let half = Rect::new(b.x1 / 2, b.y1 / 2, b.x2 / 2, b.y2 / 2);
        Self::made(half, self.channels, |x, y, c| {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let sum: f32 = four
                .iter()
                .filter_map(|(i, j)| self.pixel(2 * x + i, 2 * y + j).get(c))
                .sum();
            sum / 4.0
        })
    }

    /// The first pixel of `within` where the two differ in any bit, and how many do; nothing if none does.
    #[must_use]
    pub fn difference(&self, other: &Self, within: Rect) -> Option<String> {
        self.compared(other, within, |a, b| a.to_bits() == b.to_bits())
    }

    /// As `difference`, but samples may differ by `tolerance`.
    #[must_use]
    pub fn difference_over(&self, other: &Self, within: Rect, tolerance: f32) -> Option<String> {
        self.compared(other, within, |a, b| (a - b).abs() <= tolerance)
    }

    fn compared(
        &self,
        other: &Self,
        within: Rect,
        same: impl Fn(f32, f32) -> bool,
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
            if a.len() != b.len() || !a.iter().zip(b).all(|(a, b)| same(*a, *b)) {
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

    /// The largest difference of any sample in `within`.
    #[must_use]
    pub fn largest_difference(&self, other: &Self, within: Rect) -> f32 {
        (within.pixels())
            .flat_map(|(x, y)| self.pixel(x, y).iter().zip(other.pixel(x, y)))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max)
    }
}

/// A number from 0 to 1 that depends on nothing but its arguments.
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

/// A plate of detail, slopes and a few bright points, premultiplied by an alpha that varies where there is one.
#[must_use]
pub fn plate(bounds: Rect, channels: usize, seed: u32) -> Picture {
    Picture::made(bounds, channels, |x, y, c| {
        let (u, v) = (x - bounds.x1, y - bounds.y1);
        let alpha = if channels == 3 {
            1.0
        } else {
            0.5 + 0.5 * noise(u / 5, v / 5, 7, seed)
        };
        if channels != 3 && c + 1 == channels {
            return alpha;
        }
        let slope = 0.1 + 0.3 * (u + 2 * v) as f32 / (bounds.width() + 2 * bounds.height()) as f32;
        let bright = if noise(u, v, 9, seed) > 0.985 {
            6.0
        } else {
            0.0
        };
        alpha * (slope + 0.4 * noise(u, v, c, seed) + bright)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_and_pixels_agree() {
        let pixels = Rect::new(-3, 2, 7, 9);
        for (scale, par) in [
            ((1.0, 1.0), 1.0),
            ((0.5, 0.5), 2.0),
            ((0.5, 0.25), 1.0 / 3.0),
        ] {
            assert_eq!(Region::of(&pixels, scale, par).pixels(scale, par), pixels);
        }
        assert_eq!(
            Region::new(0.2, 0.0, 3.1, 4.0).pixels((1.0, 1.0), 1.0),
            Rect::new(0, 0, 4, 4)
        );
    }

    #[test]
    fn differences_are_counted_to_the_bit() {
        let bounds = Rect::new(0, 0, 4, 3);
        let a = plate(bounds, 4, 1);
        let mut b = a.clone();
        assert_eq!(a.difference(&b, bounds), None);
        let at = b.at(2, 1).expect("inside");
        b.samples[at] = f32::from_bits(b.samples[at].to_bits() + 1);
        assert!(
            a.difference(&b, bounds)
                .is_some_and(|text| text.starts_with("1 of 12"))
        );
        assert_eq!(a.difference_over(&b, bounds, 1e-3), None);
        assert_eq!(a.difference(&b, Rect::new(0, 0, 2, 3)), None);
    }

    #[test]
    fn half_scale_takes_means() {
        let full = Picture::made(Rect::new(-2, 0, 2, 2), 1, |x, _, _| x as f32);
        assert_eq!(full.halved().samples, [-1.5, 0.5]);
        assert_eq!(full.halved().bounds, Rect::new(-1, 0, 1, 1));
    }
}
