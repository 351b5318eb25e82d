use std::fmt;

/// The address of an object or of one of its numbers: `BUSHING/12.K.2`, `MARKER/7.QP.1`, `SFORCE/3`, `SFORCE/3.FUNCTION.2` (the
/// second number of that function's text). Indices are 1-based. The kind is the whole keyword in capitals.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Address {
    /// Whole keyword in capitals; for singletons too (`EQUILIBRIUM`).
    pub kind: String,
    /// Id; absent for singletons.
    pub id: Option<u32>,
    /// Argument, whole keyword in capitals.
    pub argument: Option<String>,
    /// Which of its values, from 1.
    pub index: Option<usize>,
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.kind)?;
        if let Some(id) = self.id {
            write!(f, "/{id}")?;
        }
        if let Some(argument) = &self.argument {
            write!(f, ".{argument}")?;
        }
        if let Some(index) = self.index {
            write!(f, ".{index}")?;
        }
        Ok(())
    }
}
