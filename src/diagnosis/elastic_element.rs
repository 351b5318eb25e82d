//! Elastic elements with six components between two markers: BUSHINGs, and FIELDs with the law of a bushing.

use super::candidate_effect::{FORCES, Parametrisation, Sensitivity, component};
use super::operating_points::OperatingPoints;
use crate::settings::ROUND_OFF_DEFLECTION;
use admire_solver::model::{MarkerIx, PairForce};
use admire_solver::system::Reading;
use admire_syntax::Address;

/// Elastic element with its state in every load case.
pub(super) struct ElasticElement {
    /// Keyword of the statement: `BUSHING` or `FIELD`.
    kind: &'static str,
    id: u32,
    /// I and J markers.
    pub pair: (MarkerIx, MarkerIx),
    /// Deflections in each case: three translations along the axes of J, then three projected angles in radians.
    pub deflections: Vec<[f64; 6]>,
    /// Stiffness of each component at the fit. For a FIELD it is the regression slope of the force over the deflection in all cases, because its law
    /// may be a curve.
    pub stiffness: [f64; 6],
    /// True if the forces along x and y are known to depend on the radial deflection, as in a bushing of Adams/Car.
    pub is_radial: bool,
}

impl ElasticElement {
    /// Returns the active elastic elements of the study's own deck.
    pub(super) fn all(survey: &OperatingPoints<'_>) -> Vec<Self> {
        let bushings = survey.model.bushings.iter().enumerate();
        let bushings = bushings.filter(|(_, bushing)| bushing.header.active);
        let bushings = bushings.map(|(k, bushing)| Self {
            kind: "BUSHING",
            id: bushing.header.id,
            pair: (bushing.i, bushing.j),
            deflections: survey.bushing_deflections(k),
            stiffness: bushing_stiffness(survey, k),
            is_radial: false,
        });
        let fields = survey.model.pair_forces.iter();
        let is_field = |force: &&PairForce| force.is_field() && force.header.active;
        let fields = fields.filter(is_field).map(|field| {
            let readings = survey.element("FIELD", field.header.id);
            Self {
                kind: "FIELD",
                id: field.header.id,
                pair: (field.i, field.j),
                deflections: readings.iter().map(Reading::deflections).collect(),
                stiffness: std::array::from_fn(|axis| regression_stiffness(readings, axis)),
                is_radial: field.car.is_some(),
            }
        });
        bushings.chain(fields).collect()
    }

    /// Returns the address of the element: `BUSHING/1` or `FIELD/1`.
    pub(super) fn statement(&self) -> String {
        format!("{}/{}", self.kind, self.id)
    }

    /// Returns true if a component is deflected in some case.
    pub(super) fn moves(&self, axis: usize) -> bool {
        let each = self.deflections.iter();
        each.map(|u| u[axis].abs())
            .any(|u| u > ROUND_OFF_DEFLECTION)
    }

    /// Returns the parameter of an offset between the two sides along one component, with its first-order effect. Returns `None` if the deck has
    /// no parameter for it.
    pub(super) fn offset(
        &self,
        survey: &OperatingPoints<'_>,
        axis: usize,
    ) -> Option<(Parametrisation, Sensitivity)> {
        if self.kind == "BUSHING" {
            let words = [["K", "FORCE"], ["KT", "TORQUE"]][axis / 3];
            let number = |word| Address::of_argument("BUSHING", self.id, word, Some(axis % 3 + 1));
            let [stiffness, preload] = words.map(number);
            let column = Sensitivity::Always(vec![(preload.clone(), self.stiffness[axis])]);
            return Some((Parametrisation::Offset { stiffness, preload }, column));
        }
        let mut fields = survey.model.pair_forces.iter();
        let field = fields.find(|f| f.is_field() && f.header.id == self.id)?;
        let change = vec![field.free_position(survey.model, axis)?];
        Some((
            Parametrisation::Extended(change.clone()),
            Sensitivity::Always(change),
        ))
    }

    /// Returns the address of a component: `BUSHING/1.K.1` to `BUSHING/1.KT.3`, or `FIELD/1.FX` to `FIELD/1.TZ`.
    pub(super) fn address(&self, axis: usize) -> String {
        let word = match self.kind {
            "BUSHING" => component(axis),
            _ => FORCES[axis].to_string(),
        };
        format!("{}.{word}", self.statement())
    }
}

/// Returns the six stiffnesses of a bushing at the fit: three of K, then three of KT.
pub(super) fn bushing_stiffness(survey: &OperatingPoints<'_>, bushing: usize) -> [f64; 6] {
    let law = &survey.model.bushings[bushing];
    let theta = &survey.fitted.thetas[0];
    let catalogue = survey.fitted.deck.prepared.system.catalogue();
    std::array::from_fn(|axis| {
        let word = ["K", "KT"][axis / 3];
        let address = Address::of_argument("BUSHING", law.header.id, word, Some(axis % 3 + 1));
        catalogue.slot(&address).map_or(0.0, |slot| theta.get(slot))
    })
}

/// Returns the regression slope of the restoring force over the deflection in one component; zero if the deflection does not change.
fn regression_stiffness(readings: &[Reading], axis: usize) -> f64 {
    let count = readings.len().max(1) as f64;
    let each = readings
        .iter()
        .map(|reading| (reading.deflections()[axis], -reading.wrench_j[axis]));
    let (u, f) = each
        .clone()
        .fold((0.0, 0.0), |(u, f), (du, df)| (u + du, f + df));
    let (u, f) = (u / count, f / count);
    let (uu, uf) = each.fold((0.0, 0.0), |(uu, uf), (du, df)| {
        (uu + (du - u) * (du - u), uf + (du - u) * (df - f))
    });
    if uu > 0.0 { uf / uu } else { 0.0 }
}
