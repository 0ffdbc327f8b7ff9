//! The refractive index of a glass by wavelength.

/// Fraunhofer lines, nm.
const G_NM: f64 = 435.8343;
const F_NM: f64 = 486.1327;
const D_NM: f64 = 587.5618;
const C_NM: f64 = 656.2725;

/// A glass by the two figures that patents state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Glass {
    /// Index at the d line.
    pub(crate) nd: f64,
    /// Abbe number, (nd - 1) / (nF - nC).
    pub(crate) vd: f64,
}

impl Glass {
    /// Returns the index at `nm` by Cauchy's formula a + b / λ² + c / λ⁴.
    ///
    /// The coefficients follow from nd, from the Abbe number, and from the partial dispersion (ng - nF) / (nF - nC) of
    /// the normal line through Schott's K7 and F2, 0.6438 - 0.001682 Vd.
    pub(crate) fn index(self, nm: f64) -> f64 {
        let power = |nm: f64, k: i32| (1000.0 / nm).powi(k);
        let step = |from: f64, to: f64, k: i32| power(from, k) - power(to, k);
        let principal = (self.nd - 1.0) / self.vd;
        let partial = (0.6438 - 0.001_682 * self.vd) * principal;
        let (p2, p4) = (step(F_NM, C_NM, 2), step(F_NM, C_NM, 4));
        let (q2, q4) = (step(G_NM, F_NM, 2), step(G_NM, F_NM, 4));
        let determinant = p2 * q4 - p4 * q2;
        let b = (principal * q4 - p4 * partial) / determinant;
        let c = (p2 * partial - principal * q2) / determinant;
        self.nd + b * step(nm, D_NM, 2) + c * step(nm, D_NM, 4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_meets_the_abbe_number_and_the_catalogue() {
        // Schott F2 and N-SK16, from the maker's Sellmeier coefficients.
        let catalogue = [
            (620.040e-3, 36.366, [1.617_461, 1.624_758, 1.636_758]),
            (620.410e-3, 60.324, [1.618_809, 1.623_269, 1.630_211]),
        ];
        for (nd_less_one, vd, indices) in catalogue {
            let nd = 1.0 + nd_less_one;
            let glass = Glass { nd, vd };
            let abbe = (nd - 1.0) / (glass.index(F_NM) - glass.index(C_NM));
            assert!((abbe - vd).abs() < 1e-9);
            assert!((glass.index(D_NM) - nd).abs() < 1e-12);
            for (nm, index) in [620.0, 540.0, 460.0].into_iter().zip(indices) {
                let apart = glass.index(nm) - index;
                assert!(apart.abs() < 1e-4, "{nd} at {nm} nm: {apart:e}");
            }
        }
    }
}
