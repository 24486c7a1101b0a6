//! A law as data. The compiler writes it as JSON, generated code carries that text, and the runtime reads it.
//!
//! Everything a law is to the runtime stands here: parameters, influence functions, node slots, the
//! tape of constants, and the sweeps in the order in which they run. A tape is a list of operations in
//! single-assignment form: operation number n defines register n.

use serde::{Deserialize, Serialize};

/// A law at one dimension (1, 2 or 3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    pub law: String,
    pub title: String,
    pub cites: Vec<String>,
    /// Names of the flavours that the law is meant for; none: all.
    pub flavours: Vec<String>,
    pub dim: usize,
    /// Holds for small displacements only: forces are linear in them, and directions those of the reference.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub linearised: bool,
    pub params: Vec<ParamSpec>,
    pub influences: Vec<InfluenceSpec>,
    /// The first is the whole horizon.
    pub families: Vec<FamilySpec>,
    pub fields: Vec<FieldSpec>,
    /// Parts of the body that fields live on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartSpec>,
    pub histories: Vec<HistorySpec>,
    /// Numbered behind the histories where a sweep lists what it reads and writes on bonds.
    pub weights: Vec<WeightSpec>,
    /// Node values, one scalar each.
    pub slots: Vec<SlotSpec>,
    /// Outputs are the constants that sweeps read. Reads `Param`, `Delta`, `Case`, `Ball`.
    pub constants: Tape,
    pub sweeps: Vec<SweepSpec>,
    /// Slots of the force density [N/m^3], one per dimension; empty for a law without momentum.
    pub force: Vec<u32>,
    /// Slots of the derivative of the force along the increment.
    pub tangent: Vec<u32>,
    /// Slot of the strain energy density [J/m^3].
    pub energy: Option<u32>,
    /// One per component of a field that changes by itself.
    pub rates: Vec<RateSpec>,
    /// Slots, written by update sweeps, of what replaces the velocity when a step is accepted; none or one per dimension.
    pub after_step: Vec<u32>,
    /// True when a bond can break.
    pub breaks: bool,
    /// Proved by the compiler: the force on i from j is minus the force on j from i, along M, or along xi
    /// where the law is linearised.
    pub pairwise: bool,
    /// Node values with a name in the law that a user may ask for as output: (name, slots).
    pub named: Vec<(String, Vec<u32>)>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParamSpec {
    pub name: String,
    pub doc: String,
    /// As a user writes it, e.g. `"Pa"` or `"kg m^-3"`; empty for a number.
    pub unit: String,
    /// Seven SI exponents (m, kg, s, A, K, mol, cd), doubled.
    pub exponents: [i16; 7],
    /// (value, whether the value itself is allowed).
    pub lower: Option<(f64, bool)>,
    pub upper: Option<(f64, bool)>,
    pub default: Option<Number>,
    /// The value on a bond between two materials.
    pub meet: Meet,
}

/// How the values of a parameter at the two ends of a bond become one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Meet {
    /// (a + b)/2
    #[default]
    Arithmetic,
    /// 2 a b/(a + b)
    Harmonic,
    /// 1/(fa/a + fb/b), `fa` and `fb` being the fractions of the bond in the two materials.
    Series,
    Min,
    Max,
    /// As the law writes it, and as a tape: `Var(0)` and `Var(1)` are the values of the two ends, `Var(2)` and `Var(3)`
    /// the fractions of the bond in their materials.
    Formula(String, Tape),
}

/// A finite or infinite number; JSON has no infinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Number {
    Finite(f64),
    Infinite,
}

/// An influence function: `body` reads `Var(0)` = r, `Var(1 + k)` = parameter k, `Delta`; one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InfluenceFn {
    pub name: String,
    pub params: Vec<ParamSpec>,
    pub body: Tape,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InfluenceSpec {
    pub name: String,
    pub default: Option<InfluenceFn>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FamilySpec {
    pub name: String,
    /// One Boolean output; reads what a geometry tape reads.
    pub filter: Option<Tape>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldSpec {
    pub name: String,
    /// Component slots, one for a scalar.
    pub slots: Vec<u32>,
    /// What distinguishes their names: `_x`, `_xy`; empty for a scalar.
    pub components: Vec<String>,
    pub exponents: [i16; 7],
    /// The part of the body that it lives on, by its position in [`Spec::parts`]; none: all. Elsewhere it is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<u32>,
}

/// A part of the body, decided node by node when the coefficients of a run are set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartSpec {
    /// As the law writes it.
    pub condition: String,
    /// Slot, written by a sweep of the stage [`Stage::Part`], that is not zero at the nodes of the part.
    pub slot: u32,
}

/// The rate of a field component: `rate - damping*field`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateSpec {
    pub field: u32,
    pub rate: u32,
    /// Slot of the damping [1/s], where there is one.
    pub damping: Option<u32>,
    pub stepped: Stepped,
}

/// How a field goes from one step to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stepped {
    /// By the stages of a scheme that all such fields share: their rates depend on them. No damping is split off.
    Together,
    /// At once, by the trapezoidal rule: rate and damping do not change with what is stepped.
    Alone,
    /// As `Alone`, from the middle of one step to the middle of the next, before the force is evaluated.
    Half,
}

/// Memory that only an update sweep changes. One scalar each (components are separate entries).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistorySpec {
    pub name: String,
    pub bond: bool,
    pub family: u32,
    pub initial: f64,
    /// Node histories: the slot that holds the committed value, and the slot an update sweep writes.
    pub slot: Option<(u32, u32)>,
}

/// A correction factor on the bonds of a family: written once, by a sweep of the reference stage, or 1 where the
/// scene says so. The same weight on another family is another entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WeightSpec {
    pub name: String,
    pub doc: String,
    pub family: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlotSpec {
    pub name: String,
    pub kind: SlotKind,
    /// The part of the body outside of which nobody needs it: a field that lives there, or what it is stepped with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlotKind {
    /// Component of the displacement, velocity or reference position: state.
    Displacement(u8),
    Velocity(u8),
    Position(u8),
    /// Component of the increment that the tangent acts on.
    Increment(u8),
    /// The time step [s], the same everywhere.
    TimeStep,
    /// Field or node history: state.
    State,
    /// Written by a sweep of this stage.
    Computed(Stage),
}

/// When a sweep runs. Sweeps stand in the order of their stages, and within a stage in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Stage {
    /// Once, on the whole body.
    Reference,
    /// Once, when the coefficients of a run are set: says where fields live.
    Part,
    /// At the start, and again for nodes whose family changed.
    Family,
    /// At every force evaluation. Those with `kills` break the bonds of their family, one after the other.
    Step,
    /// When the energy is asked for, after a force evaluation at the same state.
    Energy,
    /// At every application of the tangent, after a force evaluation at the same state.
    Tangent,
    /// Once per accepted step, after the forces: writes the next histories.
    Update,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepSpec {
    pub name: String,
    pub stage: Stage,
    pub family: u32,
    /// True: over the reference family, broken or not (`sum0`); false: over intact bonds.
    pub reference: bool,
    /// True: the bond tape holds a `Kill`.
    pub kills: bool,
    /// True: in no sum does what stays as it is meet what moves, so that single precision keeps the digits of small
    /// displacements. Of sweeps of the steps.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub single: bool,
    /// Slots read at the node, slots read at the other end, slots written.
    pub own: Vec<u32>,
    pub nbr: Vec<u32>,
    pub out: Vec<u32>,
    /// Bond histories and weights read or written.
    pub history: Vec<u32>,
    /// Reads `Const`, `Xi`, `X`, `Omega`, `Weight`; its outputs are the `Geo` values of the bond tape.
    pub geometry: Tape,
    /// Reads the same; what a cloud keeps of a bond.
    pub streams: Tape,
    /// Reads `Xi`, `Ix`, and `Geo` for the streams by position; the same outputs as `geometry`, up to rounding.
    pub from_streams: Tape,
    /// Reads `Const`, `Own`; outputs are the `Pre` values of the bond and post tapes.
    pub pre: Tape,
    /// Reads `Pre`, `Geo`, `Nbr`, `Xi`, `Eta`, `Ix`, `History`, `Reverse`; no outputs, but effects. Empty: no loop over bonds.
    pub bond: Tape,
    /// Number of accumulators. Sums start at 0, those of a `MaxTo` at minus infinity.
    pub accumulators: u32,
    /// Reads `Pre`, `Acc`; outputs go to `out`.
    pub post: Tape,
}

impl SweepSpec {
    /// A cloud keeps all values of geometry: the simplest choice, for sweeps written by hand.
    #[must_use]
    pub fn keeping_all(mut self) -> SweepSpec {
        let n = self.geometry.outs.len() as u32;
        self.streams = self.geometry.clone();
        self.from_streams = Tape {
            ops: (0..n).map(Op::Geo).collect(),
            outs: (0..n).collect(),
        };
        self
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tape {
    pub ops: Vec<Op>,
    /// Registers of the outputs.
    pub outs: Vec<u32>,
}

/// Operands are register numbers unless said otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Op {
    Lit(f64),
    Inf,
    /// Constant of the law, by its position among the outputs of `Spec::constants`.
    Const(u32),
    Param(u32),
    Var(u32),
    /// The horizon [m].
    Delta,
    Own(u32),
    Nbr(u32),
    Geo(u32),
    Pre(u32),
    Acc(u32),
    History(u32),
    Reverse(u32),
    Xi(u8),
    Eta(u8),
    /// 1/|xi|, in bond tapes.
    Ix,
    /// |xi|, in geometry, filter and ball tapes.
    X,
    /// Influence function at |xi|, in geometry, filter and ball tapes.
    Omega(u32),
    /// Volume of the other end times the partial-volume factor [m^3], in geometry tapes.
    Weight,
    /// One register per flavour: bar, slab, plane stress, plane strain, 3d.
    Case([u32; 5]),
    /// Integral of a one-output tape (reads `Param`, `Delta`, `X`, `Omega`) over the whole horizon.
    Ball(Box<Tape>),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    /// a * b + c.
    Fma(u32, u32, u32),
    Neg(u32),
    Abs(u32),
    Min(u32, u32),
    Max(u32, u32),
    Sqrt(u32),
    Rsqrt(u32),
    Exp(u32),
    Ln(u32),
    Sin(u32),
    Cos(u32),
    Tan(u32),
    Pow(u32, u32),
    Powi(u32, i32),
    /// Truth values.
    Lt(u32, u32),
    Le(u32, u32),
    And(u32, u32),
    Or(u32, u32),
    Not(u32),
    /// Condition, then, else.
    Select(u32, u32, u32),
    /// Effect: break the bond where the condition holds.
    Kill(u32),
    /// Effect: accumulator number += a * b.
    AddTo(u32, u32, u32),
    /// Effect: accumulator number = the larger of it and a.
    MaxTo(u32, u32),
    /// Effect: next value of a history (position in the sweep's list, value).
    PutHistory(u32, u32),
}
