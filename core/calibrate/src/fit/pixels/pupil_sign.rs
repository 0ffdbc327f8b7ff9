//! The two signs of a pupil, which give the same PSFs.

use super::parameters::{Parameter, ParameterLayout, Quantity};

impl ParameterLayout {
    /// Chooses between the two equivalent signs of the pupil: alpha rises with vergence, or at a single
    /// distance delta is not negative. For models without effects.
    pub(in crate::fit) fn normalise_signs(&self, theta: &mut [f64]) {
        for channel in self.starts.first().map_or(0..0, |s| 0..s.len()) {
            let number = |quantity, power| {
                self.free_parameters_of(channel).into_iter().find(|&k| {
                    let Parameter::Coefficient {
                        quantity: q,
                        power: p,
                        ..
                    } = self.parameters[k]
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
            self.turn_signs(theta, channel);
        }
    }

    /// Changes the sign of the pupil of `channel`, which leaves its PSFs as they are.
    fn turn_signs(&self, theta: &mut [f64], channel: usize) {
        for k in self.free_parameters_of(channel) {
            if let Parameter::Coefficient {
                quantity: Quantity::Alpha | Quantity::Beta | Quantity::Gamma | Quantity::Delta,
                ..
            } = self.parameters[k]
            {
                theta[k] = -theta[k];
            }
        }
    }
}
