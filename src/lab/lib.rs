//! Tables of K&C laboratories, mapped column by column into measured curves and load cases.
//!
//! 1. [`sheets`] reads a file: CSV with any separator and encoding, or the sheets of a workbook. A [`Sheet`] holds its cells with their positions.
//! 2. [`blocks`] finds title lines, headings, units and rows. A [`Block`] is a table with one line of headings.
//! 3. [`Mapping`] describes each column: characteristic, unit, sign and side. It is a small TOML file. [`Mapping::proposed`] uses only what the
//!    headings themselves state, and [`Mapping::open`] lists the missing information.
//! 4. [`CurveTable`] holds the converted rows. Its text is the table that `admire kc --measured` and the section `[kc]` of a study read.
//!
//! Signs are those of the guide page `kc`. Angles are in degrees, lengths in millimetres, forces in newtons, torques in newton-metres.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]

mod block;
mod characteristic;
mod column;
mod column_text;
mod conversion;
mod curve_table;
mod file_options;
mod file_text;
mod heading;
mod mapping;
mod mapping_text;
mod missing;
mod named_test;
mod open_point;
mod proposal;
mod quantity;
mod resolved;
mod sheet;
mod words;
mod workbook;

pub use block::{Block, blocks};
pub use characteristic::{Characteristic, Target};
pub use column::Column;
pub use curve_table::{Assumed, CurveTable};
pub use file_options::FileOptions;
pub use file_text::sheets;
pub use heading::Heading;
pub use mapping::Mapping;
pub use missing::Missing;
pub use named_test::NamedTest;
pub use open_point::{OpenPoint, complaints};
pub use quantity::Quantity;
pub use sheet::Sheet;
