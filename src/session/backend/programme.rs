use admire_syntax::Address;

/// A load: its name and the quantity it drives.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Load {
    /// Name of the load: its column in the load cases.
    pub name: String,
    /// Address of a whole function (`SFORCE/3`, `GFORCE/1.FX`, `MOTION/1`, `VARIABLE/5`) or of a number (`MARKER/19.QP.1`) of the dataset.
    pub target: Address,
}

/// One load case.
#[derive(Clone, PartialEq, Debug)]
pub struct LoadCase {
    /// Label of the case, any text.
    pub label: String,
    /// One value per load, in the dataset's units; angles in radians.
    pub values: Vec<f64>,
}

/// Loads and load cases.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LoadProgramme {
    /// The driven quantities.
    pub loads: Vec<Load>,
    /// Cases in the order of application.
    pub cases: Vec<LoadCase>,
}
