use std::ops::Range;

use admire_syntax::Address;
use admire_syntax::grammar::{ArgumentDef, Components};
use admire_syntax::hash::QuickMap;
use admire_syntax::units::Dimension;

/// Index of one number of theta.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Slot(pub usize);

/// Meaning of the numbers of a group, for derivatives with respect to them.
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
    /// Number literals of a function.
    Literals(usize),
    /// Constant that replaces a whole function.
    Override(usize),
}

/// Dimensions of the numbers of a group.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum GroupDimensions {
    /// Single dimension for all numbers.
    Same(Dimension),
    /// Dimensions by component, as the grammar defines them for an argument.
    Of(Components),
    /// Stiffness matrix of n by n numbers, column by column, composed of 6 by 6 blocks.
    MultiStiffness(usize),
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
            Self::Of(components) => components.of(k),
            Self::MultiStiffness(n) => Components::Stiffness.of(k % n % 6 + 6 * (k / n % 6)),
        };
        component.unwrap_or(Dimension::NONE)
    }
}

/// Numbers of one argument of one statement.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub kind: &'static str,
    pub id: Option<u32>,
    pub argument: Option<&'static str>,
    pub first: usize,
    pub count: usize,
    /// Whether addresses carry an index even for a single number.
    pub indexed: bool,
    pub quantity: GroupDimensions,
    pub minimum: f64,
    pub role: Role,
}

/// Description of one slot.
#[derive(Clone, PartialEq, Debug)]
pub struct SlotInfo {
    /// Address in the dataset.
    pub address: Address,
    /// Physical dimension.
    pub dimension: Dimension,
    /// Smallest value that ADAMS accepts; minus infinity if there is no limit.
    pub minimum: f64,
}

/// Map between numbers of the dataset and elements of theta.
///
/// Arguments are stored as groups, so a deck of a hundred thousand parts needs a few entries per statement and not one per number.
#[derive(Clone, Debug, Default)]
pub struct Catalogue {
    groups: Vec<Group>,
    /// First and last group of each id, whatever the keyword.
    ids: QuickMap<Option<u32>, (usize, usize)>,
    /// Next group with the same id, for each group.
    next: Vec<Option<usize>>,
}

impl Catalogue {
    /// Returns the slot of an address. The index may be omitted if the argument has one number. `None` if theta does not contain it.
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
        // `SFORCE/3.FUNCTION.1` is a literal, `SFORCE/3` (or `GFORCE/1.FX`) the whole function; the index distinguishes them.
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

    /// Returns every slot that has an address, in order.
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
