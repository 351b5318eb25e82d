//! Search for input slips before any fit: a load column in a wrong unit, a wrong sign, or exchanged coordinates.
//!
//! If the best fit of a study leaves more than tolerances can explain, the fit is repeated with one number changed at a time. Each change
//! corrects a known kind of slip. A study is rejected only if one such change explains the readings. Effects missing from the model are the
//! subject of diagnosis.
//!
//! The study is reduced to a few cases that span its loads, so that the whole search costs no more than one fit of all cases.

mod apart;
mod bench;
mod candidate;
mod search;
mod thinned;
mod unit_pairs;

pub use apart::displaced;
pub use search::search;
