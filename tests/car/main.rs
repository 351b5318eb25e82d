//! Files of Adams/Car: reading, editing, and results of a study that are written back.

#[path = "../common/mod.rs"]
mod common;

#[path = "../common/car_axle.rs"]
mod car_axle;
mod field;
mod learned_curve;
mod real_files;
mod toolkit;
mod written_back;
