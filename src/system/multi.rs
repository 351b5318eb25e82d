//! NFORCE: wrenches on several markers that depend on the motion of all of them.

use super::assemble::{NoValue, halves};
use super::chain::{Acting, Place, Sink, add_cross, moved_columns, turn};
use super::structure::Name;
use super::{Parameters, Reading, Scratch, State, System};
use crate::element::{MultiPoint, MultiWrench};
use crate::mechanics::{Mat6, Vec3, Vec6, skew};
use crate::model::MarkerIx;

/// A force between n markers and one.
#[derive(Debug)]
pub(crate) struct Multi {
    pub name: Name,
    pub i: Vec<usize>,
    pub j: usize,
    pub theta: std::ops::Range<usize>,
    /// Angle references, one per I marker.
    pub pairs: Vec<usize>,
    pub active: bool,
}

impl System {
    fn evaluate_multi(
        multi: &Multi,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<MultiWrench, NoValue> {
        let mut motions = std::mem::take(&mut scratch.motions);
        motions.clear();
        for (&i, &pair) in multi.i.iter().zip(&multi.pairs) {
            motions.push(Self::motion(scratch, state, (i, multi.j, pair), true));
        }
        let mut out = std::mem::take(&mut scratch.multi);
        let law = MultiPoint {
            markers: multi.i.len(),
        };
        let theta = &parameters.theta()[multi.theta.clone()];
        let result = law.evaluate(&motions, theta, &mut out);
        scratch.motions = motions;
        result.map(|()| out).map_err(|reason| NoValue {
            element: multi.name.clone(),
            reason: reason.into(),
        })
    }

    pub(crate) fn add_multi<S: Sink>(
        &self,
        multi: &Multi,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        let out = Self::evaluate_multi(multi, parameters, state, scratch)?;
        let n = multi.i.len();
        let R = scratch.markers[multi.j].R;
        let part_j = self.owners[multi.j];
        let place_j = self.place(part_j);
        for a in 0..n {
            let (F, T) = halves(&R, &out.value[a]);
            scratch.largest = scratch.largest.max(F.amax().max(T.amax() / self.length));
            let D = turn(&R, &out.by_motion[a * n + a]);
            let (on_a, r, s) = self.at(multi.i[a], part_j, state, scratch);
            let acting = Acting {
                F,
                T,
                D: Some(&D),
                a: on_a,
                r,
                b: Some((place_j, s)),
                c: Some((place_j, s)),
            };
            acting.add(g, sink);
            if !S::WANTED {
                continue;
            }
            for b in (0..n).filter(|b| *b != a) {
                let D = turn(&R, &out.by_motion[a * n + b]);
                let (on_b, r_b, s_b) = self.at(multi.i[b], part_j, state, scratch);
                let rows = [(on_a, 1.0, r), (place_j, -1.0, s)];
                add_cross(sink, &rows, &D, (on_b, &r_b), (place_j, &s_b));
            }
        }
        scratch.multi = out;
        Ok(())
    }

    fn at(
        &self,
        marker: usize,
        other: usize,
        state: &State,
        scratch: &Scratch,
    ) -> (Place, Vec3, Vec3) {
        let place = self.place(self.owners[marker]);
        let s = self.arm_to(marker, other, state, scratch);
        (place, scratch.arms[marker], s)
    }

    /// What an NFORCE does at each of its I markers; after [`System::look`].
    ///
    /// # Errors
    /// [`NoValue`] if it is undefined in this configuration.
    pub fn read_nforce(
        &self,
        id: u32,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Vec<Reading>, NoValue> {
        let Some(at) = self.multis.iter().position(|multi| multi.name.id == id) else {
            return Ok(Vec::new());
        };
        (0..self.multis[at].i.len())
            .map(|marker| self.read_multi((at, marker), parameters, state, scratch))
            .collect()
    }

    /// What an NFORCE does at one of its markers.
    pub(crate) fn read_multi(
        &self,
        (multi, at): (usize, usize),
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Reading, NoValue> {
        let multi = &self.multis[multi];
        let out = Self::evaluate_multi(multi, parameters, state, scratch)?;
        let on = if multi.active { 1.0 } else { 0.0 };
        let w = out.value[at] * on;
        scratch.multi = out;
        let (i, j) = (multi.i[at], multi.j);
        let (force, torque) = halves(&scratch.markers[j].R, &w);
        let d = scratch.markers[i].p - scratch.markers[j].p;
        Ok(Reading {
            i: MarkerIx(i),
            j: MarkerIx(j),
            motion: Self::motion(scratch, state, (i, j, multi.pairs[at]), true),
            wrench_j: w,
            force,
            torque,
            force_on_j: -force,
            torque_on_j: -torque - d.cross(&force),
        })
    }

    /// Appends the gradient of `weight . (force, torque)` at one marker.
    pub(crate) fn push_multi(
        &self,
        (number, at): (usize, usize),
        weight: &Vec6,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        let multi = &self.multis[number];
        let weight = if multi.active { *weight } else { Vec6::zeros() };
        let out = Self::evaluate_multi(multi, parameters, state, scratch)?;
        let n = multi.i.len();
        let R = scratch.markers[multi.j].R;
        let part_j = self.owners[multi.j];
        let (F, T) = halves(&R, &out.value[at]);
        let mut by_j = Mat6::zeros();
        by_j.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&F));
        by_j.fixed_view_mut::<3, 3>(3, 3).copy_from(&-skew(&T));
        for b in 0..n {
            let D = turn(&R, &out.by_motion[at * n + b]);
            let (place, r, s) = self.at(multi.i[b], part_j, state, scratch);
            let row = weight.transpose() * moved_columns(&D, &skew(&r));
            for k in 0..place.freedoms {
                scratch.gradient.push((place.first + k, row[k]));
            }
            by_j -= moved_columns(&D, &skew(&s));
        }
        let (place, row) = (self.place(part_j), weight.transpose() * by_j);
        for k in 0..place.freedoms {
            scratch.gradient.push((place.first + k, row[k]));
        }
        scratch.multi = out;
        Ok(())
    }
}
