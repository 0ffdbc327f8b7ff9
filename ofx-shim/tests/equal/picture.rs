//! Pictures as hosts keep them.

/// A picture: rows from the bottom up unless it is `turned`.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) bounds: [i32; 4],
    pub(crate) channels: i32,
    pub(crate) samples: Vec<f32>,
    pub(crate) turned: bool,
}

impl Picture {
    pub(crate) fn made(
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
            turned: false,
        }
    }

    pub(crate) fn at(&self, x: i32, y: i32, c: i32) -> f32 {
        let [x1, y1, x2, _] = self.bounds;
        self.samples[(((y - y1) * (x2 - x1) + x - x1) * self.channels + c) as usize]
    }

    /// Samples of a row.
    pub(crate) fn row(&self) -> usize {
        ((self.bounds[2] - self.bounds[0]) * self.channels) as usize
    }

    /// The same with its rows in memory from the top down.
    pub(crate) fn upside_down(mut self) -> Self {
        self.samples = self
            .samples
            .rchunks(self.row())
            .flatten()
            .copied()
            .collect();
        self.turned = !self.turned;
        self
    }
}
