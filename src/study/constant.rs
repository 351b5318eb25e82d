//! Numbers that decide something, as `admire explain priors` lists them.

/// A named number of the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Constant {
    /// Name in the source, and key of `study.toml` where it is settable.
    pub name: &'static str,
    /// Default value as written in the source.
    pub value: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// Meaning in a sentence.
    pub meaning: &'static str,
}

/// Declares constants together with `TABLE`, the list of them. Each is documented, has a unit and a value.
#[macro_export]
macro_rules! constants {
    ($($(#[doc = $doc:literal])+ $name:ident: $type:ty = $value:expr, $unit:literal;)+) => {
        $($(#[doc = $doc])+ pub(crate) const $name: $type = $value;)+

        /// Every constant of this file.
        pub const TABLE: &[$crate::Constant] = &[
            $($crate::Constant {
                name: stringify!($name),
                value: stringify!($value),
                unit: $unit,
                meaning: concat!($($doc),+),
            },)+
        ];
    };
}
