//! Adequacy of a model for the lens that it was fitted to, by PSFs that the fit held out.

use std::fmt;

use crate::distance::ObjectDistance;

/// The adequacy of a model for its lens: the figures of the verdict.
///
/// A gap is the squared error of a tile's pixels over the squared norm of the tile, mean over held-out tiles. The excess is
/// what noise does not explain.
#[derive(Debug, Clone, PartialEq)]
pub struct Adequacy {
    /// Gap that the noise of the tiles explains.
    pub noise_gap: f64,
    /// Gap less that of noise; not negative.
    pub excess_gap: f64,
    /// Part of the excess that a smooth field of residuals, interpolated from fitted tiles, removes from held-out ones:
    /// a better model could describe it.
    pub systematic_gap: f64,
    /// The place of the largest excess.
    pub worst: WorstPlace,
    /// The pattern of the residuals.
    pub pattern: ResidualPattern,
}

/// The channel, distance and field zone of the largest excess.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstPlace {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Zone of the field.
    pub zone: FieldZone,
    /// Mean excess there.
    pub excess_gap: f64,
    /// Mean excess of all other held-out tiles; `None` without any, and in profiles of versions that did not state it.
    pub elsewhere_gap: Option<f64>,
}

/// A third of the field by its radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldZone {
    /// Up to a third of the corner's radius.
    Centre,
    /// Up to two thirds.
    Middle,
    /// Beyond.
    Edge,
}

impl FieldZone {
    /// All zones, from the axis outwards.
    pub const ALL: [Self; 3] = [Self::Centre, Self::Middle, Self::Edge];

    /// The identifier used in files.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Middle => "middle",
            Self::Edge => "edge",
        }
    }

    /// Returns the zone at `radius`, in corner radii.
    pub fn at_radius(radius: f64) -> Self {
        Self::ALL[((radius * 3.0) as usize).min(2)]
    }
}

/// The shape that the residuals of most energy have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualPattern {
    /// Number of periods about the PSF's centroid: 0 for rings, 1 for one side against the other, 2 for two axes.
    pub periods: usize,
    /// Share of the residuals' energy that has so many periods.
    pub share: f64,
    /// Their change over the field.
    pub field: FieldPattern,
}

/// A change of residuals over the field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldPattern {
    /// Alike everywhere.
    Constant,
    /// They turn with the meridian.
    Meridional,
    /// Otherwise.
    Varying,
}

impl FieldPattern {
    /// All patterns.
    pub const ALL: [Self; 3] = [Self::Constant, Self::Meridional, Self::Varying];

    /// The identifier used in files.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Meridional => "meridional",
            Self::Varying => "varying",
        }
    }
}

/// The verdict on a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It describes the lens.
    Describes,
    /// It describes the lens up to a visible difference.
    DescribesInPart,
    /// It does not describe the lens.
    DoesNotDescribe,
}

impl Verdict {
    /// The identifier used in reports.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Describes => "describes",
            Self::DescribesInPart => "describes_in_part",
            Self::DoesNotDescribe => "does_not_describe",
        }
    }
}

/// Largest excess of a model that describes its lens: the limit of `seidel diagnose` for profiles of their own set.
pub const MAX_EXCESS_DESCRIBED: f64 = 0.005;
/// Largest excess of one that does so in part. PSFs with it differ at a glance.
pub const MAX_EXCESS_IN_PART: f64 = 0.03;

/// Excess that reads as 0.00 %.
const LEAST_SHOWN: f64 = 5e-5;

impl Adequacy {
    /// Returns the verdict.
    pub fn verdict(&self) -> Verdict {
        if self.excess_gap <= MAX_EXCESS_DESCRIBED {
            Verdict::Describes
        } else if self.excess_gap <= MAX_EXCESS_IN_PART {
            Verdict::DescribesInPart
        } else {
            Verdict::DoesNotDescribe
        }
    }

    /// Returns whether the model fails in its worst place alone, and describes the lens elsewhere.
    pub fn fails_in_one_place(&self) -> bool {
        let elsewhere = self.worst.elsewhere_gap;
        self.verdict() != Verdict::Describes
            && elsewhere.is_some_and(|gap| gap <= MAX_EXCESS_DESCRIBED)
    }
}

impl fmt::Display for Adequacy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let excess = percent(self.excess_gap);
        match self.verdict() {
            Verdict::Describes if self.excess_gap < LEAST_SHOWN => {
                return write!(
                    f,
                    "the model describes the lens: held-out PSFs differ from it by no more than their noise"
                );
            }
            Verdict::Describes => {
                return write!(
                    f,
                    "the model describes the lens: held-out PSFs differ from it by {excess} of their energy"
                );
            }
            Verdict::DescribesInPart => write!(
                f,
                "the model describes the lens up to {excess} of the energy of held-out PSFs"
            )?,
            Verdict::DoesNotDescribe => write!(
                f,
                "the model does not describe the lens: held-out PSFs differ from it by {excess} of their energy"
            )?,
        }
        let WorstPlace {
            channel,
            distance,
            zone,
            excess_gap,
            elsewhere_gap,
        } = &self.worst;
        write!(
            f,
            ". Largest at the {} of the field, channel {channel}, {distance}: {}",
            zone.id(),
            percent(*excess_gap),
        )?;
        if let Some(gap) = elsewhere_gap {
            write!(f, ", elsewhere {}", percent(*gap))?;
        }
        write!(f, ". {}", self.pattern)
    }
}

impl fmt::Display for ResidualPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.periods {
            0 => f.write_str("Residuals are rings")?,
            1 => f.write_str("Residuals are odd, one side against the other")?,
            2 => f.write_str("Residuals are two-fold, one axis against the other")?,
            n => write!(f, "Residuals are {n}-fold")?,
        }
        f.write_str(match self.field {
            FieldPattern::Constant => ", the same over the field",
            FieldPattern::Meridional => ", and turn with the meridian",
            FieldPattern::Varying => ", and vary over the field",
        })
    }
}

fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value < 1.0 {
        format!("{value:.2} %")
    } else {
        format!("{value:.1} %")
    }
}
