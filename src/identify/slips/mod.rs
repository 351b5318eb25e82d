//! Search for slips in the input before any fit: a load column in a wrong unit, a wrong sign, or exchanged coordinates.
//!
//! If the best fit of a study leaves residuals that tolerances cannot explain, the fit is repeated with one change of the input at a time. Each
//! change corrects a known kind of slip. A study is rejected only if one such change explains the readings. Effects that the model lacks are
//! the subject of the diagnosis.
//!
//! The search uses only a few load cases that span the loads, so it costs no more than one fit of all cases.

mod apart;
mod bench;
mod candidate;
mod search;
mod thinned;
mod unit_pairs;

pub use apart::displaced;
pub use search::search;
