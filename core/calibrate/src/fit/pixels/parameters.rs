//! Parameterisation of a pixel fit: the free parameters, and the lens they describe.

use super::jacobian::{ParameterDerivative, PupilChange};
use seidel_optics::effects::{Effect, ScenePoint};
use seidel_optics::field::FieldPoint;
use seidel_optics::lens::{LocalPupil, ReducedNumbers, VergenceSeries, Wavefront};
use seidel_optics::profile::{ProfileEffect, PupilChannel};

/// Largest variance of the symmetric blur, px²: a wider one imitates discs, in a fit that starts on the wrong side of focus.
const MAX_BLUR_PX2: f64 = 400.0;

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
    /// A parameter of an effect: index of the effect, index of the parameter.
    Effect(usize, usize),
}

impl Quantity {
    /// The six quantities of every lens.
    pub const BASE: [Self; 6] = [
        Self::Alpha,
        Self::Beta,
        Self::Gamma,
        Self::Delta,
        Self::Phi,
        Self::Blur,
    ];
}

/// Degrees of freedom of one quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PolynomialSpec {
    /// The quantity.
    pub quantity: Quantity,
    /// Degree of its polynomial in vergence.
    pub degree: usize,
    /// Smallest degree that a choice of degrees may give it.
    pub least_degree: usize,
    /// Whether all channels share it.
    pub shared: bool,
    /// Whether it is held fixed.
    pub fixed: bool,
}

/// Structure of the model: its quantities, effects and axis.
#[derive(Clone)]
pub struct ModelStructure {
    /// One entry per quantity: [`Quantity::BASE`] first, then the effects' parameters in order. A parameter
    /// without an entry stays at its neutral value.
    pub polynomials: Vec<PolynomialSpec>,
    /// The effects of the lens.
    pub effects: Vec<&'static dyn Effect>,
    /// Whether the optical axis is free.
    pub axis: bool,
}

impl ModelStructure {
    /// Returns the reduced model: five numbers and a blur per channel. Defocus has degree `alpha_degree` in
    /// vergence, the others are constant.
    pub fn reduced(alpha_degree: usize) -> Self {
        let polynomials = Quantity::BASE.map(|quantity| {
            let degree = if quantity == Quantity::Alpha {
                alpha_degree
            } else {
                0
            };
            PolynomialSpec {
                quantity,
                degree,
                least_degree: degree,
                shared: false,
                fixed: false,
            }
        });
        Self {
            polynomials: polynomials.to_vec(),
            effects: Vec::new(),
            axis: false,
        }
    }
}

/// One scalar parameter: a coefficient of a quantity, or a coordinate of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::fit) enum Parameter {
    /// Coefficient of a power of the scaled vergence, of one channel or of all.
    Coefficient {
        quantity: Quantity,
        channel: Option<usize>,
        power: usize,
    },
    /// Offset of the axis along x (0) or y (1), half frame widths.
    Axis(usize),
}

/// Order of the parameters in the vector `theta`, and the lens that a vector describes.
#[derive(Clone)]
pub(in crate::fit) struct ParameterLayout {
    pub(in crate::fit) structure: ModelStructure,
    pub(in crate::fit) parameters: Vec<Parameter>,
    /// Middle and half the range of the measured vergences, 1/m.
    middle: f64,
    half: f64,
    /// Index of the first parameter of each polynomial and channel.
    pub(super) starts: Vec<Vec<usize>>,
    /// See [`ScenePoint::stop_lever_m`].
    stop_lever_m: f64,
}

impl ParameterLayout {
    pub(in crate::fit) fn new(
        structure: ModelStructure,
        channels: usize,
        vergences: (f64, f64),
        stop_lever_m: f64,
    ) -> Self {
        let mut parameters = Vec::new();
        let mut starts = Vec::new();
        for freedom in &structure.polynomials {
            let mut of_channel = Vec::new();
            for channel in 0..channels {
                if freedom.shared && channel > 0 {
                    of_channel.push(of_channel[0]);
                    continue;
                }
                of_channel.push(parameters.len());
                for power in 0..=freedom.degree {
                    parameters.push(Parameter::Coefficient {
                        quantity: freedom.quantity,
                        channel: (!freedom.shared).then_some(channel),
                        power,
                    });
                }
            }
            starts.push(of_channel);
        }
        if structure.axis {
            parameters.extend([Parameter::Axis(0), Parameter::Axis(1)]);
        }
        let (low, high) = vergences;
        let half = if high > low { (high - low) / 2.0 } else { 1.0 };
        Self {
            structure,
            parameters,
            middle: (low + high) / 2.0,
            half,
            starts,
            stop_lever_m,
        }
    }

    /// Returns this layout with the optical axis where it is.
    pub(super) fn with_known_axis(&self) -> Self {
        let mut layout = self.clone();
        layout.structure.axis = false;
        let is_axis = |slot: &Parameter| matches!(slot, Parameter::Axis(_));
        layout.parameters.retain(|slot| !is_axis(slot));
        layout
    }

    /// Returns whether parameter `k` is held fixed.
    pub(in crate::fit) fn is_fixed(&self, k: usize) -> bool {
        let Parameter::Coefficient { quantity, .. } = self.parameters[k] else {
            return false;
        };
        let mut polynomials = self.structure.polynomials.iter();
        polynomials.any(|f| f.quantity == quantity && f.fixed)
    }

    fn scaled(&self, v: f64) -> f64 {
        (v - self.middle) / self.half
    }

    /// Returns `quantity` in `channel` at vergence `v`; `None` where it stays neutral.
    pub(in crate::fit) fn value(
        &self,
        theta: &[f64],
        quantity: Quantity,
        channel: usize,
        v: f64,
    ) -> Option<f64> {
        let which = self
            .structure
            .polynomials
            .iter()
            .position(|f| f.quantity == quantity)?;
        let start = self.starts[which][channel];
        let degree = self.structure.polynomials[which].degree;
        let t = self.scaled(v);
        Some(
            theta[start..=start + degree]
                .iter()
                .rev()
                .fold(0.0, |sum, c| sum * t + c),
        )
    }

    /// Returns the offset of the axis, half frame widths.
    pub(in crate::fit) fn axis(&self, theta: &[f64]) -> [f64; 2] {
        if self.structure.axis {
            let count = self.parameters.len();
            [theta[count - 2], theta[count - 1]]
        } else {
            [0.0, 0.0]
        }
    }

    /// Returns the field position of `at` relative to the fitted axis.
    pub(in crate::fit) fn place(&self, theta: &[f64], at: FieldPoint) -> FieldPoint {
        let [x, y] = self.axis(theta);
        FieldPoint::new(at.x - x, at.y - y)
    }

    /// Returns the name of parameter `k`: quantity, power of vergence, channel.
    pub(in crate::fit) fn name(&self, k: usize, channels: &[String]) -> String {
        let (quantity, channel, power) = match self.parameters[k] {
            Parameter::Axis(axis) => return format!("axis {}", ["x", "y"][axis]),
            Parameter::Coefficient {
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

    /// Returns the local pupil of a point at `at`, relative to the initial axis, at vergence `v`.
    pub(in crate::fit) fn pupil(
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
            // The effects used in fits do not depend on these.
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

    /// Copies the parameters of `channel`.
    pub(in crate::fit) fn copy_channel(&self, to: &mut [f64], from: &[f64], channel: usize) {
        for k in self.free_parameters_of(channel) {
            to[k] = from[k];
        }
    }

    /// Sets the constant term of `quantity` in `channel`.
    pub(in crate::fit) fn set_constant(
        &self,
        theta: &mut [f64],
        quantity: Quantity,
        channel: usize,
        value: f64,
    ) {
        let polynomials = &self.structure.polynomials;
        if let Some(which) = polynomials.iter().position(|f| f.quantity == quantity) {
            theta[self.starts[which][channel]] = value;
        }
    }

    /// Returns the free parameters on which `channel` depends.
    pub(in crate::fit) fn free_parameters_of(&self, channel: usize) -> Vec<usize> {
        (0..self.parameters.len())
            .filter(|&k| match self.parameters[k] {
                Parameter::Coefficient { channel: of, .. } => of.is_none_or(|c| c == channel),
                Parameter::Axis(_) => true,
            })
            .filter(|&k| !self.is_fixed(k))
            .collect()
    }

    /// Returns the derivatives of a point's pupil with respect to each free parameter of its channel, by
    /// central differences. The pupil's coefficients are low-degree polynomials of the parameters.
    pub(super) fn changes(
        &self,
        theta: &[f64],
        channel: usize,
        at: FieldPoint,
        v: f64,
    ) -> Vec<ParameterDerivative> {
        let here = self.pupil(theta, channel, at, v);
        let mut moved = theta.to_vec();
        let changes = self.free_parameters_of(channel).into_iter().map(|slot| {
            let step = match self.parameters[slot] {
                Parameter::Coefficient { .. } => 1e-4,
                Parameter::Axis(_) => 1e-5,
            };
            let mut at_offset = |by: f64| {
                moved[slot] = theta[slot] + by;
                let pupil = self.pupil(&moved, channel, at, v);
                moved[slot] = theta[slot];
                pupil
            };
            PupilChange {
                slot,
                low: at_offset(-step),
                high: at_offset(step),
                distance: 2.0 * step,
            }
        });
        ParameterDerivative::all(&here, changes)
    }

    /// Returns the vergence series of `quantity` in `channel`, with standard errors from `covariance`.
    fn series(
        &self,
        theta: &[f64],
        covariance: &nalgebra::DMatrix<f64>,
        quantity: Quantity,
        channel: usize,
    ) -> Option<VergenceSeries> {
        let polynomials = &self.structure.polynomials;
        let which = polynomials.iter().position(|f| f.quantity == quantity)?;
        let start = self.starts[which][channel];
        let degree = polynomials[which].degree;
        // Change of basis from powers of (v - middle) / half to powers of v.
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

    /// Returns the profile's channel for `theta`, with zero magnification and distortion.
    pub(in crate::fit) fn channel(
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
            picture: None,
            stop_lever_m: self.stop_lever_m,
            wavelength_px: 0.0,
            magnification: VergenceSeries::constant(0.0),
            distortion: VergenceSeries::constant(0.0),
            measured_vergence: (self.middle - self.half, self.middle + self.half),
        }
    }

    /// Returns `theta` of the layout `from` in this layout. New parameters are zero, or neutral for effects.
    pub(in crate::fit) fn transfer(&self, from: &Self, theta: &[f64]) -> Vec<f64> {
        self.parameters
            .iter()
            .map(|slot| {
                let same = |other: &Parameter| match (slot, other) {
                    (
                        Parameter::Coefficient {
                            quantity: a,
                            channel: c,
                            power: p,
                        },
                        Parameter::Coefficient {
                            quantity: b,
                            channel: d,
                            power: q,
                        },
                    ) => a == b && p == q && (c == d || c.is_none() || d.is_none()),
                    (a, b) => a == b,
                };
                if let Some(found) = from.parameters.iter().position(same) {
                    return theta[found];
                }
                match *slot {
                    Parameter::Coefficient {
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
    pub(in crate::fit) fn set_constant_in_all(
        &self,
        theta: &mut [f64],
        quantity: Quantity,
        value: f64,
    ) {
        for (slot, number) in self.parameters.iter().zip(theta) {
            if let Parameter::Coefficient {
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

    /// Sets alpha and the constants of the other numbers of `channel` from an initial estimate.
    pub(in crate::fit) fn set_initial(
        &self,
        theta: &mut [f64],
        channel: usize,
        start: &crate::fit::initial::InitialEstimate,
    ) {
        let [first, slope] = start.alpha;
        for (slot, number) in self.parameters.iter().zip(theta) {
            let Parameter::Coefficient {
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

    /// Clamps `theta` to its bounds: the constant of the blur, and the constants of effects.
    pub(in crate::fit) fn clamp_to_bounds(&self, theta: &mut [f64], least_blur: f64) {
        for (slot, number) in self.parameters.iter().zip(theta) {
            match *slot {
                Parameter::Coefficient {
                    quantity: Quantity::Blur,
                    power: 0,
                    ..
                } => *number = number.clamp(least_blur, MAX_BLUR_PX2),
                Parameter::Coefficient {
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
