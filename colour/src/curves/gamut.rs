//! Gamuts, and the matrices between them.

use serde::Deserialize;

/// Three rows of three.
pub type Matrix = [[f64; 3]; 3];

/// Primaries and white of an RGB space.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gamut {
    /// Where its numbers stand.
    pub document: String,
    /// Which revision of it.
    pub revision: String,
    /// CIE 1931 xy of red.
    pub red: [f64; 2],
    /// CIE 1931 xy of green.
    pub green: [f64; 2],
    /// CIE 1931 xy of blue.
    pub blue: [f64; 2],
    /// CIE 1931 xy of white.
    pub white: [f64; 2],
    /// How its white becomes that of ACES.
    pub adaptation: Adaptation,
}

/// How colours under one white become colours under another: von Kries, on the responses of these cones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Adaptation {
    /// They stay.
    None,
    /// The cones of Lam's Bradford transform.
    Bradford,
    /// The cones of CIECAM02.
    Cat02,
}

impl Adaptation {
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
    /// What turns its RGB into XYZ, white of Y = 1 into RGB of 1.
    fn to_xyz(&self) -> Matrix {
        let [r, g, b] = [self.red, self.green, self.blue].map(|[x, y]| [x, y, 1.0 - x - y]);
        let columns = transposed([r, g, b]);
        let gains = times_vector(&inverse(&columns), xyz(self.white));
        columns.map(|row| [row[0] * gains[0], row[1] * gains[1], row[2] * gains[2]])
    }

    /// What turns its linear RGB into that of `other`; white is adapted as this one says.
    pub fn to(&self, other: &Self) -> Matrix {
        let to_xyz = self.to_xyz();
        let adapted = match self.adaptation.cones() {
            None => to_xyz,
            Some(cones) => {
                let seen = times_vector(&cones, xyz(self.white));
                let wanted = times_vector(&cones, xyz(other.white));
                let mut scaled = cones;
                for (row, (seen, wanted)) in scaled.iter_mut().zip(seen.into_iter().zip(wanted)) {
                    *row = row.map(|v| v * wanted / seen);
                }
                times(&times(&inverse(&cones), &scaled), &to_xyz)
            }
        };
        times(&inverse(&other.to_xyz()), &adapted)
    }
}

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

/// By cofactors: primaries that span a gamut are far from singular.
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
    fn srgb_is_that_of_its_standard() {
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
    fn white_stays_white_and_what_goes_comes_back() {
        let wide = gamut([0.71, 0.29], [0.2, 0.9], [0.1, -0.05], Adaptation::Cat02);
        let mut other = gamut([0.64, 0.33], [0.3, 0.6], [0.15, 0.06], Adaptation::Cat02);
        other.white = [0.32168, 0.33767];
        let there = wide.to(&other);
        for row in &there {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let both = times(&other.to(&wide), &there);
        for (i, row) in both.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                assert!((v - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}
