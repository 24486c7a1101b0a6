//! Mass density of the nodes: one number, or one per layout slot where materials differ.
use crate::body::Body;
use crate::engine::Engine;

/// Mass density [kg/m^3].
#[derive(Clone, Debug)]
pub struct Density {
    least: f64,
    /// Per layout slot; empty where all nodes have `least`.
    slots: Vec<f64>,
}

impl Density {
    /// From one value per material; what no node has counts as well for the least.
    pub(crate) fn new(materials: &[f64], body: &Body, engine: &Engine) -> Density {
        let least = materials.iter().copied().fold(f64::INFINITY, f64::min);
        let mut slots = Vec::new();
        if materials.iter().any(|d| *d != least) {
            slots = vec![least; engine.len()];
            for (slot, material) in engine.slots().iter().zip(&body.material) {
                slots[*slot as usize] = materials[*material as usize];
            }
        }
        Density { least, slots }
    }

    /// The same everywhere.
    pub fn uniform(density: f64) -> Density {
        Density {
            least: density,
            slots: Vec::new(),
        }
    }

    pub fn least(&self) -> f64 {
        self.least
    }

    /// Per layout slot, where nodes differ.
    pub fn slots(&self) -> Option<&[f64]> {
        (!self.slots.is_empty()).then_some(&self.slots)
    }

    #[inline]
    pub fn at(&self, slot: usize) -> f64 {
        self.slots.get(slot).copied().unwrap_or(self.least)
    }
}
