//! Everything that changes during a run, in one structure.
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The state of a body. Node arrays are in layout order (see [`crate::engine::Engine::slots`]), SI units.
///
/// Forces, energies and tangents are functions of it; a checkpoint is this structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub step: u64,
    /// [s]
    pub time: f64,
    /// Length of the step that leads here [s]: the time since the histories were committed.
    pub dt: f64,
    /// Displacement [m] and velocity [m/s], one array per dimension.
    pub u: Vec<Vec<f64>>,
    pub v: Vec<Vec<f64>>,
    /// Fields and node histories.
    pub slots: Vec<Vec<f64>>,
    pub families: Vec<FamilyState>,
}

/// Where a bond is found in [`FamilyState::intact`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bond {
    pub(crate) row: u32,
    pub(crate) bit: u8,
}

/// Bonds of one family.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FamilyState {
    /// Eight bonds a byte; the masks of the family itself until one is broken. Call [`FamilyState::touch`] after changing it
    /// by hand.
    pub intact: Arc<Vec<u8>>,
    /// One array per bond history of the law, eight values per byte of `intact`.
    pub history: Vec<Vec<f64>>,
    /// Differs whenever `intact` may differ, so that an engine knows when what it derived is stale.
    #[serde(skip, default = "fresh")]
    pub(crate) stamp: u64,
    /// Differs whenever `history` may differ. Call [`FamilyState::remember`] after changing it by hand.
    #[serde(skip, default = "fresh")]
    pub(crate) memory: u64,
}

impl PartialEq for FamilyState {
    fn eq(&self, other: &Self) -> bool {
        self.intact == other.intact && self.history == other.history
    }
}

impl FamilyState {
    pub(crate) fn new(intact: Arc<Vec<u8>>, history: Vec<Vec<f64>>) -> FamilyState {
        FamilyState {
            intact,
            history,
            stamp: fresh(),
            memory: fresh(),
        }
    }

    /// Whether a bond is intact.
    #[inline]
    pub fn holds(&self, bond: Bond) -> bool {
        self.intact[bond.row as usize] & bond.bit != 0
    }

    /// Says that `intact` was changed.
    pub fn touch(&mut self) {
        self.stamp = fresh();
    }

    /// Says that `history` was changed.
    pub fn remember(&mut self) {
        self.memory = fresh();
    }
}

fn fresh() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}
