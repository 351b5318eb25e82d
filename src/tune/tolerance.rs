//! Tolerances of the car: small errors by which axles built to the same drawing differ.

use crate::settings::SAME_PLACE_M;
use admire_identify::tolerance::{
    Effect, EffectGroup, LayerOf, RandomEffects, VarianceComponents, shift,
};
use admire_kc::DeckChange;
use admire_session::backend::LoadProgramme;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_study::ToleranceSettings;
use admire_syntax::Address;

/// A manufacturing error of the car, normally distributed with mean zero.
#[derive(Clone, Debug)]
pub(crate) struct Tolerance {
    /// Group of the error.
    pub group: EffectGroup,
    /// Hardpoint or element that has the error, as the address of its statement in the deck.
    pub element: String,
    /// Standard deviation of the error: in the deck's unit of length, in radians, or as a fraction, depending on the group.
    pub sd: f64,
    /// Change of the deck per standard deviation.
    pub change: DeckChange,
    /// True if the change moves a marker of a wheel. The rig replaces such a marker by its own, so the derivatives on the rig do not
    /// include the change.
    pub moves_wheel: bool,
}

/// Markers that `kc.toml` names; none if no goal reads a test.
#[derive(Clone, Debug, Default)]
pub(crate) struct RigMarkers {
    /// Markers of the wheel centres and of the spin axes.
    pub wheels: Vec<MarkerIx>,
    /// All markers that `kc.toml` names for the wheels.
    pub named: Vec<MarkerIx>,
}

impl RigMarkers {
    /// Returns true if a change of these numbers moves a wheel centre or a spin axis, or a marker in whose frame one of them is given.
    pub(crate) fn are_moved_by<'a>(
        &self,
        numbers: impl IntoIterator<Item = &'a Address>,
        model: &Model,
    ) -> bool {
        let mut moved = Vec::new();
        for address in numbers {
            let is_pose = matches!(
                address.argument.as_deref(),
                Some("QG" | "REULER" | "ZG" | "XG")
            );
            match address.kind.as_str() {
                "PART" if is_pose => return true,
                "MARKER" => moved.extend(address.id.and_then(|id| model.marker(id))),
                _ => {}
            }
        }
        self.are_carried_by(&moved, model)
    }

    fn are_carried_by(&self, moved: &[MarkerIx], model: &Model) -> bool {
        let mut wheels = self.wheels.iter();
        wheels.any(|wheel| moved.contains(wheel) || model.moves_with(*wheel, moved))
    }
}

/// Returns the tolerances of a car: hardpoints, offsets and axes of bushings and joints, spring forces, spring rates and stiffnesses.
/// Groups without a stated size have the default size. Errors of marks, loads and measuring frames are left out. Axis errors of joints at a
/// wheel marker are left out, because they turn the wheel itself, whose orientation the rig sets.
pub(crate) fn tolerances(
    settings: &ToleranceSettings,
    model: &Model,
    rig: &RigMarkers,
) -> Vec<Tolerance> {
    let layer = RandomEffects::of(&LayerOf {
        model,
        programme: &LoadProgramme::default(),
        load_errors: false,
        is_sought: &|_| false,
        is_sought_change: &|_| false,
    });
    let metre = 1.0 / model.units.length.si;
    let sizes = VarianceComponents::new(settings, 0.0, [0.0; 2], 1e-3 * metre);
    let place = |marker: MarkerIx| {
        let own = &model.markers[marker.0];
        model.parts[own.part.0].pose.point(&own.qp)
    };
    // The markers of a steer axis move with the ball joints in which they lie.
    let moved = |address: &str, axis: usize| {
        let first = |markers: &[MarkerIx]| {
            format!("MARKER/{}", model.markers[markers[0].0].header.id) == address
        };
        let point = layer.points.iter().find(|point| first(&point.markers))?;
        let near =
            |marker: &&MarkerIx| (place(**marker) - point.place).norm() < SAME_PLACE_M * metre;
        let mut markers = point.markers.clone();
        markers.extend(rig.named.iter().filter(near));
        markers.sort_by_key(|marker| marker.0);
        markers.dedup();
        Some(shift(model, &markers, &Vec3::ith(axis, 1.0)))
    };
    let mut all = Vec::new();
    for member in &layer.members {
        let is_of_car = matches!(
            member.group,
            EffectGroup::Hardpoints
                | EffectGroup::Offsets
                | EffectGroup::Axes
                | EffectGroup::Preloads
                | EffectGroup::SpringRates
                | EffectGroup::KnownStiffnesses
        );
        let Some(sd) = sizes.of(member.group).filter(|_| is_of_car) else {
            continue;
        };
        let effect = match member.group {
            EffectGroup::Hardpoints => moved(&member.address, member.axis),
            _ => None,
        };
        let mut change = DeckChange::default();
        match effect.as_ref().unwrap_or(&member.effect) {
            Effect::Always(pairs) => change.numbers.extend(
                pairs
                    .iter()
                    .map(|(address, factor)| (address.clone(), sd * factor)),
            ),
            Effect::Turn(markers) => change
                .turns
                .extend(markers.iter().map(|(marker, axis)| (*marker, axis * sd))),
            Effect::Offset { bushing, axis } => {
                let own = &model.bushings[*bushing];
                let force = Address {
                    kind: "BUSHING".to_string(),
                    id: Some(own.header.id),
                    argument: Some("FORCE".to_string()),
                    index: Some(axis + 1),
                };
                change.numbers.push((force, sd * own.k[*axis]));
            }
            Effect::PerCase(_) => continue,
        }
        let turned: Vec<MarkerIx> = change.turns.iter().map(|(marker, _)| *marker).collect();
        if rig.are_carried_by(&turned, model) {
            continue;
        }
        let moves_wheel = rig.are_moved_by(change.numbers.iter().map(|one| &one.0), model);
        let element = member.address.split('.').next().unwrap_or_default();
        all.push(Tolerance {
            group: member.group,
            element: element.to_string(),
            sd,
            change,
            moves_wheel,
        });
    }
    all
}
