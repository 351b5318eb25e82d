//! One wrench between parts and its contributions to residual and Jacobian. All chain rules from relative motion to part coordinates are in
//! this file.
//!
//! A wrench w = (F, T) acts on part A at the origin of marker I. Its opposite acts at the same point on part B (absent for ACTIONONLY).
//! Marker C on part C is the frame in which the wrench is given and relative to which the motion of I is measured. r, s_B and s_C are the
//! vectors from the reference points of A, B and C to the I origin, and q = (dp, dphi) in ground axes. Then:
//!
//! ```text
//! motion of I in C     m  = X_r q_A - X_sC q_C,       X_r = [1, -r x; 0, 1]
//! change of w          dw = D m + (dphi_C x F, dphi_C x T) + sum u ds
//! balance of A         X_r' w,    balance of B  -X_sB' w
//! change of the arms   d(r x F)   = (dphi_A x r) x F
//!                      d(s_B x F) = (dp_A + dphi_A x r - dp_B) x F
//! ```
//!
//! A wrench that depends on the velocity m' of I relative to C, through `dw = E dm'`, adds the derivatives `E X_r` and `-E X_sC` with
//! respect to the velocities of A and C. It also adds derivatives with respect to their positions, because the frame and the point move.
//! With x = v_I - v_C - w_C x s_C and y = w_A - w_C, they follow from
//!
//! ```text
//! dm' = (-w_C x dp_A + y x (dphi_A x r) + w_C x dp_C - dphi_C x x,  -dphi_C x y)
//! ```
//!
//! Each s is a scalar (a function or a multiplier) to which a part of w is proportional, and u is the wrench per unit of s. An NFORCE at
//! one of its markers has additional terms `D_k m_k` from the motions of its other markers in C.

use super::chain::{
    BodyColumns, Twist, add_block, add_wrench, add33, moved_columns, moved_rows, seen_motion,
};
use crate::linear::Sink;
use crate::mechanics::{Mat3, Mat6, Pose, Vec3, Vec6, skew};

/// Value of a function and its gradient with respect to the unknowns, as a range of `Scratch::gradient`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FunctionValue {
    pub value: f64,
    pub first: usize,
    pub last: usize,
}

/// Scalar to which a wrench is proportional.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Of {
    /// Value of a function, given by its index.
    Function(usize),
    /// Unknown of the system: a Lagrange multiplier.
    Unknown(usize),
}

/// Scalar to which a wrench is proportional, with the wrench per unit of the scalar in ground axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalarWrench {
    pub of: Of,
    pub F: Vec3,
    pub T: Vec3,
}

/// Dependence of a wrench on the motion of a marker other than I.
#[derive(Clone, Debug)]
pub(crate) struct Cross {
    pub marker: usize,
    pub place: BodyColumns,
    /// Vector from the reference point of the marker's part to the marker.
    pub r: Vec3,
    /// Vector from the reference point of the part of C to the marker.
    pub s: Vec3,
    /// Derivative with respect to the marker's motion in C, ground axes.
    pub D: Mat6,
    /// Dependence on the marker's velocity in C; `None` without damping.
    pub rate: Option<ByRate>,
}

impl Cross {
    /// Returns the derivatives of the wrench with respect to the positions and, with damping, the velocities of the marker's part and the
    /// part of C.
    fn columns(&self, c: Option<BodyColumns>) -> impl Iterator<Item = (BodyColumns, Mat6)> + use<> {
        let (r, s) = (skew(&self.r), skew(&self.s));
        let (mut by_k, mut by_c) = (moved_columns(&self.D, &r), -moved_columns(&self.D, &s));
        let mut later = None;
        if let Some(rate) = &self.rate {
            by_k += rate.by_a(&r);
            by_c += rate.by_c();
            let k = (rate.later(self.place), moved_columns(&rate.E, &r));
            let c = c.map(|c| (rate.later(c), -moved_columns(&rate.E, &s)));
            later = Some([Some(k), c]);
        }
        let now = [Some((self.place, by_k)), c.map(|c| (c, by_c))];
        now.into_iter().chain(later.into_iter().flatten()).flatten()
    }
}

/// Dependence of a wrench on velocities, in ground axes.
#[derive(Clone, Debug)]
pub(crate) struct ByRate {
    /// Number of unknowns, which is the offset of the velocity columns.
    pub unknowns: usize,
    /// Derivative E with respect to the velocity of I relative to C.
    pub E: Mat6,
    /// Angular velocity of the part of C.
    pub w_c: Vec3,
    /// Velocity of I relative to C.
    pub x: Vec3,
    /// Angular velocity of A minus the angular velocity of C.
    pub y: Vec3,
}

impl ByRate {
    /// Returns the velocity columns of a body.
    fn later(&self, place: BodyColumns) -> BodyColumns {
        BodyColumns {
            first: place.first + self.unknowns,
            ..place
        }
    }

    /// Returns the part of the wrench derivative with respect to the position of A that comes from the velocity dependence.
    fn by_a(&self, r: &Mat3) -> Mat6 {
        let mut N = Mat6::zeros();
        add33(&mut N, 0, 0, &-skew(&self.w_c));
        add33(&mut N, 0, 3, &-(skew(&self.y) * r));
        self.E * N
    }

    /// Returns the part of the wrench derivative with respect to the position of C that comes from the velocity dependence.
    fn by_c(&self) -> Mat6 {
        let mut N = Mat6::zeros();
        add33(&mut N, 0, 0, &skew(&self.w_c));
        add33(&mut N, 0, 3, &skew(&self.x));
        add33(&mut N, 3, 3, &skew(&self.y));
        self.E * N
    }
}

/// Wrench of one element in one configuration, with its derivatives. All vectors are in ground axes, except `w`.
#[derive(Clone, Debug)]
pub(crate) struct Contribution {
    /// Marker I, at whose origin the wrench acts.
    pub i: usize,
    /// J or JFLOAT marker.
    pub j: usize,
    /// Index into `State::pair_angles`.
    pub pair: usize,
    /// Marker C; `None` means ground.
    pub frame: Option<usize>,
    /// Rotation of C in ground.
    pub R: Mat3,
    /// Wrench (force, torque) in C axes.
    pub w: Vec6,
    pub F: Vec3,
    pub T: Vec3,
    /// Derivative with respect to the motion of I relative to C; `None` if the wrench is constant in C.
    pub D: Option<Mat6>,
    /// Dependence on the velocity of I relative to C; `None` without damping.
    pub rate: Option<ByRate>,
    pub cross: Vec<Cross>,
    pub scalars: Vec<ScalarWrench>,
    /// Columns of part A, and its arm r.
    pub a: (BodyColumns, Vec3),
    /// Columns of part B, and its arm s_B.
    pub b: Option<(BodyColumns, Vec3)>,
    /// Columns of part C, and its arm s_C.
    pub c: Option<(BodyColumns, Vec3)>,
}

impl Default for Contribution {
    fn default() -> Self {
        let nowhere = BodyColumns {
            first: 0,
            freedoms: 0,
        };
        Self {
            i: 0,
            j: 0,
            pair: 0,
            frame: None,
            R: Mat3::identity(),
            w: Vec6::zeros(),
            F: Vec3::zeros(),
            T: Vec3::zeros(),
            D: None,
            rate: None,
            cross: Vec::new(),
            scalars: Vec::new(),
            a: (nowhere, Vec3::zeros()),
            b: None,
            c: None,
        }
    }
}

/// Markers and parts on which a wrench acts.
#[derive(Clone, Copy)]
pub(crate) struct WrenchEnds {
    pub i: usize,
    pub j: usize,
    pub pair: usize,
    pub frame: Option<usize>,
    /// Part on which the opposite wrench acts.
    pub reaction: Option<usize>,
}

impl Contribution {
    /// Adds a scalar to which the wrench is proportional. `unit` is the wrench per unit of the scalar in the axes of the frame.
    pub(super) fn push_scalar(&mut self, of: Of, unit: &Vec6) {
        let (F, T) = halves(&self.R, unit);
        self.scalars.push(ScalarWrench { of, F, T });
    }

    /// Returns the magnitude of the wrench as a force; torques are divided by `length`.
    pub(crate) fn size(&self, length: f64) -> f64 {
        self.F.amax().max(self.T.amax() / length)
    }

    /// Adds the wrench to the force and torque balances of its parts.
    pub(crate) fn balance(&self, g: &mut [f64]) {
        self.spread(&self.F, &self.T, g);
    }

    /// Adds a given wrench that acts at the same point to the balances of the parts.
    pub(crate) fn spread(&self, F: &Vec3, T: &Vec3, g: &mut [f64]) {
        add_wrench(g, self.a.0, 1.0, F, T, &self.a.1);
        if let Some((b, s)) = &self.b {
            add_wrench(g, *b, -1.0, F, T, s);
        }
    }

    /// Adds a wrench given in the axes of the frame to the balances of the parts.
    pub(crate) fn spread_local(&self, w: &Vec6, g: &mut [f64]) {
        let (F, T) = halves(&self.R, w);
        self.spread(&F, &T, g);
    }

    /// Returns the contributions of a scalar to the balances per unit of the scalar: for each body, its columns and six components.
    pub(crate) fn column(
        &self,
        scalar: &ScalarWrench,
    ) -> impl Iterator<Item = (BodyColumns, [f64; 6])> {
        let on = |(place, arm): (BodyColumns, Vec3), sign: f64| {
            let mut column = [0.0; 6];
            let local = BodyColumns { first: 0, ..place };
            add_wrench(&mut column, local, sign, &scalar.F, &scalar.T, &arm);
            (place, column)
        };
        let a = on(self.a, 1.0);
        let b = self.b.map(|b| on(b, -1.0));
        std::iter::once(a).chain(b)
    }

    /// Adds the derivative of the balances with respect to the motions of the parts.
    pub(crate) fn tangent_by_motion<S: Sink>(&self, sink: &mut S) {
        let ((on_a, r), F) = (self.a, &self.F);
        let (r, Fx) = (skew(&r), skew(F));
        let b = self.b.filter(|(place, _)| place.freedoms > 0);
        let c = self.c.filter(|(place, _)| place.freedoms > 0);
        let a_moves = on_a.freedoms > 0;
        let s_b = b.map_or_else(Mat3::zeros, |(_, s)| skew(&s));

        // Derivative with respect to q_A, including the rotation of the arms.
        if a_moves {
            let mut N = self
                .D
                .as_ref()
                .map_or_else(Mat6::zeros, |D| moved_columns(D, &r));
            if let Some(rate) = &self.rate {
                N += rate.by_a(&r);
            }
            let mut block = moved_rows(&r, &N);
            add33(&mut block, 3, 3, &(Fx * r));
            add_block(sink, on_a, on_a, &block);
            if let Some((place, _)) = b {
                let mut block = -moved_rows(&s_b, &N);
                add33(&mut block, 3, 0, &Fx);
                add33(&mut block, 3, 3, &(-Fx * r));
                add_block(sink, place, on_a, &block);
            }
        }
        // Derivative with respect to q_C. If B and C are the same part, its block also includes the rotation of the arm of B.
        let mut arms = b.map(|(place, _)| {
            let mut block = Mat6::zeros();
            add33(&mut block, 3, 0, &-Fx);
            (place, block)
        });
        if let Some((place, s)) = c {
            let N = self.by_frame(&skew(&s));
            if a_moves {
                add_block(sink, on_a, place, &moved_rows(&r, &N));
            }
            if let Some((row, _)) = b {
                let mut block = -moved_rows(&s_b, &N);
                if row.first == place.first
                    && let Some((_, arms)) = arms.take()
                {
                    block += arms;
                }
                add_block(sink, row, place, &block);
            }
        }
        if let Some((place, block)) = arms {
            add_block(sink, place, place, &block);
        }
        if let Some(rate) = &self.rate {
            let by_a = moved_columns(&rate.E, &r);
            let by_c = c.map(|(place, s)| (place, -moved_columns(&rate.E, &skew(&s))));
            for (column, N) in [Some((on_a, by_a)), by_c].into_iter().flatten() {
                let column = rate.later(column);
                add_block(sink, on_a, column, &moved_rows(&r, &N));
                if let Some((row, _)) = b {
                    add_block(sink, row, column, &-moved_rows(&s_b, &N));
                }
            }
        }
        let on_b = self.b.map(|(place, s)| (place, -1.0, s));
        for cross in &self.cross {
            for (row, sign, arm) in [Some((on_a, 1.0, self.a.1)), on_b].into_iter().flatten() {
                let arm = skew(&arm);
                for (column, by) in cross.columns(self.c.map(|c| c.0)) {
                    add_block(sink, row, column, &(moved_rows(&arm, &by) * sign));
                }
            }
        }
    }

    /// Returns the derivative of w with respect to q_C without the terms of other markers: `-D X_sC` and the rotation of the wrench with
    /// its frame.
    fn by_frame(&self, s: &Mat3) -> Mat6 {
        let mut N = self
            .D
            .as_ref()
            .map_or_else(Mat6::zeros, |D| -moved_columns(D, s));
        add33(&mut N, 0, 3, &-skew(&self.F));
        add33(&mut N, 3, 3, &-skew(&self.T));
        if let Some(rate) = &self.rate {
            N += rate.by_c();
        }
        N
    }

    /// Adds the derivative of the balances that comes from functions, with respect to the unknowns on which these functions depend.
    pub(crate) fn tangent_by_functions<S: Sink>(
        &self,
        functions: &[FunctionValue],
        gradient: &[(usize, f64)],
        sink: &mut S,
    ) {
        for scalar in &self.scalars {
            let Of::Function(function) = scalar.of else {
                continue;
            };
            let value = &functions[function];
            for (place, column) in self.column(scalar) {
                for &(unknown, derivative) in &gradient[value.first..value.last] {
                    for k in 0..place.freedoms {
                        sink.add(place.first + k, unknown, column[k] * derivative);
                    }
                }
            }
        }
    }

    /// Appends the gradient of `weight . w` with respect to the unknowns, with w in ground axes. Requires a contribution with derivatives.
    pub(crate) fn pullback(
        &self,
        weight: &Vec6,
        functions: &[FunctionValue],
        gradient: &mut Vec<(usize, f64)>,
    ) {
        let mut push = |place: BodyColumns, row: &nalgebra::RowVector6<f64>| {
            for k in 0..place.freedoms {
                gradient.push((place.first + k, row[k]));
            }
        };
        let weight = weight.transpose();
        if let Some(D) = &self.D {
            push(self.a.0, &(weight * moved_columns(D, &skew(&self.a.1))));
        }
        if let Some(rate) = &self.rate {
            let (a, r) = (self.a.0, skew(&self.a.1));
            push(a, &(weight * rate.by_a(&r)));
            push(rate.later(a), &(weight * moved_columns(&rate.E, &r)));
            if let Some((c, s)) = self.c {
                push(
                    rate.later(c),
                    &-(weight * moved_columns(&rate.E, &skew(&s))),
                );
            }
        }
        for cross in &self.cross {
            for (column, by) in cross.columns(self.c.map(|c| c.0)) {
                push(column, &(weight * by));
            }
        }
        if let Some((place, s)) = self.c {
            push(place, &(weight * self.by_frame(&skew(&s))));
        }
        for scalar in &self.scalars {
            let (F, T) = (&scalar.F, &scalar.T);
            let by: f64 = (0..3)
                .map(|k| weight[k] * F[k] + weight[3 + k] * T[k])
                .sum();
            match scalar.of {
                Of::Unknown(unknown) => gradient.push((unknown, by)),
                Of::Function(function) => {
                    let value = functions[function];
                    for at in value.first..value.last {
                        let (unknown, derivative) = gradient[at];
                        gradient.push((unknown, by * derivative));
                    }
                }
            }
        }
    }

    /// Returns the motion of I relative to C, in ground axes, that results when markers move on their parts.
    pub(crate) fn seen(&self, moved: impl Fn(usize) -> Twist, markers: &[Pose]) -> Vec6 {
        let frame = self.frame.map(|m| (moved(m), &markers[m].p));
        seen_motion(&moved(self.i), &markers[self.i].p, frame)
    }

    /// Adds the change of the balances that results when markers move on their parts: `d(r x F) = r x dF + dp_i x F`. Requires a
    /// contribution with derivatives.
    pub(crate) fn by_marker(
        &self,
        moved: impl Fn(usize) -> Twist,
        markers: &[Pose],
        dg: &mut [f64],
    ) {
        let (i, c) = (moved(self.i), self.frame.map_or_else(Twist::zero, &moved));
        let mut dF = c.turn.cross(&self.F);
        let mut dT = c.turn.cross(&self.T);
        let mut add = |dw: Vec6| {
            dF += dw.fixed_rows::<3>(0);
            dT += dw.fixed_rows::<3>(3);
        };
        if let Some(D) = &self.D {
            add(D * self.seen(&moved, markers));
        }
        let frame = self.frame.map(|m| (moved(m), &markers[m].p));
        for cross in &self.cross {
            let k = cross.marker;
            add(cross.D * seen_motion(&moved(k), &markers[k].p, frame));
        }
        dT += i.shift.cross(&self.F);
        self.spread(&dF, &dT, dg);
    }
}

/// Transforms a wrench from the axes R to ground and returns its force and torque.
pub(crate) fn halves(R: &Mat3, w: &Vec6) -> (Vec3, Vec3) {
    (
        R * Vec3::new(w[0], w[1], w[2]),
        R * Vec3::new(w[3], w[4], w[5]),
    )
}
