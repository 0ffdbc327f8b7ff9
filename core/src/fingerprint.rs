//! The fingerprint of a plate and its lens: a hash of everything that results depend on.

use std::hash::{DefaultHasher, Hash, Hasher};

use crate::image::Image;
use crate::plate::{Depth, Plate};
use crate::session::LensSession;

impl LensSession {
    /// Returns a hash of everything that the results of `plate` through this lens depend on: lens, settings, and the plate with its
    /// geometry, depth, holdout, mask and background. It is the same in one version of the library only.
    ///
    /// It is of the plate as given, before it is [prepared](Self::prepare): a caller that has the result of the same fingerprint need
    /// not prepare it.
    pub fn fingerprint(&self, plate: &Plate) -> u64 {
        let Plate {
            image,
            geometry,
            depth,
            holdout,
            mask,
            background,
        } = plate;
        let mut hasher = DefaultHasher::new();
        // The text forms name every field, so that a new one is never forgotten.
        self.lens().to_json().hash(&mut hasher);
        // JSON lacks the samples of aperture pictures.
        let channels = self.lens().profile().pupil_channels().iter();
        let pictures: Vec<_> = channels.map(|channel| &channel.picture).collect();
        format!("{pictures:?}").hash(&mut hasher);
        format!("{:?} {geometry:?}", self.settings()).hash(&mut hasher);
        hash_image(image, &mut hasher);
        hash_depth(depth, &mut hasher);
        if let Some(holdout) = holdout {
            "holdout".hash(&mut hasher);
            hash_planes([holdout.samples.as_slice()], &mut hasher);
            if let Some(pass) = &holdout.depth {
                format!("{:?}", pass.meaning).hash(&mut hasher);
                hash_planes([pass.samples.as_slice()], &mut hasher);
            }
        }
        if let Some(mask) = mask {
            "mask".hash(&mut hasher);
            hash_planes([mask.as_slice()], &mut hasher);
        }
        if let Some(background) = background {
            "background".hash(&mut hasher);
            hash_image(&background.image, &mut hasher);
            hash_depth(&background.depth, &mut hasher);
        }
        hasher.finish()
    }
}

fn hash_image(image: &Image, hasher: &mut DefaultHasher) {
    let layout = (&image.names, image.alpha.is_some(), image.alpha_kind);
    format!("{} x {} {layout:?}", image.width(), image.height()).hash(hasher);
    let planes = (image.colours.iter())
        .chain(&image.alpha)
        .chain(&image.channel_alphas);
    hash_planes(planes.map(Vec::as_slice), hasher);
}

fn hash_depth(depth: &Depth, hasher: &mut DefaultHasher) {
    match depth {
        Depth::Distance(distance) => format!("{distance:?}").hash(hasher),
        Depth::Pass(pass) => {
            format!("{:?}", pass.meaning).hash(hasher);
            hash_planes([pass.samples.as_slice()], hasher);
        }
    }
}

/// Hashes the number of samples of each plane, and their bits.
fn hash_planes<'a>(planes: impl IntoIterator<Item = &'a [f32]>, hasher: &mut DefaultHasher) {
    for plane in planes {
        plane.len().hash(hasher);
        let (blocks, rest) = plane.as_chunks::<BLOCK>();
        // The standard hasher takes a twentieth of a second for a plate of HD; sums of products, a tenth of that.
        let mut sums = FACTORS;
        for block in blocks {
            for ((sum, factor), [first, second]) in
                (sums.iter_mut().zip(FACTORS)).zip(block.as_chunks::<2>().0)
            {
                let pair = u64::from(first.to_bits()) << 32 | u64::from(second.to_bits());
                *sum = folded_product(*sum ^ pair, factor);
            }
        }
        sums.hash(hasher);
        for sample in rest {
            hasher.write_u32(sample.to_bits());
        }
    }
}

/// Samples that are hashed at once, two for each of [`FACTORS`].
const BLOCK: usize = 2 * FACTORS.len();

/// Odd factors with as many ones as zeros: digits of pi, e, and the square roots of 2 and 3.
const FACTORS: [u64; 4] = [
    0x243f_6a88_85a3_08d3,
    0xadf8_5458_a2bb_4a9b,
    0x6a09_e667_f3bc_c909,
    0xbb67_ae85_84ca_a73b,
];

/// Returns the upper half of a product combined with the lower one, in which every bit of the value counts.
fn folded_product(value: u64, factor: u64) -> u64 {
    let product = u128::from(value) * u128::from(factor);
    (product as u64) ^ (product >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(plane: &[f32]) -> u64 {
        let mut hasher = DefaultHasher::new();
        hash_planes([plane], &mut hasher);
        hasher.finish()
    }

    #[test]
    fn lenses_with_other_pictures_have_other_fingerprints() {
        let lens = crate::Lens::from_json(include_str!("../tests/data/lens.json")).expect("a lens");
        let plate = Plate::new(Image::from_interleaved(1, 1, 1, &[1.0]).expect("an image"));
        let of_picture = |transmission: f32| {
            let picture = crate::AperturePicture::new(1, &[transmission]).expect("lit");
            let look = crate::Look {
                picture: Some(picture),
                ..crate::Look::default()
            };
            let drawn = lens.with_look(&look).expect("a pupil lens");
            let session = LensSession::new(&drawn, &crate::Settings::default());
            session.expect("valid").fingerprint(&plate)
        };
        assert_eq!(of_picture(1.0), of_picture(1.0));
        assert_ne!(of_picture(1.0), of_picture(0.5));
    }

    #[test]
    fn planes_that_differ_in_one_bit_or_in_order_have_other_hashes() {
        let mut plane: Vec<f32> = (0..40).map(|k| (k / 3) as f32).collect();
        plane[8..16].fill(0.0);
        let own = hash(&plane);
        assert_eq!(own, hash(&plane.clone()));
        assert_ne!(own, hash(&plane[..39]));
        let mut seen = std::collections::BTreeSet::from([own]);
        for at in 0..plane.len() {
            for bit in 0..32 {
                let before = plane[at];
                plane[at] = f32::from_bits(before.to_bits() ^ 1 << bit);
                assert!(seen.insert(hash(&plane)), "sample {at}, bit {bit}");
                plane[at] = before;
            }
        }
        for other in [2, 8, 16] {
            let mut swapped = plane.clone();
            swapped.swap(0, 20 + other);
            assert!(seen.insert(hash(&swapped)), "swapped {other}");
        }
    }
}
