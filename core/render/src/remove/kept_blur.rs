//! The pixels of a plane that keep their blur, and why.

/// A reason why pixels keep their blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeptBlurReason {
    /// The sample is clipped, a lower bound of the light.
    Clipped,
    /// A light that the lens does not explain within the error that lights may have, in this or another colour.
    UnexplainedLight,
    /// So bright that errors of the lens would draw rings around it.
    Highlight,
    /// The pixel gets light of those above.
    NearLight,
    /// The result would explain the plate there no better than the plate itself as a sharp image.
    UnexplainedPicture,
}

impl KeptBlurReason {
    /// All reasons, in the order in which they are looked for.
    pub const ALL: [Self; 5] = [
        Self::Clipped,
        Self::UnexplainedLight,
        Self::Highlight,
        Self::NearLight,
        Self::UnexplainedPicture,
    ];
}

/// The share of its blur that each pixel of a plane keeps, 0 to 1, with the reason.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptBlur(Vec<(f32, KeptBlurReason)>);

impl KeptBlur {
    /// Returns that of `count` pixels that keep none.
    pub(super) fn none(count: usize) -> Self {
        Self(vec![(0.0, KeptBlurReason::Clipped); count])
    }

    /// Lets `pixel` keep at least this `share` of its blur for this `reason`. The reason of the largest share counts.
    pub(super) fn keep(&mut self, pixel: usize, share: f32, reason: KeptBlurReason) {
        let kept = &mut self.0[pixel];
        if share > kept.0 {
            *kept = (share, reason);
        }
    }

    /// Returns the share of its blur that each pixel keeps.
    pub(super) fn shares(&self) -> impl Iterator<Item = f32> {
        self.0.iter().map(|(share, _)| *share)
    }

    /// Returns the pixels of `self` where `is_own` and those of `other` elsewhere.
    pub(super) fn join(&self, other: &Self, is_own: &[bool]) -> Self {
        let pixels = self.0.iter().zip(&other.0).zip(is_own);
        Self(
            pixels
                .map(|((own, other), is_own)| if *is_own { *own } else { *other })
                .collect(),
        )
    }

    /// Returns the mean share of its blur that the picture keeps for `reason`, 0 to 1.
    pub fn share_of(&self, reason: KeptBlurReason) -> f64 {
        let kept = self.0.iter().filter(|(_, of)| *of == reason);
        kept.map(|(share, _)| f64::from(*share)).sum::<f64>() / self.0.len().max(1) as f64
    }
}
