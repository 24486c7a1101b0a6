//! The typed IR: what a law means, before anything is derived from it.
//!
//! Contract. A [`Law`] is resolved (no names, only typed ids), checked (shapes, homes, units, no cycles)
//! and independent of dimension and flavour: a `Vector` has as many components as the scene has
//! dimensions. Definitions are in dependency order: an expression refers only to definitions with a
//! smaller id. Library functions (`K_d`, `hooke`, ..) and library bond quantities (`e`, `s`, `M`, ..) come
//! from the prelude, which is text in the language: functions are inlined here, bond quantities are
//! ordinary definitions. The oracle interprets this IR directly; `lower` turns it into polynomials.
//!
//! Where a value lives ([`Home`]): a constant is one number per material, a node value one per node, a
//! bond value one per *directed* bond i -> j, seen from i. Only reductions take a bond expression to a
//! node, and only [`ExprKind::Prime`] reaches the other end.
//!
//! Not in the IR: stages (inferred later), volumes (every reduction is weighted by the neighbour's volume
//! times its partial-volume factor), the sum of the two ends in the equation of motion.

use crate::span::Span;
use crate::tape::Tape;
use crate::units::Unit;

macro_rules! id {
    ($($(#[$doc:meta])* $name:ident),*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
        pub struct $name(pub u32);
        impl $name {
            pub fn index(self) -> usize { self.0 as usize }
        }
    )*};
}
id!(
    /// An expression in [`Law::exprs`].
    ExprId,
    /// A parameter of the law.
    ParamId,
    /// A definition (`let`, `node`, `bond`).
    DefId,
    /// An influence function of the law.
    InfluenceId,
    /// A scalar or tensor field other than the displacement, with a `rate`.
    FieldId,
    /// A bond or node history.
    HistoryId,
    /// A family; 0 is the ball of radius delta.
    FamilyId,
    /// A weight.
    WeightId
);

/// A checked law.
#[derive(Clone, Debug)]
pub struct Law {
    pub name: String,
    /// Where the name stands.
    pub span: Span,
    pub title: String,
    /// Papers with equation numbers, as written.
    pub cites: Vec<String>,
    /// The flavours that the law is meant for.
    pub flavours: Vec<Flavour>,
    pub params: Vec<Param>,
    pub influences: Vec<Influence>,
    /// The first is always `horizon`: every bond of the ball of radius delta.
    pub families: Vec<Family>,
    pub fields: Vec<Field>,
    pub histories: Vec<History>,
    pub weights: Vec<Weight>,
    pub defs: Vec<Def>,
    pub responses: Vec<Response>,
    pub breaks: Vec<Break>,
    /// `after step velocity = ..`: what replaces the velocity of a node that has intact bonds.
    pub after_step: Option<ExprId>,
    /// What `pdlang verify` finds and the law says itself.
    pub knowns: Vec<Known>,
    pub probes: Vec<crate::probe::Probe>,
    pub exprs: Vec<Expr>,
}

/// A material parameter: a number with a unit.
#[derive(Clone, Debug)]
pub struct Param {
    pub name: String,
    pub doc: String,
    pub unit: Unit,
    pub lower: Option<Bound>,
    pub upper: Option<Bound>,
    /// SI value.
    pub default: Option<f64>,
    /// The value on a bond between two materials.
    pub meet: Meet,
    pub span: Span,
}

/// One side of an interval: SI value, and whether the value itself is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    pub value: f64,
    pub inclusive: bool,
}

/// An influence function slot of a law. Its unit is opaque and must cancel in every response.
#[derive(Clone, Debug)]
pub struct Influence {
    pub name: String,
    pub default: Option<InfluenceFn>,
    pub span: Span,
}

/// A scalar function of the reference bond length: `influence softened(r; p : number, eps : length) = ..`.
/// In `body`, `Var(0)` is r and `Var(1 + k)` is parameter k; [`ExprKind::Delta`] is the horizon.
#[derive(Clone, Debug)]
pub struct InfluenceFn {
    pub name: String,
    pub doc: String,
    pub params: Vec<Param>,
    pub body: ExprId,
    pub exprs: Vec<Expr>,
}

/// A named family: the bonds of the horizon for which `filter` (constant or reference bond) is true.
#[derive(Clone, Debug)]
pub struct Family {
    pub name: String,
    pub filter: Option<ExprId>,
}

/// A correction factor of bonds, computed once from the reference body; 1 where the scene says so. A weight refers
/// only to weights before it.
#[derive(Clone, Debug)]
pub struct Weight {
    pub name: String,
    pub doc: String,
    pub expr: ExprId,
    pub span: Span,
}

/// An evolving node quantity other than the displacement.
#[derive(Clone, Debug)]
pub struct Field {
    pub name: String,
    pub doc: String,
    pub unit: Unit,
    pub shape: Shape,
    /// Known in the middles of the steps, as the velocity is.
    pub half: bool,
    /// The part of the body that it lives on, where not on all: elsewhere it is zero for ever.
    pub lives: Option<Lives>,
    pub span: Span,
}

/// A condition on nodes that does not change during a run, and how it is written.
#[derive(Clone, Debug)]
pub struct Lives {
    pub when: ExprId,
    pub text: String,
}

/// Memory, changed only when a step is accepted: `history p : number = 0`, `update p = ..`.
#[derive(Clone, Debug)]
pub struct History {
    pub name: String,
    pub home: Home,
    pub shape: Shape,
    pub unit: Unit,
    pub initial: f64,
    pub update: ExprId,
    pub family: FamilyId,
    pub span: Span,
}

#[derive(Clone, Debug)]
pub struct Def {
    pub name: String,
    pub home: Home,
    pub shape: Shape,
    pub unit: Unit,
    pub expr: ExprId,
    pub span: Span,
}

/// What the law answers. Node home for `Energy`, `Force` and `Rate`, bond home for the others.
#[derive(Clone, Debug)]
pub enum Response {
    /// Strain energy density W of a node [J/m^3]; the force is derived.
    Energy(ExprId),
    /// Bond-based: scalar pair force density along M [N/m^6]; the force on i is `sum (pair M)`.
    Pair(FamilyId, ExprId),
    /// Force state along M (scalar) or as a vector [N/m^6]; the force on i is `sum (T - T')`.
    State(FamilyId, ExprId),
    /// Force density of a node [N/m^3], a vector.
    Force(ExprId),
    /// Time derivative of a field.
    Rate(FieldId, ExprId),
}

/// How the values of a parameter at the two ends of a bond between materials become one.
#[derive(Clone, PartialEq, Debug, Default, serde::Serialize)]
pub enum Meet {
    #[default]
    Arithmetic,
    Harmonic,
    /// By the lengths of the bond in the two materials, 1/(fa/a + fb/b).
    Series,
    Min,
    Max,
    /// As it is written, and as a tape in which `Var(0)` and `Var(1)` are the values of the two ends, `Var(2)` and
    /// `Var(3)` the fractions of the bond in their materials.
    Formula(String, Tape),
}

impl Meet {
    /// The words of the language.
    pub const WORDS: [(&str, Meet); 5] = [
        ("arithmetic", Meet::Arithmetic),
        ("harmonic", Meet::Harmonic),
        ("series", Meet::Series),
        ("min", Meet::Min),
        ("max", Meet::Max),
    ];
}

/// `break when`: bonds of a family for which `when` is true die, before the force or after it.
#[derive(Clone, Debug)]
pub struct Break {
    pub family: FamilyId,
    pub when: ExprId,
    pub after: bool,
    pub span: Span,
}

/// A check of [`crate::known::CHECKS`] that the law does not pass, and why that is so.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    pub check: String,
    pub reason: String,
    pub span: Span,
}

#[derive(Clone, Debug)]
pub struct Expr {
    pub kind: ExprKind,
    pub shape: Shape,
    pub home: Home,
    pub unit: Unit,
    pub span: Span,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Shape {
    Scalar,
    Vector,
    /// Symmetric tensor of order two.
    Symmetric,
    Tensor,
    Boolean,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Home {
    Constant,
    Node,
    Bond,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Flavour {
    /// 1D, uniaxial stress.
    Bar,
    /// 1D, uniaxial strain.
    Slab,
    PlaneStress,
    PlaneStrain,
    Solid,
}

impl Flavour {
    pub const ALL: [Flavour; 5] = [
        Flavour::Bar,
        Flavour::Slab,
        Flavour::PlaneStress,
        Flavour::PlaneStrain,
        Flavour::Solid,
    ];

    pub fn dim(self) -> usize {
        match self {
            Flavour::Bar | Flavour::Slab => 1,
            Flavour::PlaneStress | Flavour::PlaneStrain => 2,
            Flavour::Solid => 3,
        }
    }

    /// The word in `case flavour { .. }` and in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Flavour::Bar => "bar",
            Flavour::Slab => "slab",
            Flavour::PlaneStress => "plane_stress",
            Flavour::PlaneStrain => "plane_strain",
            Flavour::Solid => "3d",
        }
    }
}

#[derive(Clone, Debug)]
pub enum ExprKind {
    /// SI value.
    Number(f64),
    Pi,
    /// Number of dimensions of the scene, 1, 2 or 3.
    Dim,
    /// The horizon [length], a constant.
    Delta,
    /// Unit tensor (symmetric).
    Identity,
    /// A variable of a scene expression or of an influence function.
    Var(u32),
    Param(ParamId),
    Def(DefId),
    /// Value of a field at the node.
    Field(FieldId),
    /// Committed history: of this node, or of this directed bond.
    History(HistoryId),
    /// A weight of this directed bond (bond, number).
    Weight(WeightId),
    /// The law's influence function at the reference length of this bond (bond home).
    Influence(InfluenceId),
    /// Reference bond vector X' - X (bond, vector, length).
    Xi,
    /// Relative displacement u' - u (bond, vector, length).
    Eta,
    /// Velocity of the node (node, vector).
    Velocity,
    /// Reference position of the node (node, vector).
    Position,
    /// Time from the last committed step to the state at hand (scalar). It may change during a run, and so is
    /// of the home of a node although it is the same everywhere.
    TimeStep,
    Neg(ExprId),
    Not(ExprId),
    /// Componentwise for `Add`, `Sub`; `Mul` is scalar times anything, tensor times tensor, or tensor times vector.
    Binary(BinaryOp, ExprId, ExprId),
    Compare(CompareOp, ExprId, ExprId),
    Call(Builtin, Vec<ExprId>),
    /// A vector by its components, of which the scene's dimension has the first; those not given are zero.
    Vector(Vec<ExprId>),
    /// Component of a vector (one index) or of a tensor (two); zero-based.
    Component(ExprId, Vec<u8>),
    /// Bond -> node, weighted with the neighbour's volume.
    Reduce(Reduction, FamilyId, ExprId),
    /// Integral of a reference bond expression over the whole horizon: a constant.
    Ball(ExprId),
    /// The same quantity seen from the other end of the bond (node value of j; bond j -> i).
    Prime(ExprId),
    /// One arm per flavour, in the order of [`Flavour::ALL`].
    Case([ExprId; 5]),
}

impl Law {
    /// What an expression is formed from: its operands, or what the definition or weight says that it reads.
    pub fn behind(&self, expr: ExprId) -> Vec<ExprId> {
        match &self.exprs[expr.index()].kind {
            ExprKind::Def(def) => vec![self.defs[def.index()].expr],
            ExprKind::Weight(w) => vec![self.weights[w.index()].expr],
            kind => kind.operands(),
        }
    }

    /// Some expressions and all that they are formed from, each once.
    pub fn all_behind(&self, mut list: Vec<ExprId>) -> Vec<ExprId> {
        let mut seen = vec![false; self.exprs.len()];
        let mut found = Vec::new();
        while let Some(expr) = list.pop() {
            if !std::mem::replace(&mut seen[expr.index()], true) {
                found.push(expr);
                list.extend(self.behind(expr));
            }
        }
        found
    }
}

impl ExprKind {
    /// The direct operands; a definition has none.
    pub fn operands(&self) -> Vec<ExprId> {
        crate::resolve::walk::operands(self)
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum BinaryOp {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    And,
    Or,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum CompareOp {
    Lt,
    Le,
    Gt,
    Ge,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Reduction {
    /// Over intact bonds.
    Sum,
    /// Over the reference family, broken or not.
    Sum0,
    /// Average over the intact bonds, by volume.
    Mean,
    /// Extremes over the intact bonds; 0 where there are none.
    Min,
    Max,
    /// Number of intact bonds for which a condition holds.
    Count,
}

impl Reduction {
    /// One bond alone decides.
    pub fn is_extreme(self) -> bool {
        matches!(self, Reduction::Min | Reduction::Max)
    }

    /// `Sum0` over the reference family, `Sum` over intact bonds: what can share a loop.
    pub fn bonds(self) -> Reduction {
        match self {
            Reduction::Sum0 => Reduction::Sum0,
            _ => Reduction::Sum,
        }
    }
}

/// A tensor of reference sums has no inverse where its determinant is at most this part of its largest component to the
/// power of the dimension: the bonds lie in a line or a plane. Its inverse is zero.
pub const FLAT: f64 = 1e-8;

/// Functions that are not definable in the language.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Builtin {
    /// Length of a vector.
    Norm,
    Dot,
    Outer,
    Trace,
    Sym,
    Dev,
    Det,
    Inverse,
    Transpose,
    /// The diagonal tensor of a vector; the vector on the diagonal of a tensor.
    Diag,
    Sqrt,
    Abs,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Min,
    Max,
    /// `select(condition, a, b)`, scalars.
    Select,
}
