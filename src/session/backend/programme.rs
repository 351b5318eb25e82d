use admire_syntax::Address;

/// One load: a name and what it drives.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Load {
    /// Its name: the column of the load cases.
    pub name: String,
    /// A whole function (`SFORCE/3`, `GFORCE/1.FX`, `MOTION/1`, `VARIABLE/5`) or a number (`MARKER/19.QP.1`) of the dataset.
    pub target: Address,
}

/// One load case.
#[derive(Clone, PartialEq, Debug)]
pub struct LoadCase {
    /// A free label.
    pub label: String,
    /// One value per load, in the dataset's units, angles in radians.
    pub values: Vec<f64>,
}

/// Loads and the cases in the order in which they are applied.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LoadProgramme {
    /// The loads.
    pub loads: Vec<Load>,
    /// The cases, in the order of application.
    pub cases: Vec<LoadCase>,
}
