//! Kinematics and compliance: characteristics against real ADAMS results, against differences and against their own sweeps.

#![allow(non_snake_case)] // Rotation matrices keep their capitals.

#[path = "../common/mod.rs"]
mod common;
mod real;
