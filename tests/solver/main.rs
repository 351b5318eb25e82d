//! The static solver against independent equilibria, closed forms and its own invariances.

#![allow(non_snake_case)] // Forces, torques and rotation matrices keep their capitals.

#[path = "../common/mod.rs"]
mod common;
mod deck;
mod derivatives;
mod elements;
mod rank;
mod reference;
mod robust;
mod speed;
