//! Mirror images: pairs of hardpoints or elements on the two sides of a vehicle.

use crate::settings::MIRRORED_POINT_MM;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_syntax::{Address, Argument, Dataset};

/// The median plane of a vehicle, through the origin of ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Mirror {
    /// Unit normal of the plane: the lateral direction, in ground axes of the deck.
    pub lateral: Vec3,
}

impl Default for Mirror {
    fn default() -> Self {
        Self { lateral: Vec3::y() }
    }
}

impl Mirror {
    /// Returns the mirror image of a position or of a direction.
    pub fn image(&self, of: &Vec3) -> Vec3 {
        of - self.lateral * (2.0 * self.lateral.dot(of))
    }

    /// Returns true if `other` is the mirror image of `place`, within a tenth of a millimetre.
    pub fn are_images(&self, place: &Vec3, other: &Vec3, model: &Model) -> bool {
        let near = MIRRORED_POINT_MM * 1e-3 / model.units.length.si;
        (self.image(place) - other).norm() < near
    }

    /// Returns the address of the number that corresponds to `address` on the other side of the vehicle. This number belongs to the element of
    /// the same kind whose I and J markers are mirror images of this element's I and J markers. Returns `None` without such an element, as for
    /// an element in the median plane.
    pub(crate) fn partner(
        &self,
        address: &Address,
        dataset: &Dataset,
        model: &Model,
    ) -> Option<Address> {
        let ends = |id: Option<u32>| -> Option<[Vec3; 2]> {
            let statement = dataset.statement(&address.kind, id)?;
            let end = |name: &str| -> Option<Vec3> {
                let number = statement.all(name).flat_map(Argument::numbers).next()?;
                place(model, model.marker(number.value as u32)?).into()
            };
            Some([end("I")?, end("J")?])
        };
        let own = ends(address.id)?;
        let is_image = |other: &[Vec3; 2]| {
            let pairs = own.iter().zip(other);
            pairs.into_iter().all(|(a, b)| self.are_images(a, b, model))
        };
        let statements = dataset.statements().iter();
        let others = statements.filter(|other| other.kind() == Some(address.kind.as_str()));
        let id = others
            .filter_map(admire_syntax::Statement::number)
            .filter(|id| Some(*id) != address.id)
            .find(|id| ends(Some(*id)).as_ref().is_some_and(is_image))?;
        Some(Address {
            id: Some(id),
            ..address.clone()
        })
    }
}

/// Returns the position of a marker in ground, at the design position.
pub(crate) fn place(model: &Model, marker: MarkerIx) -> Vec3 {
    let frame = &model.markers[marker.0];
    model.parts[frame.part.0].pose.point(&frame.qp)
}
