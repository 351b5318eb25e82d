//! Kinematics and compliance: characteristics compared with real ADAMS results, with finite differences and with sweeps.

#![allow(non_snake_case)] // Rotation matrices keep their capitals.

mod adams_car;
mod axles;
mod command;
#[path = "../common/mod.rs"]
mod common;
mod compliance;
mod friction;
mod import;
mod invariance;
mod patch;
mod real;
mod rebuilt;
mod run;
mod tune;
mod whole_rig;
