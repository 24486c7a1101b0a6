//! Tests that cross crates, and what they share: reference data of other codes, plain reference
//! implementations, random bodies, and the bridge from the runtime's bodies to the oracle's.

pub mod agreement;
pub mod block;
pub mod bodies;
pub mod bridge;
pub mod canaries;
pub mod chance;
pub mod fuzz;
pub mod laws;
pub mod materials;
pub mod naive;
pub mod plain;
pub mod pulse;
pub mod reference;
pub mod steps;
pub mod twins;
