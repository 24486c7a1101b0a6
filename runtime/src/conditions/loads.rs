//! Forces on few nodes: body forces of a scene, and contact.

use super::Driver;
use crate::density::Density;

/// Forces on a few nodes [N/m^3], layout order.
#[derive(Default)]
pub struct Loads {
    pub density: Vec<Vec<f64>>,
    pub touched: Vec<u32>,
}

impl Loads {
    pub fn new(dim: usize, len: usize) -> Loads {
        Loads {
            density: vec![vec![0.0; len]; dim],
            touched: Vec::new(),
        }
    }

    pub fn bytes(&self) -> usize {
        let density: usize = self.density.iter().map(Vec::len).sum();
        8 * density + 4 * self.touched.len()
    }

    /// Component `d` at slot `s`; loads that are never used hold no numbers.
    pub fn at(&self, d: usize, s: usize) -> f64 {
        self.density[d].get(s).copied().unwrap_or(0.0)
    }

    /// `v += dt * f / density` where there is a force.
    pub fn kick(&self, v: &mut [Vec<f64>], density: &Density, dt: f64) {
        for (v, f) in v.iter_mut().zip(&self.density) {
            self.touched
                .iter()
                .map(|&s| s as usize)
                .for_each(|s| v[s] += dt / density.at(s) * f[s]);
        }
    }

    /// Work of these forces along `dt * v` [J].
    pub fn work(&self, v: &[Vec<f64>], volume: &[f64], dt: f64) -> f64 {
        let slots = self.touched.iter().map(|&s| s as usize);
        slots
            .map(|s| {
                volume[s]
                    * (0..v.len())
                        .map(|d| self.density[d][s] * dt * v[d][s])
                        .sum::<f64>()
            })
            .sum()
    }
}

/// Room for the forces of these conditions.
pub(super) fn loaded(force: &[Driver], dim: usize, len: usize) -> Loads {
    let mut loads = Loads::new(dim, if force.is_empty() { 0 } else { len });
    loads.touched = force.iter().flat_map(|d| d.slots.iter().copied()).collect();
    loads.touched.sort_unstable();
    loads.touched.dedup();
    loads
}
