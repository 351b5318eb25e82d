//! The elastic law of BEAM in its linear formulation. The module contains no mass.

use super::deflection::Deflection;
use super::field::linear;
use super::{Degenerate, Law, LawEntry, Wrench};
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

pub(super) const LAWS: &[LawEntry] = &[LawEntry {
    name: "beam",
    law: &Beam,
}];

/// BEAM, FORMULATION=LINEAR: a massless Timoshenko beam of uniform cross-section along the x axis of J, with I at +x.
///
/// Law, in J axes, on I at the I origin: `(F, T) = -K (x - LENGTH, y, z, AX, AY, AZ)` with
/// `Py = 12 E Izz ASY / (G A L^2)`, `Pz = 12 E Iyy ASZ / (G A L^2)`,
/// `K11 = E A / L`, `K22 = 12 E Izz / (L^3 (1 + Py))`, `K26 = -6 E Izz / (L^2 (1 + Py))`, `K66 = (4 + Py) E Izz / (L (1 + Py))`,
/// `K33 = 12 E Iyy / (L^3 (1 + Pz))`, `K35 = 6 E Iyy / (L^2 (1 + Pz))`, `K55 = (4 + Pz) E Iyy / (L (1 + Pz))`, `K44 = G Ixx / L`.
/// Shear is neglected in a plane whose shear ratio is zero. The reaction on J at its own origin is `-F` and `-T - d x F`.
/// Parameters, in the order of the model: LENGTH, AREA, IXX, IYY, IZZ, EMODULUS, GMODULUS, ASY, ASZ.
/// Validity: small relative deflections. Source: Adams Solver help, `state_beam`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Beam;

/// Row and column in K of each of the eight stiffness entries.
const PLACES: [(usize, usize); 8] = [
    (0, 0),
    (1, 1),
    (1, 5),
    (5, 5),
    (2, 2),
    (2, 4),
    (4, 4),
    (3, 3),
];

/// Computes the stiffness entries at [`PLACES`] from the nine parameters.
fn entries<N: BeamScalar>(theta: [N; 9]) -> [N; 8] {
    let [l, area, ixx, iyy, izz, e, g, asy, asz] = theta;
    let bending = |i: N, shear: N, sign: f64| {
        let p = e
            .times(i)
            .times(shear)
            .scaled(12.0)
            .over(g.times(area).times(l).times(l));
        let b = e.times(i).over(l.times(p.plus(1.0)));
        let slope = b.over(l);
        [
            slope.over(l).scaled(12.0),
            slope.scaled(6.0 * sign),
            b.times(p.plus(4.0)),
        ]
    };
    let [k22, k26, k66] = bending(izz, asy, -1.0);
    let [k33, k35, k55] = bending(iyy, asz, 1.0);
    [
        e.times(area).over(l),
        k22,
        k26,
        k66,
        k33,
        k35,
        k55,
        g.times(ixx).over(l),
    ]
}

/// Assembles the symmetric stiffness matrix from its eight entries. `pick` selects the value of each entry or one of its derivatives.
fn stiffness<N>(entries: &[N; 8], pick: impl Fn(&N) -> f64) -> Mat6 {
    let mut K = Mat6::zeros();
    for (entry, (a, b)) in entries.iter().zip(PLACES) {
        K[(a, b)] = pick(entry);
        K[(b, a)] = K[(a, b)];
    }
    K
}

impl Beam {
    /// Returns the stiffness matrix K for the nine parameters.
    pub(crate) fn stiffness_matrix(theta: &[f64]) -> Mat6 {
        let values: [f64; 9] = std::array::from_fn(|n| theta[n]);
        stiffness(&entries(values), |&entry| entry)
    }
}

impl Law for Beam {
    fn parameter_count(&self) -> usize {
        9
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let d = Deflection::of(motion)?;
        let values: [f64; 9] = std::array::from_fn(|n| theta[n]);
        let K = stiffness(&entries(values), |&entry| entry);
        let q = d.coordinates() - Vec6::ith(0, theta[0]);
        linear(&K, &q, &Vec6::zeros(), &d, out);
        if with_parameters {
            let seeds = std::array::from_fn(|n| Dual::seed(values[n], n));
            let entries = entries(seeds);
            let columns = out.parameter_columns(9);
            for (n, column) in columns.iter_mut().enumerate() {
                *column = -stiffness(&entries, |entry| entry.slopes[n]) * q;
            }
            // The free position also changes with the length.
            columns[0] += K.column(0);
        }
        Ok(())
    }
}

/// Arithmetic that computes the stiffness entries. Implemented for plain numbers and for numbers that carry derivatives.
trait BeamScalar: Copy {
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn scaled(self, factor: f64) -> Self;
    fn plus(self, constant: f64) -> Self;
}

impl BeamScalar for f64 {
    fn times(self, other: Self) -> Self {
        self * other
    }

    fn over(self, other: Self) -> Self {
        self / other
    }

    fn scaled(self, factor: f64) -> Self {
        self * factor
    }

    fn plus(self, constant: f64) -> Self {
        self + constant
    }
}

/// Dual number: a value with its derivatives with respect to the nine parameters.
#[derive(Clone, Copy)]
struct Dual {
    value: f64,
    slopes: [f64; 9],
}

impl Dual {
    /// Returns parameter `n` as an independent variable: its derivative with respect to itself is 1.
    fn seed(value: f64, n: usize) -> Self {
        let mut slopes = [0.0; 9];
        slopes[n] = 1.0;
        Self { value, slopes }
    }
}

impl BeamScalar for Dual {
    fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            slopes: std::array::from_fn(|n| {
                self.slopes[n] * other.value + self.value * other.slopes[n]
            }),
        }
    }

    fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            slopes: std::array::from_fn(|n| {
                (self.slopes[n] - value * other.slopes[n]) / other.value
            }),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            slopes: self.slopes.map(|slope| slope * factor),
        }
    }

    fn plus(self, constant: f64) -> Self {
        Self {
            value: self.value + constant,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::Mat3;
    use crate::mechanics::Vec3;

    const L: f64 = 200.0;
    const E: f64 = 2.1e5;
    const G: f64 = 8.0e4;
    const I: f64 = 490.0;
    const A: f64 = 78.5;

    fn tip(theta: &[f64], wrench: &Vec6) -> Vec6 {
        // For small deflections, the law is linear, with by_motion = -K at the free position.
        let motion = RelativeMotion {
            p_ij_j: Vec3::new(theta[0], 0.0, 0.0),
            R_ji: Mat3::identity(),
            angles: Vec3::zeros(),
        };
        let mut out = Wrench::default();
        Beam.evaluate(&motion, theta, false, &mut out)
            .expect("regular");
        assert!(out.value.norm() < 1e-9, "relaxed: {}", out.value);
        (-out.by_motion)
            .try_inverse()
            .expect("the beam holds all six")
            * wrench
    }

    /// Euler-Bernoulli cantilever: a tip load P gives the deflection P L^3 / 3 E I and the slope P L^2 / 2 E I. A tip moment M gives M L^2
    /// / 2 E I and M L / E I.
    #[test]
    fn a_cantilever_bends_as_in_the_textbook() {
        let theta = [L, A, 2.0 * I, I, I, E, G, 0.0, 0.0];
        let ei = E * I;
        let y = tip(&theta, &Vec6::ith(1, 10.0));
        assert!((y[1] - 10.0 * L.powi(3) / (3.0 * ei)).abs() < 1e-12 * L);
        assert!((y[5] - 10.0 * L * L / (2.0 * ei)).abs() < 1e-12);
        let z = tip(&theta, &Vec6::ith(2, 10.0));
        assert!((z[2] - 10.0 * L.powi(3) / (3.0 * ei)).abs() < 1e-12 * L);
        // A force along z rotates the tip about -y.
        assert!((z[4] + 10.0 * L * L / (2.0 * ei)).abs() < 1e-12);
        let m = tip(&theta, &Vec6::ith(5, 1e3));
        assert!((m[1] - 1e3 * L * L / (2.0 * ei)).abs() < 1e-12 * L);
        assert!((m[5] - 1e3 * L / ei).abs() < 1e-12);
        let x = tip(&theta, &Vec6::new(1e3, 0.0, 0.0, 1e3, 0.0, 0.0));
        assert!((x[0] - 1e3 * L / (E * A)).abs() < 1e-12);
        assert!((x[3] - 1e3 * L / (G * 2.0 * I)).abs() < 1e-12);
    }

    /// Timoshenko: shear adds ASY P L / (G A) to the tip deflection of the cantilever.
    #[test]
    fn shear_adds_to_the_tip() {
        let asy = 10.0 / 9.0;
        let slender = tip(&[L, A, 2.0 * I, I, I, E, G, 0.0, 0.0], &Vec6::ith(1, 10.0));
        let stout = tip(&[L, A, 2.0 * I, I, I, E, G, asy, 0.0], &Vec6::ith(1, 10.0));
        assert!((stout[1] - slender[1] - asy * 10.0 * L / (G * A)).abs() < 1e-12 * L);
        assert!((stout[5] - slender[5]).abs() < 1e-12);
    }
}
