//! Slips: a load column in another unit, a turned sign, an exchanged coordinate. They are looked for before any fit.
//!
//! A study whose best fit leaves more than tolerances can explain is fitted again with one number changed at a time, as a known slip
//! would change it. Refused is only what one such change explains. Knows no cause a model may lack: that is diagnosis.
//!
//! The study is thinned to a few cases that span its loads, so that the whole search costs no more than one fit of all cases.

mod apart;
mod bench;
mod candidate;
mod search;
mod thinned;
mod unit_pairs;

pub use apart::displaced;
pub use search::search;
