//! Tests of hidden effects: each is planted on an axle, the diagnosis sees only the study folder, and then the truth is opened.

mod adams_car_axle;
mod arm;
mod axles;
mod blind;
#[path = "../common/car_axle.rs"]
mod car_axle;
mod car_bushing;
mod causes;
mod chain;
#[path = "../common/mod.rs"]
mod common;
mod extension;
mod few;
mod found;
mod frames;
mod friction;
mod hidden;
mod kc_curves;
mod kc_experiment;
mod loads;
mod mark_places;
mod plant;
#[path = "../common/proportion.rs"]
mod proportion;
mod remainder;
mod units;
mod unseen;
