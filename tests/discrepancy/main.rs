//! Hidden effects: each is planted on an axle, the diagnosis sees only the study folder, then the truth is opened.

mod blind;
mod causes;
mod extension;
mod found;
mod hidden;
mod kc_experiment;
mod plant;
#[path = "../common/proportion.rs"]
mod proportion;
