//! Coefficient of joint friction during sliding, during stiction with creep, and in the transition between them. The module is independent
//! of the joint and its load.

use crate::mechanics::{Mat3, Vec3};

/// Friction law of FRICTION: the coefficient vector as a function of the surface velocity v and the creep c. The creep is the integral of v
/// since sticking started.
///
/// S is the quintic step (STEP5), u = v/|v| and e = c/|c|. The velocities of full static and full dynamic friction are vs and vd. D is the
/// maximum stiction deformation:
///
/// ```text
/// |v| >= vd         mu = -mu_d u
/// vs <= |v| < vd    mu = -S(|v|, vs, mu_s, vd, mu_d) u
/// |v| <  vs         mu = -beta mu_s u - (1 - beta) mu_1 e
///                   beta = S(|v|, -vs, -1, vs, 1),   mu_1 = mu_s S(|c|, -D, -1, D, 1)
/// ```
///
/// Source: grammar/NOTES.md, FRICTION; identified from files written by a real ADAMS run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct FrictionLaw {
    /// Static friction coefficient, MU_STATIC.
    pub mu_static: f64,
    /// Dynamic friction coefficient, MU_DYNAMIC.
    pub mu_dynamic: f64,
    /// Speed vs below which the contact sticks, STICTION_TRANSITION_VELOCITY.
    pub stiction_velocity: f64,
    /// Speed vd of full dynamic friction: TRANSITION_VELOCITY_COEFFICIENT times the stiction velocity.
    pub sliding_velocity: f64,
    /// Maximum stiction deformation D, MAX_STICTION_DEFORMATION.
    pub deformation: f64,
}

/// Value of the friction coefficient vector with its derivatives.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Coefficient {
    /// Vector mu, directed against the velocity or the creep.
    pub value: Vec3,
    /// Derivative with respect to the surface velocity.
    pub by_velocity: Mat3,
    /// Derivative with respect to the creep.
    pub by_creep: Mat3,
    /// Weight beta of the velocity term; 1 when sliding.
    pub beta: f64,
    /// Coefficient mu_1 of the creep term; 0 when sliding.
    pub mu_1: f64,
}

/// Returns the quotient S(x, -1, -1, 1, 1) / x and its derivative for x in 0..1. S is odd, so the quotient is regular at 0.
fn quotient(x: f64) -> (f64, f64) {
    let x2 = x * x;
    (
        (15.0 + x2 * (3.0 * x2 - 10.0)) / 8.0,
        x * (12.0 * x2 - 20.0) / 8.0,
    )
}

/// Returns the Jacobian `g 1 + g' x x'/|x|` of the vector function `g(|x|) x`. `size` is |x| and `slope` is g'.
fn radial(x: &Vec3, size: f64, g: f64, slope: f64) -> Mat3 {
    let mut out = Mat3::from_diagonal_element(g);
    if size > 0.0 {
        out += x * x.transpose() * (slope / size);
    }
    out
}

impl FrictionLaw {
    /// Returns this law with both friction coefficients set to 1 and the velocities unchanged. It gives the direction of a friction force
    /// from a preload, which is not multiplied by a friction coefficient.
    #[must_use]
    pub(crate) fn direction(&self) -> Self {
        Self {
            mu_static: 1.0,
            mu_dynamic: 1.0,
            ..*self
        }
    }

    /// Returns whether a surface speed lies in the stiction range.
    pub(crate) fn sticks(&self, speed: f64) -> bool {
        speed < self.stiction_velocity
    }

    /// Computes the coefficient at surface velocity `v` and creep `c`. At rest, the derivative with respect to the velocity depends on the
    /// direction; the mean of the one-sided derivatives in opposite directions is returned.
    pub(crate) fn coefficient(&self, v: &Vec3, c: &Vec3) -> Coefficient {
        let speed = v.norm();
        if !self.sticks(speed) {
            let (vs, vd) = (self.stiction_velocity, self.sliding_velocity);
            let (mu, slope) = if speed >= vd {
                (self.mu_dynamic, 0.0)
            } else {
                let t = (speed - vs) / (vd - vs);
                let s = t * t * t * (10.0 + t * (6.0 * t - 15.0));
                let by = 30.0 * t * t * (1.0 - t) * (1.0 - t) / (vd - vs);
                let fall = self.mu_dynamic - self.mu_static;
                (self.mu_static + fall * s, fall * by)
            };
            // d(mu/|v|)/d|v|.
            let g = mu / speed;
            return Coefficient {
                value: -v * g,
                by_velocity: -radial(v, speed, g, (slope - g) / speed),
                by_creep: Mat3::zeros(),
                beta: 1.0,
                mu_1: 0.0,
            };
        }
        let (vs, D) = (self.stiction_velocity, self.deformation);
        let r = speed / vs;
        let (p, p_slope) = quotient(r);
        let (p, p_slope) = (p / vs, p_slope / (vs * vs));
        let beta = p * speed;
        let beta_slope = 15.0 / 8.0 * (1.0 - r * r) * (1.0 - r * r) / vs;
        let crept = c.norm();
        let (q, q_slope) = if crept < D {
            let (q, slope) = quotient(crept / D);
            (self.mu_static * q / D, self.mu_static * slope / (D * D))
        } else {
            (self.mu_static / crept, -self.mu_static / (crept * crept))
        };
        let mut by_velocity = -radial(v, speed, p, p_slope) * self.mu_static;
        if speed > 0.0 {
            by_velocity += c * v.transpose() * (q * beta_slope / speed);
        }
        Coefficient {
            value: -v * (p * self.mu_static) - c * ((1.0 - beta) * q),
            by_velocity,
            by_creep: -radial(c, crept, q, q_slope) * (1.0 - beta),
            beta,
            mu_1: q * crept,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: FrictionLaw = FrictionLaw {
        mu_static: 0.5,
        mu_dynamic: 0.3,
        stiction_velocity: 0.1,
        sliding_velocity: 0.15,
        deformation: 0.01,
    };

    /// Evaluates S(x, x0, h0, x1, h1) as defined in the help page of STEP5.
    fn step5(x: f64, x0: f64, h0: f64, x1: f64, h1: f64) -> f64 {
        let t = ((x - x0) / (x1 - x0)).clamp(0.0, 1.0);
        h0 + (h1 - h0) * t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t)
    }

    #[test]
    fn the_coefficient_is_made_of_quintic_steps() {
        for v in [
            Vec3::new(0.03, -0.02, 0.05),
            Vec3::new(0.1, 0.05, 0.0),
            Vec3::new(0.0, 0.4, -2.0),
            Vec3::new(1e-7, 0.0, 0.0),
        ] {
            for c in [
                Vec3::new(1e-3, 2e-3, -5e-3),
                Vec3::new(0.02, 0.0, 0.01),
                Vec3::zeros(),
            ] {
                let found = LAW.coefficient(&v, &c);
                let (speed, crept) = (v.norm(), c.norm());
                let u = v / speed;
                let e = c.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
                let expected = if speed >= 0.15 {
                    u * -0.3
                } else if speed >= 0.1 {
                    u * -step5(speed, 0.1, 0.5, 0.15, 0.3)
                } else {
                    let beta = step5(speed, -0.1, -1.0, 0.1, 1.0);
                    let mu_1 = 0.5 * step5(crept, -0.01, -1.0, 0.01, 1.0);
                    assert!((found.beta - beta).abs() < 1e-14);
                    assert!((found.mu_1 - mu_1).abs() < 1e-14);
                    u * (-beta * 0.5) - e * ((1.0 - beta) * mu_1)
                };
                assert!((found.value - expected).norm() < 1e-14, "{v} {c}");
            }
        }
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        for v in [
            Vec3::new(0.03, -0.02, 0.05),
            Vec3::new(0.09, 0.07, 0.01),
            Vec3::new(0.0, 0.4, -2.0),
        ] {
            for c in [Vec3::new(1e-3, 2e-3, -5e-3), Vec3::new(0.02, 0.0, 0.01)] {
                let found = LAW.coefficient(&v, &c);
                for k in 0..3 {
                    let h = 1e-7;
                    let step = Vec3::ith(k, h);
                    let by_v = (LAW.coefficient(&(v + step), &c).value
                        - LAW.coefficient(&(v - step), &c).value)
                        / (2.0 * h);
                    let by_c = (LAW.coefficient(&v, &(c + step)).value
                        - LAW.coefficient(&v, &(c - step)).value)
                        / (2.0 * h);
                    assert!(
                        (by_v - found.by_velocity.column(k)).norm() < 1e-6,
                        "{v} {c}"
                    );
                    assert!((by_c - found.by_creep.column(k)).norm() < 1e-5, "{v} {c}");
                }
            }
        }
    }
}
