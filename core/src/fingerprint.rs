//! The fingerprint of a prepared plate: a hash of everything that its results depend on.

use std::hash::{DefaultHasher, Hash, Hasher};

use seidel_render::VergencePass;

use crate::plate::Depth;
use crate::prepared::PreparedPlate;

impl PreparedPlate {
    /// Returns a hash of everything that the results of this plate depend on: lens, settings, placement, samples, depth,
    /// holdout and background. It is the same in one version of the library only.
    pub fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        // The text forms name every field, so that a new one is never forgotten.
        self.session().lens().to_json().hash(&mut hasher);
        format!("{:?}", self.session().settings()).hash(&mut hasher);
        format!("{:?} {:?}", self.geometry(), self.own_part()).hash(&mut hasher);
        format!("{:?}", self.premultiplied().layout()).hash(&mut hasher);
        hash_planes(self.planes().iter().map(Vec::as_slice), &mut hasher);
        match self.depth().source() {
            Depth::Distance(distance) => format!("{distance:?}").hash(&mut hasher),
            Depth::Pass(pass) => {
                format!("{:?}", pass.meaning).hash(&mut hasher);
                hash_planes([pass.samples.as_slice()], &mut hasher);
            }
        }
        if let Some(holdout) = self.holdout() {
            "holdout".hash(&mut hasher);
            hash_planes([holdout.matte()], &mut hasher);
            holdout
                .vergence()
                .inspect(|pass| hash_pass(pass, &mut hasher));
        }
        if let Some(background) = self.background() {
            "background".hash(&mut hasher);
            hash_planes(background.planes(), &mut hasher);
            hash_pass(&background.vergence(), &mut hasher);
        }
        hasher.finish()
    }
}

fn hash_pass(pass: &VergencePass, hasher: &mut DefaultHasher) {
    match pass {
        VergencePass::Constant(vergence) => vergence.to_bits().hash(hasher),
        VergencePass::PerPixel(pass) => hash_planes([*pass], hasher),
    }
}

/// Hashes the number of samples of each plane, and their bits.
fn hash_planes<'a>(planes: impl IntoIterator<Item = &'a [f32]>, hasher: &mut DefaultHasher) {
    for plane in planes {
        plane.len().hash(hasher);
        // Two samples at a time take half the calls.
        let (pairs, rest) = plane.as_chunks::<2>();
        for [first, second] in pairs {
            hasher.write_u64(u64::from(first.to_bits()) << 32 | u64::from(second.to_bits()));
        }
        for sample in rest {
            hasher.write_u32(sample.to_bits());
        }
    }
}
