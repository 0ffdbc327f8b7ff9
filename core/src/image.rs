//! An image: planes of samples as a file or a host has them.

use seidel_optics::error::{Error, Result};

use crate::finite::{ComputedPlane, first_non_finite};

/// An image of scene-linear samples in separate planes, row-major, all of one size.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    /// Names of the colours: R, G, B, or Y.
    pub names: Vec<String>,
    /// One plane each.
    pub colours: Vec<Vec<f32>>,
    /// Coverage, 0 to 1.
    pub alpha: Option<Vec<f32>>,
    /// Coverage seen by each colour alone, one plane a colour or none; only beside an `alpha`.
    pub channel_alphas: Vec<Vec<f32>>,
    /// Relation of colour and alpha.
    pub alpha_kind: AlphaKind,
}

/// Relation of colour and alpha.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AlphaKind {
    /// Colour is multiplied by alpha (associated alpha).
    #[default]
    Premultiplied,
    /// Colour is not multiplied by alpha.
    Unpremultiplied,
}

impl Image {
    /// Creates an image of `width` x `height` pixels whose `colours` have `names`, without alpha.
    ///
    /// # Errors
    /// An empty image, a plane that is not of that size, and a number of names that is not that of the planes.
    pub fn new(
        width: usize,
        height: usize,
        names: Vec<String>,
        colours: Vec<Vec<f32>>,
    ) -> Result<Self> {
        let image = Self::from_planes(width, height, names, colours);
        image.check_sizes()?;
        Ok(image)
    }

    /// Creates an image from interleaved samples: Y, YA, RGB or RGBA by the number of `channels`. Colour is premultiplied by
    /// alpha, unless [`Image::alpha_kind`] is changed.
    ///
    /// ```
    /// use seidel_core::Image;
    /// let rgb = Image::from_interleaved(2, 1, 3, &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6])?;
    /// assert_eq!(rgb.colours[1], [0.2, 0.5]);
    /// assert_eq!(rgb.to_interleaved(), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
    /// # Ok::<(), seidel_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// A number of channels other than 1 to 4, and a number of samples that is not `width * height * channels`.
    pub fn from_interleaved(
        width: usize,
        height: usize,
        channels: usize,
        samples: &[f32],
    ) -> Result<Self> {
        let names: &[&str] = match channels {
            1 | 2 => &["Y"],
            3 | 4 => &["R", "G", "B"],
            _ => {
                return Err(Error::new(
                    "channels",
                    format!("are {channels}"),
                    "give 1 (Y), 2 (YA), 3 (RGB) or 4 (RGBA)",
                ));
            }
        };
        let expected = width
            .checked_mul(height)
            .and_then(|n| n.checked_mul(channels));
        if expected != Some(samples.len()) {
            return Err(Error::new(
                "samples",
                format!("are {}", samples.len()),
                format!("give {width} x {height} x {channels}"),
            ));
        }
        let plane =
            |k: usize| -> Vec<f32> { samples.iter().skip(k).step_by(channels).copied().collect() };
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        let colours = (0..names.len()).map(plane).collect();
        let alpha = (channels > names.len()).then(|| plane(names.len()));
        Ok(Self {
            alpha,
            ..Self::new(width, height, names, colours)?
        })
    }

    /// An image whose planes are known to be of its size.
    pub(crate) fn from_planes(
        width: usize,
        height: usize,
        names: Vec<String>,
        colours: Vec<Vec<f32>>,
    ) -> Self {
        Self {
            width,
            height,
            names,
            colours,
            ..Self::default()
        }
    }

    /// The same image with `alpha`, the alphas of single colours (one each, or none), and their relation to colour.
    #[must_use]
    pub fn with_alpha(
        mut self,
        alpha: Option<Vec<f32>>,
        channel_alphas: Vec<Vec<f32>>,
        kind: AlphaKind,
    ) -> Self {
        self.alpha = alpha;
        self.channel_alphas = channel_alphas;
        self.alpha_kind = kind;
        self
    }

    /// Returns the samples interleaved: the colours of a pixel, then its alpha.
    pub fn to_interleaved(&self) -> Vec<f32> {
        let planes: Vec<&Vec<f32>> = self.colours.iter().chain(&self.alpha).collect();
        (0..self.width * self.height)
            .flat_map(|at| planes.iter().map(move |plane| plane[at]))
            .collect()
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Replaces samples that are not finite by zero; returns their number.
    pub fn replace_non_finite(&mut self) -> usize {
        let mut count = 0;
        for sample in self.planes_mut().flatten().filter(|v| !v.is_finite()) {
            *sample = 0.0;
            count += 1;
        }
        count
    }

    /// Checks that planes are of the size of the image, and alphas where they belong.
    ///
    /// # Errors
    /// The first plane that is not, by its name.
    pub fn check_sizes(&self) -> Result<()> {
        let pixels = self.width * self.height;
        if pixels == 0 || self.names.len() != self.colours.len() {
            return Err(Error::new(
                "image",
                format!(
                    "is {} x {} with {} planes of {} names",
                    self.width,
                    self.height,
                    self.colours.len(),
                    self.names.len()
                ),
                "give at least one pixel, and a name for each colour",
            ));
        }
        let own = self.channel_alphas.len();
        if own != 0 && (self.alpha.is_none() || own != self.colours.len()) {
            return Err(Error::new(
                "channel_alphas",
                format!("are {own}"),
                "give one for each colour beside an alpha, or none",
            ));
        }
        for (name, plane) in self.named_planes() {
            if plane.len() != pixels {
                return Err(Error::new(
                    format!("channel {name}"),
                    format!("has {} samples", plane.len()),
                    format!("give {} x {}", self.width, self.height),
                ));
            }
        }
        Ok(())
    }

    /// Checks that all samples are finite.
    ///
    /// # Errors
    /// The first sample that is not, by channel and pixel.
    pub fn check_finite(&self) -> Result<()> {
        for (name, plane) in self.named_planes() {
            if let Some(at) = first_non_finite(plane) {
                return Err(Error::new(
                    format!(
                        "channel {name}, pixel ({}, {})",
                        at % self.width,
                        at / self.width
                    ),
                    format!("is {}", plane[at]),
                    "give finite samples, or replace these with Image::replace_non_finite",
                ));
            }
        }
        Ok(())
    }

    /// Returns a copy, after both checks: the result of a lens without blur.
    pub(crate) fn checked_copy(&self) -> Result<Self> {
        self.check_sizes()?;
        self.check_finite()?;
        Ok(self.clone())
    }

    /// Checks that all samples of a computed image are finite.
    ///
    /// # Errors
    /// The first sample that is not, by channel and pixel: `first` is the column and row of the first one on the plate.
    pub(crate) fn check_computed(&self, first: [i64; 2]) -> Result<()> {
        self.named_planes().try_for_each(|(name, samples)| {
            let plane = ComputedPlane {
                name: format!("channel {name}"),
                samples,
                width: self.width,
                first,
            };
            plane.check()
        })
    }

    /// Planes and their names: colours, `A`, then `alpha.R` and so on.
    pub(crate) fn named_planes(&self) -> impl Iterator<Item = (String, &Vec<f32>)> {
        let colours = self.names.iter().cloned().zip(&self.colours);
        let alpha = self.alpha.iter().map(|plane| ("A".to_owned(), plane));
        let own = self.names.iter().zip(&self.channel_alphas);
        colours
            .chain(alpha)
            .chain(own.map(|(name, plane)| (format!("alpha.{name}"), plane)))
    }

    fn planes_mut(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        self.colours
            .iter_mut()
            .chain(&mut self.alpha)
            .chain(&mut self.channel_alphas)
    }
}
