//! Which numbers a pixel fit is free to choose, and the lens that they make.

use super::change::Change;
use seidel_optics::effects::{Effect, ScenePoint};
use seidel_optics::field::FieldPoint;
use seidel_optics::lens::{LocalPupil, ReducedNumbers, VergenceSeries, Wavefront};
use seidel_optics::profile::{ProfileEffect, PupilChannel};

/// A quantity of the lens that is a polynomial in vergence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Defocus.
    Alpha,
    /// Spherical aberration.
    Beta,
    /// Astigmatism.
    Gamma,
    /// Field curvature.
    Delta,
    /// Coma.
    Phi,
    /// Variance of the symmetric blur.
    Blur,
    /// A parameter of an effect, by their places.
    Effect(usize, usize),
}

impl Quantity {
    /// The six that every lens has.
    pub const BASE: [Self; 6] = [
        Self::Alpha,
        Self::Beta,
        Self::Gamma,
        Self::Delta,
        Self::Phi,
        Self::Blur,
    ];
}

/// How freely one quantity may change with vergence and channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedom {
    /// What.
    pub quantity: Quantity,
    /// Degree of its polynomial in vergence.
    pub degree: usize,
    /// Whether all channels have the same.
    pub shared: bool,
    /// Whether it stays as it is.
    pub held: bool,
}

/// What a fit is free to choose.
#[derive(Clone)]
pub struct Structure {
    /// One entry a quantity, [`Quantity::BASE`] first, then the effects' parameters in order. A
    /// parameter that is left out stays neutral.
    pub freedoms: Vec<Freedom>,
    /// The effects that the lens has.
    pub effects: Vec<&'static dyn Effect>,
    /// Whether the optical axis is free.
    pub axis: bool,
}

impl Structure {
    /// Five numbers and a blur a channel: defocus of `alpha_degree` in vergence, the rest constant.
    pub fn reduced(alpha_degree: usize) -> Self {
        let freedoms = Quantity::BASE.map(|quantity| Freedom {
            quantity,
            degree: if quantity == Quantity::Alpha {
                alpha_degree
            } else {
                0
            },
            shared: false,
            held: false,
        });
        Self {
            freedoms: freedoms.to_vec(),
            effects: Vec::new(),
            axis: false,
        }
    }
}

/// One free number: a coefficient of a quantity, or of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slot {
    /// The coefficient of a power of the scaled vergence; of one channel or of all.
    Coefficient {
        quantity: Quantity,
        channel: Option<usize>,
        power: usize,
    },
    /// Offset of the axis along x (0) or y (1), field units.
    Axis(usize),
}

/// The order of the free numbers, and the lens they make.
#[derive(Clone)]
pub(super) struct Layout {
    pub(super) structure: Structure,
    pub(super) slots: Vec<Slot>,
    /// Middle and half the range of the measured vergences, 1/m.
    middle: f64,
    half: f64,
    /// First slot of each freedom and channel.
    starts: Vec<Vec<usize>>,
    /// See [`ScenePoint::stop_lever_m`].
    stop_lever_m: f64,
}

impl Layout {
    pub(super) fn new(
        structure: Structure,
        channels: usize,
        vergences: (f64, f64),
        stop_lever_m: f64,
    ) -> Self {
        let mut slots = Vec::new();
        let mut starts = Vec::new();
        for freedom in &structure.freedoms {
            let mut of_channel = Vec::new();
            for channel in 0..channels {
                if freedom.shared && channel > 0 {
                    of_channel.push(of_channel[0]);
                    continue;
                }
                of_channel.push(slots.len());
                for power in 0..=freedom.degree {
                    slots.push(Slot::Coefficient {
                        quantity: freedom.quantity,
                        channel: (!freedom.shared).then_some(channel),
                        power,
                    });
                }
            }
            starts.push(of_channel);
        }
        if structure.axis {
            slots.extend([Slot::Axis(0), Slot::Axis(1)]);
        }
        let (low, high) = vergences;
        let half = if high > low { (high - low) / 2.0 } else { 1.0 };
        Self {
            structure,
            slots,
            middle: (low + high) / 2.0,
            half,
            starts,
            stop_lever_m,
        }
    }

    /// Whether the number in slot `k` stays as it is.
    pub(super) fn holds(&self, k: usize) -> bool {
        let Slot::Coefficient { quantity, .. } = self.slots[k] else {
            return false;
        };
        let mut freedoms = self.structure.freedoms.iter();
        freedoms.any(|f| f.quantity == quantity && f.held)
    }

    fn scaled(&self, v: f64) -> f64 {
        (v - self.middle) / self.half
    }

    /// The value of `quantity` in `channel` at vergence `v`; `None` where it stays neutral.
    pub(super) fn value(
        &self,
        theta: &[f64],
        quantity: Quantity,
        channel: usize,
        v: f64,
    ) -> Option<f64> {
        let which = self
            .structure
            .freedoms
            .iter()
            .position(|f| f.quantity == quantity)?;
        let start = self.starts[which][channel];
        let degree = self.structure.freedoms[which].degree;
        let t = self.scaled(v);
        Some(
            theta[start..=start + degree]
                .iter()
                .rev()
                .fold(0.0, |sum, c| sum * t + c),
        )
    }

    /// Where the axis was moved to, field units.
    pub(super) fn axis(&self, theta: &[f64]) -> [f64; 2] {
        if self.structure.axis {
            let count = self.slots.len();
            [theta[count - 2], theta[count - 1]]
        } else {
            [0.0, 0.0]
        }
    }

    /// The place of `at` seen from the axis as `theta` has it.
    pub(super) fn place(&self, theta: &[f64], at: FieldPoint) -> FieldPoint {
        let [x, y] = self.axis(theta);
        FieldPoint::new(at.x - x, at.y - y)
    }

    /// What the number in slot `k` is, in words: quantity, power of vergence, channel.
    pub(super) fn name(&self, k: usize, channels: &[String]) -> String {
        let (quantity, channel, power) = match self.slots[k] {
            Slot::Axis(axis) => return format!("axis {}", ["x", "y"][axis]),
            Slot::Coefficient {
                quantity,
                channel,
                power,
            } => (quantity, channel, power),
        };
        let base = match quantity {
            Quantity::Alpha => "alpha",
            Quantity::Beta => "beta",
            Quantity::Gamma => "gamma",
            Quantity::Delta => "delta",
            Quantity::Phi => "phi",
            Quantity::Blur => "blur",
            Quantity::Effect(which, k) => self.structure.effects[which].parameters()[k].name,
        };
        let of_v = match power {
            0 => String::new(),
            1 => " v".to_owned(),
            n => format!(" v^{n}"),
        };
        let of_channel = match channel {
            Some(c) if channels.len() > 1 => format!(" ({})", channels[c]),
            _ => String::new(),
        };
        format!("{base}{of_v}{of_channel}")
    }

    /// What the lens does to a point at `at`, seen from the axis as given, at vergence `v`.
    pub(super) fn pupil(
        &self,
        theta: &[f64],
        channel: usize,
        at: FieldPoint,
        v: f64,
    ) -> LocalPupil {
        let at = self.place(theta, at);
        let value = |quantity| self.value(theta, quantity, channel, v);
        let number = |quantity| value(quantity).unwrap_or(0.0);
        let numbers = ReducedNumbers {
            alpha: number(Quantity::Alpha),
            beta: number(Quantity::Beta),
            gamma: number(Quantity::Gamma),
            delta: number(Quantity::Delta),
            phi: number(Quantity::Phi),
        };
        let mut pupil = LocalPupil::circular(
            Wavefront::third_order(&numbers, at),
            number(Quantity::Blur).max(0.0),
        );
        let point = ScenePoint {
            at,
            vergence_per_m: v,
            stop_lever_m: self.stop_lever_m,
            // Effects that a fit knows do not ask for these.
            defocus_px_m: 0.0,
            focus_vergence_per_m: 0.0,
            wavelength_px: 0.0,
        };
        for (which, effect) in self.structure.effects.iter().enumerate() {
            let values: Vec<f64> = effect
                .parameters()
                .iter()
                .enumerate()
                .map(|(k, p)| {
                    let free = value(Quantity::Effect(which, k)).unwrap_or(p.neutral);
                    free.clamp(p.least, p.most)
                })
                .collect();
            effect.apply(&values, point, &mut pupil);
        }
        pupil
    }

    /// Of the two ways to write the same lens, the pupil one way or the other way round, chooses the
    /// one whose alpha rises with vergence, at a single distance the one whose delta is not negative.
    /// For lenses without effects.
    pub(super) fn right_way_round(&self, theta: &mut [f64]) {
        for channel in self.starts.first().map_or(0..0, |s| 0..s.len()) {
            let number = |quantity, power| {
                self.slots_of(channel).into_iter().find(|&k| {
                    let Slot::Coefficient {
                        quantity: q,
                        power: p,
                        ..
                    } = self.slots[k]
                    else {
                        return false;
                    };
                    q == quantity && p == power
                })
            };
            let sign = number(Quantity::Alpha, 1).or_else(|| number(Quantity::Delta, 0));
            if sign.is_none_or(|k| theta[k] >= 0.0) {
                continue;
            }
            for k in self.slots_of(channel) {
                if let Slot::Coefficient {
                    quantity: Quantity::Alpha | Quantity::Beta | Quantity::Gamma | Quantity::Delta,
                    ..
                } = self.slots[k]
                {
                    theta[k] = -theta[k];
                }
            }
        }
    }

    /// Copies the numbers of `channel` from one lens to another.
    pub(super) fn copy_channel(&self, to: &mut [f64], from: &[f64], channel: usize) {
        for k in self.slots_of(channel) {
            to[k] = from[k];
        }
    }

    /// Sets the constant term of `quantity` in `channel`.
    pub(super) fn put(&self, theta: &mut [f64], quantity: Quantity, channel: usize, value: f64) {
        let freedoms = &self.structure.freedoms;
        if let Some(which) = freedoms.iter().position(|f| f.quantity == quantity) {
            theta[self.starts[which][channel]] = value;
        }
    }

    /// The slots that `channel` depends on, less those that are held.
    pub(super) fn slots_of(&self, channel: usize) -> Vec<usize> {
        (0..self.slots.len())
            .filter(|&k| match self.slots[k] {
                Slot::Coefficient { channel: of, .. } => of.is_none_or(|c| c == channel),
                Slot::Axis(_) => true,
            })
            .filter(|&k| !self.holds(k))
            .collect()
    }

    /// How the pupil of a point changes with each slot that its channel depends on: by differences of
    /// the pupil's few coefficients, which are polynomials of low degree.
    pub(super) fn changes(
        &self,
        theta: &[f64],
        channel: usize,
        at: FieldPoint,
        v: f64,
    ) -> Vec<Change> {
        let here = self.pupil(theta, channel, at, v);
        let mut moved = theta.to_vec();
        self.slots_of(channel)
            .into_iter()
            .map(|slot| {
                let step = match self.slots[slot] {
                    Slot::Coefficient { .. } => 1e-4,
                    Slot::Axis(_) => 1e-5,
                };
                let mut at_offset = |by: f64| {
                    moved[slot] = theta[slot] + by;
                    let pupil = self.pupil(&moved, channel, at, v);
                    moved[slot] = theta[slot];
                    pupil
                };
                let (low, high) = (at_offset(-step), at_offset(step));
                Change::between(slot, &here, &low, &high, 2.0 * step)
            })
            .collect()
    }

    /// Vergence series of `quantity` in `channel`, with standard errors from `covariance`.
    fn series(
        &self,
        theta: &[f64],
        covariance: &nalgebra::DMatrix<f64>,
        quantity: Quantity,
        channel: usize,
    ) -> Option<VergenceSeries> {
        let freedoms = &self.structure.freedoms;
        let which = freedoms.iter().position(|f| f.quantity == quantity)?;
        let start = self.starts[which][channel];
        let degree = freedoms[which].degree;
        // From powers of (v - middle) / half to powers of v.
        let mut turned = nalgebra::DMatrix::zeros(degree + 1, degree + 1);
        for power in 0..=degree {
            let mut binomial = 1.0;
            for k in 0..=power {
                turned[(k, power)] = binomial * (-self.middle).powi((power - k) as i32)
                    / self.half.powi(power as i32);
                binomial *= (power - k) as f64 / (k + 1) as f64;
            }
        }
        let share = |k: usize, p: usize| -> f64 { turned[(k, p)] };
        let coefficients = (0..=degree)
            .map(|k| (0..=degree).map(|p| share(k, p) * theta[start + p]).sum())
            .collect();
        let sigma = (0..=degree)
            .map(|k| {
                let mut variance = 0.0;
                for p in 0..=degree {
                    for q in 0..=degree {
                        variance += share(k, p) * share(k, q) * covariance[(start + p, start + q)];
                    }
                }
                variance.max(0.0).sqrt()
            })
            .collect();
        Some(VergenceSeries {
            coefficients,
            sigma,
            remainders: Vec::new(),
        })
    }

    /// The channel of the lens that `theta` makes; positions are left to others.
    pub(super) fn channel(
        &self,
        theta: &[f64],
        covariance: &nalgebra::DMatrix<f64>,
        channel: usize,
        name: &str,
    ) -> PupilChannel {
        let series = |quantity| {
            self.series(theta, covariance, quantity, channel)
                .unwrap_or_else(|| VergenceSeries::constant(0.0))
        };
        let effects = self
            .structure
            .effects
            .iter()
            .enumerate()
            .map(|(which, effect)| ProfileEffect {
                effect: *effect,
                values: effect
                    .parameters()
                    .iter()
                    .enumerate()
                    .map(|(k, p)| {
                        self.series(theta, covariance, Quantity::Effect(which, k), channel)
                            .unwrap_or_else(|| VergenceSeries::constant(p.neutral))
                    })
                    .collect(),
            })
            .collect();
        PupilChannel {
            name: name.to_owned(),
            alpha: series(Quantity::Alpha),
            beta: series(Quantity::Beta),
            gamma: series(Quantity::Gamma),
            delta: series(Quantity::Delta),
            phi: series(Quantity::Phi),
            blur_variance_px2: series(Quantity::Blur),
            effects,
            added: Vec::new(),
            stop_lever_m: self.stop_lever_m,
            wavelength_px: 0.0,
            magnification: VergenceSeries::constant(0.0),
            distortion: VergenceSeries::constant(0.0),
            measured_vergence: (self.middle - self.half, self.middle + self.half),
        }
    }

    /// `theta` of `from` carried over to this layout: what both have is kept, what is new is zero, or
    /// neutral for effects.
    pub(super) fn carry(&self, from: &Self, theta: &[f64]) -> Vec<f64> {
        self.slots
            .iter()
            .map(|slot| {
                let same = |other: &Slot| match (slot, other) {
                    (
                        Slot::Coefficient {
                            quantity: a,
                            channel: c,
                            power: p,
                        },
                        Slot::Coefficient {
                            quantity: b,
                            channel: d,
                            power: q,
                        },
                    ) => a == b && p == q && (c == d || c.is_none() || d.is_none()),
                    (a, b) => a == b,
                };
                if let Some(found) = from.slots.iter().position(same) {
                    return theta[found];
                }
                match *slot {
                    Slot::Coefficient {
                        quantity: Quantity::Effect(which, k),
                        power: 0,
                        ..
                    } => self.structure.effects[which].parameters()[k].neutral,
                    _ => 0.0,
                }
            })
            .collect()
    }

    /// Sets the constant term of `quantity` in every channel.
    pub(super) fn set(&self, theta: &mut [f64], quantity: Quantity, value: f64) {
        for (slot, number) in self.slots.iter().zip(theta) {
            if let Slot::Coefficient {
                quantity: q,
                power: 0,
                ..
            } = *slot
                && q == quantity
            {
                *number = value;
            }
        }
    }

    /// Sets `alpha = first + slope v` and the constants of the other numbers of `channel`.
    pub(super) fn start(
        &self,
        theta: &mut [f64],
        channel: usize,
        start: &super::super::starts::Start,
    ) {
        let [first, slope] = start.alpha;
        for (slot, number) in self.slots.iter().zip(theta) {
            let Slot::Coefficient {
                quantity,
                channel: of,
                power,
            } = *slot
            else {
                continue;
            };
            if of.is_some_and(|c| c != channel) {
                continue;
            }
            *number = match (quantity, power) {
                (Quantity::Alpha, 0) => first + slope * self.middle,
                (Quantity::Alpha, 1) => slope * self.half,
                (Quantity::Beta, 0) => start.beta,
                (Quantity::Gamma, 0) => start.gamma,
                (Quantity::Delta, 0) => start.delta,
                (Quantity::Phi, 0) => start.phi,
                _ => *number,
            };
        }
    }

    /// Keeps `theta` where it makes sense: no negative blur on the average, effects within their
    /// bounds.
    pub(super) fn keep_within(&self, theta: &mut [f64], least_blur: f64) {
        for (slot, number) in self.slots.iter().zip(theta) {
            match *slot {
                Slot::Coefficient {
                    quantity: Quantity::Blur,
                    power: 0,
                    ..
                } => *number = number.max(least_blur),
                Slot::Coefficient {
                    quantity: Quantity::Effect(which, k),
                    power: 0,
                    ..
                } => {
                    let p = &self.structure.effects[which].parameters()[k];
                    *number = number.clamp(p.least, p.most);
                }
                _ => {}
            }
        }
    }
}
