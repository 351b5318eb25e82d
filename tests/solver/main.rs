//! The static solver, compared with independent equilibria and closed forms, and checked for invariances.

#![allow(non_snake_case)] // Forces, torques and rotation matrices keep their capitals.

mod balance;
mod car_bushing;
#[path = "../common/car_deck.rs"]
mod car_deck;
mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod conservation;
#[path = "../common/conserved.rs"]
mod conserved;
mod coverage;
mod data;
mod deck;
mod derivatives;
mod differences;
mod double_wishbone;
mod elements;
mod energy;
mod frames;
mod functions;
mod invariance;
mod rank;
mod real_decks;
mod reference;
mod robust;
mod sensitivity;
mod stability;
mod user_force;
