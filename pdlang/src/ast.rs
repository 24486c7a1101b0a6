//! The tree of a file as it was written: names are text, nothing is checked yet.

use crate::ir::{BinaryOp, CompareOp, Home, Shape};
use crate::span::Span;

/// A word and where it stands. Greek letters are already spelled out.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    pub text: String,
    pub span: Span,
}

/// A string and where it stands, quotes included.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    pub text: String,
    pub span: Span,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct File {
    /// Paths of files, `use "elastic.pd"`.
    pub uses: Vec<Text>,
    pub models: Vec<Model>,
    pub influences: Vec<InfluenceFn>,
    pub functions: Vec<Function>,
    /// `let`, `node` and `bond` outside of a model: a model that uses one gets its own copy.
    pub definitions: Vec<Definition>,
    /// Names whose definition could not be read; using one is no further error.
    pub broken: Vec<Name>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub name: Name,
    pub title: Option<Text>,
    pub cites: Vec<Text>,
    /// `for plane_strain, 3d`: all flavours where there is none.
    pub flavours: Vec<Name>,
    pub items: Vec<Item>,
    /// As in [`File::broken`].
    pub broken: Vec<Name>,
    /// False when an item could not be read.
    pub complete: bool,
}

/// `fn K_d(K, G) = ..`
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    pub name: Name,
    pub params: Vec<Name>,
    pub body: Expr,
}

/// `influence softened(r; p : number, eps : length > 0) = ..`
#[derive(Clone, Debug, PartialEq)]
pub struct InfluenceFn {
    pub name: Name,
    pub variable: Name,
    pub params: Vec<Param>,
    pub body: Expr,
    pub doc: Option<Text>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Influence(InfluenceSlot),
    Param(Param),
    Definition(Definition),
    Response(Response),
    Field(Field),
    History(History),
    Update(Update),
    Family(Family),
    Weight(Weight),
    Break(Break),
    AfterStep(AfterStep),
    Known(Known),
    Probe(Probe),
}

#[derive(Clone, Debug, PartialEq)]
pub struct InfluenceSlot {
    pub name: Name,
    pub default: Option<Expr>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    pub name: Name,
    pub kind: Kind,
    pub bounds: Vec<Bound>,
    pub default: Option<Quantity>,
    /// How values of two materials meet on a bond: a word, or an expression in both.
    pub meet: Option<Expr>,
    pub doc: Option<Text>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    pub home: Home,
    pub name: Name,
    pub annotation: Option<Annotation>,
    pub expr: Expr,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResponseKind {
    Energy,
    Pair,
    State,
    /// Of a node, as a vector.
    Force,
    Rate,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    pub kind: ResponseKind,
    pub family: Option<Name>,
    pub name: Name,
    pub annotation: Option<Annotation>,
    pub expr: Expr,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub name: Name,
    pub annotation: Annotation,
    /// `at half`
    pub half: bool,
    /// `where norm(phi) > 0`
    pub lives: Option<Expr>,
    pub doc: Option<Text>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct History {
    pub name: Name,
    pub annotation: Annotation,
    pub initial: Option<Quantity>,
    pub home: Home,
    pub family: Option<Name>,
    pub doc: Option<Text>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Update {
    pub name: Name,
    pub expr: Expr,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    pub name: Name,
    pub base: Name,
    pub filter: Expr,
}

/// `weight G = .. "surface correction"`
#[derive(Clone, Debug, PartialEq)]
pub struct Weight {
    pub name: Name,
    pub expr: Expr,
    pub doc: Option<Text>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Break {
    pub family: Option<Name>,
    pub after: bool,
    pub when: Expr,
    pub span: Span,
}

/// `after step velocity = ..`
#[derive(Clone, Debug, PartialEq)]
pub struct AfterStep {
    pub name: Name,
    pub expr: Expr,
}

/// `known zero_energy "its gradient does not see a checkerboard"`
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    pub checks: Vec<Name>,
    pub reason: Text,
}

/// `probe one_bond in 3d where K = 1 GPa, delta = 2 mm { .. }`
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    pub name: Name,
    pub flavour: Name,
    pub settings: Vec<Setting>,
    pub lines: Vec<ProbeLine>,
}

/// `K = 1 GPa`, `u = (1 um, 0, 0)`
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    pub name: Name,
    pub value: Components,
}

/// A scalar is one row of one; a vector one row; a tensor one row per first index.
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    pub rows: Vec<Vec<Expr>>,
    pub span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ProbeLine {
    Let(Name, Expr),
    /// `node a = (0, 0, 0), V = 1 mm^3`
    Node {
        name: Name,
        position: Components,
        settings: Vec<Setting>,
    },
    /// `lattice 1 mm, H = (..)`; the span is that of the word.
    Lattice {
        spacing: Expr,
        settings: Vec<Setting>,
        span: Span,
    },
    /// `break (a, b)`
    Cut(Name, Name),
    Expect(Expectation),
}

/// `expect W(a) = .. within 1e-9`
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    pub rate: bool,
    pub name: Name,
    pub place: Vec<Name>,
    pub value: Components,
    pub within: Option<Expr>,
}

/// `: vector`, `: temperature`, `: tensor pressure`, `: [J/m^2]`
#[derive(Clone, Debug, PartialEq)]
pub struct Annotation {
    pub shape: Option<Shape>,
    pub kind: Option<Kind>,
    pub span: Span,
}

/// A named kind, or a unit in brackets.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    Named(Name),
    Unit(UnitExpr),
}

/// Product of powers of unit names.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitExpr {
    pub factors: Vec<(Name, f64)>,
    pub span: Span,
}

/// A number with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    pub value: f64,
    pub unit: Option<UnitExpr>,
    pub span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// `> 0`
    Side(CompareOp, Quantity),
    /// `in [0, 1)`; true where the end itself is allowed.
    Interval {
        lower: Quantity,
        lower_in: bool,
        upper: Quantity,
        upper_in: bool,
        span: Span,
    },
}

#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    pub kind: ExprKind,
    pub span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    Number(f64, Option<UnitExpr>),
    Name(String),
    Call {
        name: Name,
        family: Option<Name>,
        args: Vec<Argument>,
    },
    Neg(Box<Expr>),
    Not(Box<Expr>),
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    Compare(CompareOp, Box<Expr>, Box<Expr>),
    /// `(a, b, c)`
    Vector(Vec<Expr>),
    Component(Box<Expr>, Name),
    Prime(Box<Expr>),
    Case(Vec<(Name, Expr)>),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// `eps` in `softened(eps = 1 mm)`.
    pub name: Option<Name>,
    pub value: Expr,
}
