use std::ops::Deref;

use super::Number;

/// The numbers of one argument. Most arguments have one, which needs no memory of its own.
#[derive(Clone, PartialEq, Debug)]
pub enum Numbers {
    /// One.
    One(Number),
    /// None or several.
    Several(Box<[Number]>),
}

impl Deref for Numbers {
    type Target = [Number];

    fn deref(&self) -> &[Number] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Several(numbers) => numbers,
        }
    }
}

impl From<&[Number]> for Numbers {
    fn from(numbers: &[Number]) -> Self {
        match numbers {
            [one] => Self::One(*one),
            several => Self::Several(several.into()),
        }
    }
}
