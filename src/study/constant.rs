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

/// Declares the constants of a crate together with `TABLE`, the list of them.
///
/// An entry has a doc comment, a name, a type, a value and a unit. A constant is visible in its crate only; with `pub` before the name,
/// other crates may use it as well.
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

        /// Every constant of this file.
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
