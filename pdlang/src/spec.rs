//! The law as data, as the runtime reads it: field by field the contract of the runtime's `spec` module.

use serde::Serialize;

use crate::tape::Tape;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spec {
    pub law: String,
    pub title: String,
    pub cites: Vec<String>,
    pub flavours: Vec<&'static str>,
    pub dim: usize,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub linearised: bool,
    pub params: Vec<ParamSpec>,
    pub influences: Vec<InfluenceSpec>,
    pub families: Vec<FamilySpec>,
    pub fields: Vec<FieldSpec>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartSpec>,
    pub histories: Vec<HistorySpec>,
    pub weights: Vec<WeightSpec>,
    pub slots: Vec<SlotSpec>,
    pub constants: Tape,
    pub sweeps: Vec<SweepSpec>,
    pub force: Vec<u32>,
    pub tangent: Vec<u32>,
    pub energy: Option<u32>,
    pub rates: Vec<RateSpec>,
    pub after_step: Vec<u32>,
    pub breaks: bool,
    pub pairwise: bool,
    pub named: Vec<(String, Vec<u32>)>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParamSpec {
    pub name: String,
    pub doc: String,
    pub unit: String,
    pub exponents: [i16; 7],
    pub lower: Option<(f64, bool)>,
    pub upper: Option<(f64, bool)>,
    pub default: Option<Number>,
    pub meet: crate::ir::Meet,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Number {
    Finite(f64),
    Infinite,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InfluenceFn {
    pub name: String,
    pub params: Vec<ParamSpec>,
    pub body: Tape,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InfluenceSpec {
    pub name: String,
    pub default: Option<InfluenceFn>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FamilySpec {
    pub name: String,
    pub filter: Option<Tape>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldSpec {
    pub name: String,
    pub slots: Vec<u32>,
    pub components: Vec<String>,
    pub exponents: [i16; 7],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartSpec {
    pub condition: String,
    pub slot: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RateSpec {
    pub field: u32,
    pub rate: u32,
    pub damping: Option<u32>,
    pub stepped: Stepped,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Stepped {
    Together,
    Alone,
    Half,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistorySpec {
    pub name: String,
    pub bond: bool,
    pub family: u32,
    pub initial: f64,
    pub slot: Option<(u32, u32)>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeightSpec {
    pub name: String,
    pub doc: String,
    pub family: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlotSpec {
    pub name: String,
    pub kind: SlotKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum SlotKind {
    Velocity(u8),
    Position(u8),
    Increment(u8),
    TimeStep,
    State,
    Computed(Stage),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Stage {
    Reference,
    Part,
    Family,
    Step,
    Energy,
    Tangent,
    Update,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepSpec {
    pub name: String,
    pub stage: Stage,
    pub family: u32,
    pub reference: bool,
    pub kills: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub single: bool,
    pub own: Vec<u32>,
    pub nbr: Vec<u32>,
    pub out: Vec<u32>,
    pub history: Vec<u32>,
    pub geometry: Tape,
    pub streams: Tape,
    pub from_streams: Tape,
    pub pre: Tape,
    pub bond: Tape,
    pub accumulators: u32,
    pub post: Tape,
}

impl Spec {
    pub fn json(&self) -> String {
        // Only non-finite numbers could fail, and those are written as variants.
        serde_json::to_string(self).unwrap_or_default()
    }
}
