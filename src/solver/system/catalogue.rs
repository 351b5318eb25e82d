use std::ops::Range;

use admire_syntax::Address;
use admire_syntax::grammar::{ArgumentDef, Components};
use admire_syntax::hash::QuickMap;
use admire_syntax::units::Dimension;

/// Index of one parameter in the parameter vector theta.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Slot(pub usize);

/// Meaning of the parameters of a group. It selects how derivatives with respect to them are computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Role {
    /// Arguments of the force law of an element.
    Law { element: usize },
    /// PITCH or PD of a joint.
    Joint { joint: usize },
    /// Arguments of an NFORCE.
    Multi { multi: usize },
    /// QP and REULER of a marker.
    Marker(usize),
    /// Mass of a part.
    Mass(usize),
    /// Components of gravity, ACCGRAV.
    Gravity,
    /// y values of the points of a SPLINE, given by its index in the model.
    Spline(usize),
    /// Literals of a function.
    Literals(usize),
    /// Constant that replaces a whole function.
    Override(usize),
}

/// Dimensions of the parameters of a group.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum GroupDimensions {
    /// One dimension for all parameters of the group.
    Same(Dimension),
    /// Dimension of each component of an argument, as the grammar defines it.
    Of(Components),
    /// Stiffness matrix of n by n parameters, stored column by column and composed of 6 by 6 blocks.
    MultiStiffness(usize),
    /// One dimension for each parameter.
    Each(&'static [Dimension]),
}

impl GroupDimensions {
    /// Returns the dimensions of an argument of the grammar.
    pub(crate) fn of_argument(argument: &ArgumentDef) -> Self {
        match argument.components {
            Components::Alike => Self::Same(argument.dimension),
            components => Self::Of(components),
        }
    }

    fn of(self, k: usize) -> Dimension {
        let component = match self {
            Self::Same(dimension) => return dimension,
            Self::Each(dimensions) => dimensions.get(k).copied(),
            Self::Of(components) => components.of(k),
            Self::MultiStiffness(n) => Components::Stiffness.of(k % n % 6 + 6 * (k / n % 6)),
        };
        component.unwrap_or(Dimension::NONE)
    }
}

/// Parameters that one argument of one statement contributes to theta.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub kind: &'static str,
    pub id: Option<u32>,
    pub argument: Option<&'static str>,
    pub first: usize,
    pub count: usize,
    /// Whether the addresses of the parameters contain an index, even if the group has only one parameter.
    pub indexed: bool,
    pub quantity: GroupDimensions,
    pub minimum: f64,
    pub role: Role,
}

/// Description of one parameter of theta.
#[derive(Clone, PartialEq, Debug)]
pub struct SlotInfo {
    /// Address of the parameter in the dataset.
    pub address: Address,
    /// Physical dimension.
    pub dimension: Dimension,
    /// Smallest value that ADAMS accepts; minus infinity if there is no limit.
    pub minimum: f64,
}

/// Map between addresses in the dataset and parameters in theta.
///
/// Arguments are stored as groups. A deck with a hundred thousand parts therefore needs only a few entries per statement, not one entry per
/// parameter.
#[derive(Clone, Debug, Default)]
pub struct Catalogue {
    groups: Vec<Group>,
    /// First and last group of each id, for all keywords together.
    ids: QuickMap<Option<u32>, (usize, usize)>,
    /// For each group, the next group with the same id.
    next: Vec<Option<usize>>,
}

impl Catalogue {
    /// Returns the slot of an address, or `None` if theta does not contain the address. The index may be omitted if the argument has only
    /// one parameter.
    pub fn slot(&self, address: &Address) -> Option<Slot> {
        let group = self.find(
            &address.kind,
            address.id,
            address.argument.as_deref(),
            address.index.is_some(),
        )?;
        match address.index {
            None if group.count == 1 => Some(Slot(group.first)),
            Some(k) if (1..=group.count).contains(&k) => Some(Slot(group.first + k - 1)),
            _ => None,
        }
    }

    fn find(
        &self,
        kind: &str,
        id: Option<u32>,
        argument: Option<&str>,
        indexed: bool,
    ) -> Option<&Group> {
        // `SFORCE/3.FUNCTION.1` is a literal of the function, `SFORCE/3` (or `GFORCE/1.FX`) the whole function. The index distinguishes the
        // two.
        let mut first = self.ids.get(&id)?.0;
        while self.groups[first].kind != kind || self.groups[first].argument != argument {
            first = self.next[first]?;
        }
        self.groups[first..]
            .iter()
            .take_while(|g| g.kind == kind && g.id == id && g.argument == argument)
            .find(|g| g.indexed == indexed || (!g.indexed && g.count == 1 && !g.is_override()))
    }

    /// Returns the description of a slot.
    pub fn info(&self, slot: Slot) -> SlotInfo {
        let group = self.group(slot);
        let k = slot.0 - group.first;
        SlotInfo {
            address: Address {
                kind: group.kind.to_string(),
                id: group.id,
                argument: group.argument.map(str::to_string),
                index: group.indexed.then_some(k + 1),
            },
            dimension: group.quantity.of(k),
            minimum: group.minimum,
        }
    }

    /// Returns every slot that has an address, in the order of theta.
    pub fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        self.groups
            .iter()
            .flat_map(|g| (g.first..g.first + g.count).map(Slot))
    }

    /// Returns the number of elements of theta.
    pub fn len(&self) -> usize {
        self.groups.last().map_or(0, |g| g.first + g.count)
    }

    /// Returns whether theta is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn group(&self, slot: Slot) -> &Group {
        let k = self.groups.partition_point(|g| g.first <= slot.0);
        &self.groups[k - 1]
    }

    /// Appends a group and returns its range in theta. Groups of one statement and argument must be appended consecutively.
    pub(crate) fn push(&mut self, mut group: Group) -> Range<usize> {
        group.first = self.len();
        let range = group.first..group.first + group.count;
        let at = self.groups.len();
        let ends = self.ids.entry(group.id).or_insert((at, at));
        if ends.1 < at {
            self.next[ends.1] = Some(at);
            ends.1 = at;
        }
        self.next.push(None);
        self.groups.push(group);
        range
    }
}

impl Group {
    fn is_override(&self) -> bool {
        matches!(self.role, Role::Override(_))
    }
}
