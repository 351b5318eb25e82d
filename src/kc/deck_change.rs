use admire_solver::mechanics::Vec3;
use admire_solver::model::MarkerIx;
use admire_solver::statics::Direction;
use admire_solver::system::System;
use admire_syntax::Address;

/// Change of a deck per unit: changes of numbers, and rotations of markers on their parts.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct DeckChange {
    /// Addresses of numbers, each with its change per unit. Angles are in radians.
    pub numbers: Vec<(Address, f64)>,
    /// Markers, each with its rotation vector per unit. The vector is in radians and in the axes of the marker.
    pub turns: Vec<(MarkerIx, Vec3)>,
}

impl DeckChange {
    /// Creates a change of numbers without rotations of markers.
    pub const fn of_numbers(numbers: Vec<(Address, f64)>) -> Self {
        Self {
            numbers,
            turns: Vec::new(),
        }
    }

    /// Converts the change to a direction in the parameters of a compiled system. Addresses that are not parameters of the system are left
    /// out.
    pub fn direction(&self, system: &System) -> Direction {
        let catalogue = system.catalogue();
        let numbers = self.numbers.iter();
        let slots = numbers.filter_map(|(address, rate)| Some((catalogue.slot(address)?, *rate)));
        Direction {
            slots: slots.collect(),
            turns: self.turns.clone(),
        }
    }
}
