//! Gamuts, and the matrices between them (SMPTE RP 177).

use serde::Deserialize;

/// A 3x3 matrix, as rows.
pub type Matrix = [[f64; 3]; 3];

/// Primaries and white point of an RGB space, in CIE 1931 xy.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gamut {
    /// Document that defines it.
    pub document: String,
    /// Revision of the document.
    pub revision: String,
    /// The red primary.
    pub red: [f64; 2],
    /// The green primary.
    pub green: [f64; 2],
    /// The blue primary.
    pub blue: [f64; 2],
    /// The white point.
    pub white: [f64; 2],
    /// Chromatic adaptation from its white point to that of ACES.
    pub adaptation: Adaptation,
}

/// A chromatic adaptation: von Kries scaling of cone responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Adaptation {
    /// No adaptation.
    None,
    /// Cone responses of the Bradford transform (Lam 1985).
    Bradford,
    /// Cone responses of CIECAM02.
    Cat02,
}

impl Adaptation {
    /// Returns the matrix from XYZ to cone responses.
    fn cones(self) -> Option<Matrix> {
        match self {
            Self::None => None,
            Self::Bradford => Some([
                [0.8951, 0.2664, -0.1614],
                [-0.7502, 1.7135, 0.0367],
                [0.0389, -0.0685, 1.0296],
            ]),
            Self::Cat02 => Some([
                [0.7328, 0.4296, -0.1624],
                [-0.7036, 1.6975, 0.0061],
                [0.0030, 0.0136, 0.9834],
            ]),
        }
    }
}

impl Gamut {
    /// Returns the matrix from linear RGB to XYZ, normalised so that RGB white has Y = 1.
    fn to_xyz(&self) -> Matrix {
        let [r, g, b] = [self.red, self.green, self.blue].map(|[x, y]| [x, y, 1.0 - x - y]);
        let columns = transposed([r, g, b]);
        let gains = times_vector(&inverse(&columns), xyz(self.white));
        columns.map(|row| [row[0] * gains[0], row[1] * gains[1], row[2] * gains[2]])
    }

    /// Returns the matrix from its linear RGB to that of `other`, with the chromatic adaptation of `self`.
    pub fn matrix_to(&self, other: &Self) -> Matrix {
        let to_xyz = self.to_xyz();
        let adapted = match self.adaptation.cones() {
            None => to_xyz,
            Some(cones) => {
                let from = times_vector(&cones, xyz(self.white));
                let to = times_vector(&cones, xyz(other.white));
                let scaled = std::array::from_fn(|i| cones[i].map(|v| v * to[i] / from[i]));
                times(&times(&inverse(&cones), &scaled), &to_xyz)
            }
        };
        times(&inverse(&other.to_xyz()), &adapted)
    }
}

/// Returns the XYZ of a chromaticity with Y = 1.
fn xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

fn transposed(m: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn times_vector(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Inverts by cofactors; the primaries of a gamut are far from collinear.
fn inverse(m: &Matrix) -> Matrix {
    let minor = |i: usize, j: usize| {
        let (a, b) = ((i + 1) % 3, (i + 2) % 3);
        let (c, d) = ((j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gamut(red: [f64; 2], green: [f64; 2], blue: [f64; 2], adaptation: Adaptation) -> Gamut {
        Gamut {
            document: String::new(),
            revision: String::new(),
            red,
            green,
            blue,
            white: [0.3127, 0.329],
            adaptation,
        }
    }

    #[test]
    fn srgb_matrix_matches_its_standard() {
        let srgb = gamut([0.64, 0.33], [0.3, 0.6], [0.15, 0.06], Adaptation::None);
        let want = [
            [0.4124, 0.3576, 0.1805],
            [0.2126, 0.7152, 0.0722],
            [0.0193, 0.1192, 0.9505],
        ];
        let found = srgb.to_xyz();
        for (found, want) in found.iter().flatten().zip(want.iter().flatten()) {
            assert!((found - want).abs() < 1e-4, "{found} {want}");
        }
    }

    #[test]
    fn white_maps_to_white_and_matrices_round_trip() {
        let wide = gamut([0.71, 0.29], [0.2, 0.9], [0.1, -0.05], Adaptation::Cat02);
        let mut other = gamut([0.64, 0.33], [0.3, 0.6], [0.15, 0.06], Adaptation::Cat02);
        other.white = [0.32168, 0.33767];
        let forward = wide.matrix_to(&other);
        for row in &forward {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let round_trip = times(&other.matrix_to(&wide), &forward);
        for (i, row) in round_trip.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                assert!((v - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}
