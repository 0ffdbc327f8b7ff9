//! Coverage above one, which no view has, taken back to one.

use rayon::prelude::*;

use crate::planes::PremultipliedPlanes;

impl PremultipliedPlanes {
    /// Divides each pixel of `blurred`, these planes after blur, by its alpha where that is above one; an alpha of a single colour divides
    /// that colour alone.
    ///
    /// Colour and alpha keep their ratio. Planes whose own alpha is outside 0 to 1 stay as they are.
    pub(crate) fn limit_coverage(&self, blurred: &mut [Vec<f32>]) {
        let is_coverage = |plane: &Vec<f32>| plane.par_iter().all(|a| (0.0..=1.0).contains(a));
        if !self.planes()[self.colour_count()..].iter().all(is_coverage) {
            return;
        }
        let (colours, alphas) = blurred.split_at_mut(self.colour_count());
        match alphas {
            [] => {}
            [alpha] => {
                for colour in colours {
                    divide(colour, alpha);
                }
                limit(alpha);
            }
            [alpha, own @ ..] => {
                limit(alpha);
                for (colour, own) in colours.iter_mut().zip(own) {
                    divide(colour, own);
                    limit(own);
                }
            }
        }
    }
}

/// Divides a colour by its alpha where that is above one.
fn divide(colour: &mut [f32], alpha: &[f32]) {
    let pixels = colour.par_iter_mut().zip(alpha);
    pixels.for_each(|(sample, alpha)| *sample /= alpha.max(1.0));
}

fn limit(alpha: &mut [f32]) {
    alpha.par_iter_mut().for_each(|a| *a = a.min(1.0));
}

#[cfg(test)]
mod tests {
    use crate::planes::PremultipliedPlanes;
    use crate::{AlphaKind, Image};

    fn planes(alpha: [f32; 3]) -> PremultipliedPlanes {
        let image = Image::from_interleaved(3, 1, 3, &[0.5; 9]).expect("an image");
        let image = image.with_alpha(Some(alpha.to_vec()), Vec::new(), AlphaKind::Premultiplied);
        PremultipliedPlanes::new(image).expect("planes")
    }

    #[test]
    fn coverage_above_one_is_divided_out_of_colour_and_alpha() {
        let mut blurred = vec![vec![0.6, 0.5, 2.0]; 3];
        blurred.push(vec![1.25, 1.0, 0.5]);
        let mut limited = blurred.clone();
        planes([1.0, 1.0, 0.0]).limit_coverage(&mut limited);
        for colour in &limited[..3] {
            assert_eq!(colour, &[0.6 / 1.25, 0.5, 2.0]);
        }
        assert_eq!(limited[3], [1.0, 1.0, 0.5]);
        let mut kept = blurred.clone();
        planes([1.0, 1.5, 0.0]).limit_coverage(&mut kept);
        assert_eq!(kept, blurred);
    }
}
