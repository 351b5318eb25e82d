use admire_syntax::Address;

/// A load: its name and the quantity of the deck that it drives.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Load {
    /// Name of the load, which is the heading of its column in the table of load cases.
    pub name: String,
    /// Address in the deck of a whole function (`SFORCE/3`, `GFORCE/1.FX`, `MOTION/1`, `VARIABLE/5`) or of a single value
    /// (`MARKER/19.QP.1`).
    pub target: Address,
}

/// One load case: a label and a value for each load.
#[derive(Clone, PartialEq, Debug)]
pub struct LoadCase {
    /// Label of the load case; any text is allowed.
    pub label: String,
    /// One value for each load, in the units of the deck; angles in radians.
    pub values: Vec<f64>,
}

/// The loads of a deck and the load cases that apply them.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LoadProgramme {
    /// Loads, in the order of the values in each load case.
    pub loads: Vec<Load>,
    /// Load cases, in the order of application.
    pub cases: Vec<LoadCase>,
}
