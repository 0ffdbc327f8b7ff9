//! Pictures in a host's memory.

/// A picture of float samples, its rows from the bottom up in memory unless `is_top_down`.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) bounds: [i32; 4],
    pub(crate) channels: i32,
    pub(crate) samples: Vec<f32>,
    pub(crate) is_top_down: bool,
}

impl Picture {
    /// Makes a picture from the sample at (x, y, channel).
    pub(crate) fn new(
        bounds: [i32; 4],
        channels: i32,
        sample: impl Fn(i32, i32, i32) -> f32,
    ) -> Self {
        let [x1, y1, x2, y2] = bounds;
        let pixels = (y1..y2).flat_map(|y| (x1..x2).map(move |x| (x, y)));
        let samples = pixels.flat_map(|(x, y)| (0..channels).map(move |c| (x, y, c)));
        Self {
            bounds,
            channels,
            samples: samples.map(|(x, y, c)| sample(x, y, c)).collect(),
            is_top_down: false,
        }
    }

    pub(crate) fn at(&self, x: i32, y: i32, c: i32) -> f32 {
        let [x1, y1, x2, _] = self.bounds;
        self.samples[(((y - y1) * (x2 - x1) + x - x1) * self.channels + c) as usize]
    }

    /// Asserts that the samples are those of `expected`, bit for bit, in a case called `name`.
    #[track_caller]
    pub(crate) fn assert_same(&self, expected: &Self, name: &str) {
        assert_eq!(self.bounds, expected.bounds, "{name}");
        let pairs = self.samples.iter().zip(&expected.samples);
        let different = pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(different, 0, "{name}: number of different samples");
    }

    /// Returns the largest difference of a sample from that of `other`.
    pub(crate) fn max_difference(&self, other: &Self) -> f32 {
        let pairs = self.samples.iter().zip(&other.samples);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    /// Returns the number of samples per row.
    pub(crate) fn row_samples(&self) -> usize {
        ((self.bounds[2] - self.bounds[0]) * self.channels) as usize
    }

    /// Reverses the order of rows in memory; the picture stays the same.
    pub(crate) fn with_reversed_rows(mut self) -> Self {
        self.samples = self
            .samples
            .rchunks(self.row_samples())
            .flatten()
            .copied()
            .collect();
        self.is_top_down = !self.is_top_down;
        self
    }
}
