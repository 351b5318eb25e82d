//! Standard load programmes of a rig that loads one wheel.

/// A standard programme of vertical, lateral and longitudinal loads at one wheel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LoadTable {
    /// Table 1 of the paper by Meissonnier et al. (see guide page `paper`): thirteen load cases, each applied from zero load.
    Table1,
    /// Table 2 of the paper by Meissonnier et al. (see guide page `paper`): seventeen load cases, in the order in which they were applied on
    /// the rig.
    Table2,
    /// Programme that shows hysteresis: each load is raised and lowered, and the lateral and longitudinal loads are also reversed.
    UpAndDown,
}

const TABLE_1: &[[f64; 3]] = &[
    [1500.0, 0.0, 0.0],
    [3000.0, 0.0, 0.0],
    [4500.0, 0.0, 0.0],
    [6000.0, 0.0, 0.0],
    [7500.0, 0.0, 0.0],
    [4500.0, -4000.0, 0.0],
    [4500.0, -2000.0, 0.0],
    [4500.0, 2000.0, 0.0],
    [4500.0, 4000.0, 0.0],
    [4500.0, 0.0, -4000.0],
    [4500.0, 0.0, -2000.0],
    [4500.0, 0.0, 2000.0],
    [4500.0, 0.0, 4000.0],
];

const TABLE_2: &[[f64; 3]] = &[
    [4500.0, 0.0, 0.0],
    [5980.0, 0.0, 0.0],
    [7500.0, 0.0, 0.0],
    [3030.0, 0.0, 0.0],
    [1510.0, 0.0, 0.0],
    [4600.0, 1000.0, 0.0],
    [4340.0, -1000.0, 0.0],
    [4480.0, 0.0, 1000.0],
    [4470.0, 0.0, -1000.0],
    [5873.0, 1000.0, 0.0],
    [5950.0, -1000.0, 0.0],
    [5920.0, 0.0, 1000.0],
    [5920.0, 0.0, -1000.0],
    [3370.0, 1000.0, 0.0],
    [2780.0, -1000.0, 0.0],
    [3040.0, 0.0, 1000.0],
    [3090.0, 0.0, -1000.0],
];

const UP_AND_DOWN: &[[f64; 3]] = &[
    [1500.0, 0.0, 0.0],
    [3000.0, 0.0, 0.0],
    [4500.0, 0.0, 0.0],
    [6000.0, 0.0, 0.0],
    [4500.0, 0.0, 0.0],
    [3000.0, 0.0, 0.0],
    [3000.0, 1000.0, 0.0],
    [3000.0, 2000.0, 0.0],
    [3000.0, 1000.0, 0.0],
    [3000.0, 0.0, 0.0],
    [3000.0, -1000.0, 0.0],
    [3000.0, -2000.0, 0.0],
    [3000.0, 0.0, 0.0],
    [3000.0, 0.0, 1500.0],
    [3000.0, 0.0, 3000.0],
    [3000.0, 0.0, 1500.0],
    [3000.0, 0.0, 0.0],
    [3000.0, 0.0, -1500.0],
    [3000.0, 0.0, 0.0],
];

impl LoadTable {
    /// Returns the vertical, lateral and longitudinal load of each case, in newtons and in the order of application.
    pub(crate) const fn loads(self) -> &'static [[f64; 3]] {
        match self {
            Self::Table1 => TABLE_1,
            Self::Table2 => TABLE_2,
            Self::UpAndDown => UP_AND_DOWN,
        }
    }

    /// Formats the programme as a CSV file of load cases with the columns `case`, `vertical`, `lateral` and `longitudinal`. Cases are numbered
    /// from 1.
    pub fn csv(self) -> String {
        let mut text = String::from("case,vertical,lateral,longitudinal\n");
        for (k, [vertical, lateral, longitudinal]) in self.loads().iter().enumerate() {
            text += &format!("{},{vertical},{lateral},{longitudinal}\n", k + 1);
        }
        text
    }
}
