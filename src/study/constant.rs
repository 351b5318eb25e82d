//! Named constants of the program that affect results. `admire explain priors` lists them.

/// A named constant of the program, with its documentation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Constant {
    /// Name in the source code. For a constant that the user can set, it is also the key in `study.toml`.
    pub name: &'static str,
    /// Default value as written in the source code.
    pub value: &'static str,
    /// Unit of the value; empty for a dimensionless constant.
    pub unit: &'static str,
    /// Meaning of the constant, from its doc comment.
    pub meaning: &'static str,
}

/// Declares the constants of a module, and `TABLE`, which lists them.
///
/// Each entry has a doc comment, a name, a type, a value and a unit. A constant is visible only in its crate, unless `pub` precedes its name.
///
/// ```
/// admire_study::constants! {
///     /// Largest step of ln K in one iteration.
///     MAX_LN_STEP: f64 = 1.5, "ln";
///     /// Significance level of a test.
///     pub LEVEL: f64 = 1e-3, "";
/// }
/// assert_eq!((MAX_LN_STEP, LEVEL), (1.5, 1e-3));
/// assert_eq!(TABLE[1].name, "LEVEL");
/// assert_eq!(TABLE[0].value, "1.5");
/// ```
#[macro_export]
macro_rules! constants {
    (@declare [$($attribute:tt)+] [pub $name:ident] $type:ty = $value:expr) => {
        $($attribute)+ pub const $name: $type = $value;
    };
    (@declare [$($attribute:tt)+] [$name:ident] $type:ty = $value:expr) => {
        $($attribute)+ pub(crate) const $name: $type = $value;
    };
    (@name pub $name:ident) => {
        stringify!($name)
    };
    (@name $name:ident) => {
        stringify!($name)
    };
    ($($(#[doc = $doc:literal])+ $($name:ident)+: $type:ty = $value:expr, $unit:literal;)+) => {
        $($crate::constants!(@declare [$(#[doc = $doc])+] [$($name)+] $type = $value);)+

        /// All constants of this module.
        pub const TABLE: &[$crate::Constant] = &[
            $($crate::Constant {
                name: $crate::constants!(@name $($name)+),
                value: stringify!($value),
                unit: $unit,
                meaning: concat!($($doc),+),
            },)+
        ];
    };
}
