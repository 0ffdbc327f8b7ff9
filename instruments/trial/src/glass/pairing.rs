//! Two errors in the proportion at which one of their paraxial results cancels.

/// Results of a unit of one error: the wanted one and the unwanted one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sensitivity {
    pub(super) wanted: f64,
    pub(super) unwanted: f64,
}

/// Two errors and their amounts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pairing {
    pub(super) errors: [usize; 2],
    /// Amounts for a wanted result of 1 and an unwanted one of 0.
    pub(super) amounts: [f64; 2],
}

impl Pairing {
    /// Returns the larger of the two amounts.
    pub(super) fn largest(&self) -> f64 {
        self.amounts[0].abs().max(self.amounts[1].abs())
    }
}

/// Returns all pairings, those of the smallest amounts first.
pub(super) fn pairings(errors: &[Sensitivity]) -> Vec<Pairing> {
    let mut all = Vec::new();
    for (i, a) in errors.iter().enumerate() {
        for (k, b) in errors.iter().enumerate().skip(i + 1) {
            let determinant = a.wanted * b.unwanted - b.wanted * a.unwanted;
            let pairing = Pairing {
                errors: [i, k],
                amounts: [b.unwanted / determinant, -a.unwanted / determinant],
            };
            if pairing.largest().is_finite() {
                all.push(pairing);
            }
        }
    }
    all.sort_by(|a, b| a.largest().total_cmp(&b.largest()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unwanted_result_cancels() {
        let errors = [[1.0, 2.0], [-0.5, 0.7], [0.2, -3.0]]
            .map(|[wanted, unwanted]| Sensitivity { wanted, unwanted });
        let all = pairings(&errors);
        assert_eq!(all.len(), 3);
        for pairing in all {
            let sum = |of: fn(&Sensitivity) -> f64| -> f64 {
                let parts = pairing.errors.iter().zip(pairing.amounts);
                parts.map(|(&i, amount)| of(&errors[i]) * amount).sum()
            };
            assert!((sum(|s| s.wanted) - 1.0).abs() < 1e-12);
            assert!(sum(|s| s.unwanted).abs() < 1e-12);
        }
    }
}
