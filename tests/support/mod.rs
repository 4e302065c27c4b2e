//! Reference models with known true values, and helpers for the tests. No reference model uses the model
//! under test.

pub mod axis;
pub mod axis_template;
pub mod bench_equations;
pub mod command;
pub mod coupling;
pub mod everything;
pub mod finite_elements;
pub mod frf_set;
pub mod pages;
pub mod two_masses;

use std::sync::Arc;

use config::{MachineConfig, read_machine};
use dynamics::model::{RodModel, Structure};
use machine::Machine;

/// Reads a machine configuration by its path.
pub fn config(name: &str) -> MachineConfig {
    read_machine(name, &[], &[]).unwrap()
}

/// Assembles the structure for the direct receptance of the table.
pub fn table_structure(machine: &Machine, rods: RodModel) -> Arc<Structure> {
    let table = machine.point("table").unwrap();
    Arc::new(Structure::new(machine, table, table, rods).unwrap())
}

/// Nut positions of the bench (m).
pub const POSITIONS: [(&str, f64); 6] =
    [("l1", 0.6), ("l2", 0.8), ("l3", 1.0), ("l4", 1.3), ("l5", 1.6), ("l6", 1.9)];

/// A small reproducible random number generator.
pub struct Draws(pub u64);

impl Draws {
    /// Draws a number uniformly from [0, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Draws a standard normal number by the Box–Muller transform.
    pub fn normal(&mut self) -> f64 {
        let u = 1.0 - self.next();
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * self.next()).cos()
    }
}
