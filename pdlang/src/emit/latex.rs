//! Written expressions as LaTeX, in the notation of the papers.
//!
//! A sum runs over the other ends j of the bonds of a node and is weighted with their volumes; H is the
//! family of intact bonds, H_0 that of all there ever were. A prime is the other end.

use super::derived::{Bonds, Meaning};
use super::symbols;
use crate::ast::{Argument, Expr, ExprKind};
use crate::ir::{BinaryOp, CompareOp, Law, Shape};

/// How tightly a formula holds together, loosest first.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Tight {
    Logic,
    Compare,
    Sum,
    Product,
    Power,
    Atom,
}

/// How a page writes formulas, and what it needs to know of its law.
pub(super) struct Notation<'a> {
    pub law: &'a Law,
    /// As text of the language instead of LaTeX.
    pub plain: bool,
    /// What names that are not of the law stand for.
    pub meanings: Vec<(String, Meaning, Shape)>,
}

impl Notation<'_> {
    pub(super) fn expr(&self, e: &Expr) -> String {
        match self.plain {
            true => super::plain::expr(e),
            false => self.tight(e).0,
        }
    }

    pub(super) fn number(&self, value: f64) -> String {
        match self.plain {
            true => super::plain::number(value),
            false => symbols::number(value),
        }
    }

    /// A name of nothing in the law.
    pub(super) fn bare(&self, name: &str) -> String {
        match self.plain {
            true => name.into(),
            false => symbols::name(name, false),
        }
    }

    pub(super) fn bold(&self, name: &str) -> String {
        match self.plain {
            true => name.into(),
            false => symbols::name(name, true),
        }
    }

    /// The time derivative of a field.
    pub(super) fn rate(&self, name: &str) -> String {
        match self.plain {
            true => format!("rate {name}"),
            false => format!("\\dot{{{}}}", self.name(name)),
        }
    }

    pub(super) fn becomes(&self) -> &'static str {
        if self.plain { ":=" } else { "\\leftarrow" }
    }

    fn meaning(&self, meaning: &Meaning) -> String {
        match meaning {
            Meaning::Slope(of, by, bonds) => {
                let (of, by) = (self.name(of), self.name(by));
                let slope = format!("\\frac{{\\partial {of}}}{{\\partial {by}}}");
                match bonds.as_ref().map(marks).filter(|marks| !marks.is_empty()) {
                    Some(marks) => format!("\\left.{slope}\\right|_{{{marks}}}"),
                    None => slope,
                }
            }
            Meaning::Change(of) => match self.meanings.iter().find(|(name, ..)| name == of) {
                Some((_, Meaning::Slope(..), _)) => {
                    format!("\\mathrm{{d}}\\left({}\\right)", self.name(of))
                }
                _ => format!("\\mathrm{{d}}{{{}}}", self.name(of)),
            },
            Meaning::State(bonds) => marked("\\underline{\\mathbf{T}}", bonds),
            Meaning::Pair(bonds) => marked("\\mathbf{t}", bonds),
        }
    }

    /// A value, in bold where it is a vector or a tensor.
    pub(super) fn name(&self, name: &str) -> String {
        if self.plain {
            return name.into();
        }
        if let Some((_, meaning, _)) = self.meanings.iter().find(|(known, ..)| known == name) {
            return self.meaning(meaning);
        }
        match name {
            "velocity" => return "\\mathbf{v}".into(),
            "edot" => return "\\dot e".into(),
            // A law may call something of its own `d`.
            "dim" => return "\\dim".into(),
            "inf" => return "\\infty".into(),
            _ => {}
        }
        symbols::name(name, self.is_bold(name))
    }

    /// Whether it is a vector or a tensor.
    fn is_bold(&self, name: &str) -> bool {
        let law = self.law;
        // Of the prelude comes what the law has no name for.
        let defs = law.defs.iter().filter(|def| def.name == name);
        let def = defs.min_by_key(|def| def.span.prelude).map(|d| d.shape);
        let field = law.fields.iter().find(|f| f.name == name);
        let history = law.histories.iter().find(|h| h.name == name);
        let own = field.map(|f| f.shape).or(history.map(|h| h.shape));
        let scalar = law.params.iter().any(|p| p.name == name)
            || law.influences.iter().any(|i| i.name == name)
            || law.weights.iter().any(|w| w.name == name);
        match own.or(def) {
            _ if scalar => false,
            Some(shape) => !matches!(shape, Shape::Scalar | Shape::Boolean),
            None => matches!(name, "xi" | "eta" | "X" | "I" | "Y" | "M"),
        }
    }

    fn tight(&self, e: &Expr) -> (String, Tight) {
        match &e.kind {
            ExprKind::Number(value, None) => (symbols::number(*value), Tight::Atom),
            ExprKind::Number(value, Some(unit)) => (
                format!("{}\\,{}", symbols::number(*value), symbols::unit(unit)),
                Tight::Product,
            ),
            ExprKind::Name(name) => (self.name(name), Tight::Atom),
            ExprKind::Call { name, family, args } => {
                let family = family.as_ref().map(|f| f.text.as_str());
                self.call(&name.text, family, args)
            }
            ExprKind::Neg(a) => (format!("-{}", self.at_least(a, Tight::Product)), Tight::Sum),
            ExprKind::Not(a) => (
                format!("\\lnot {}", self.at_least(a, Tight::Atom)),
                Tight::Power,
            ),
            ExprKind::Binary(op, a, b) => self.binary(*op, a, b),
            ExprKind::Compare(op, a, b) => {
                let sign = match op {
                    CompareOp::Lt => "<",
                    CompareOp::Le => "\\le",
                    CompareOp::Gt => ">",
                    CompareOp::Ge => "\\ge",
                };
                let (a, b) = (self.at_least(a, Tight::Sum), self.at_least(b, Tight::Sum));
                (format!("{a} {sign} {b}"), Tight::Compare)
            }
            ExprKind::Vector(parts) => {
                let parts: Vec<String> = parts.iter().map(|part| self.expr(part)).collect();
                (format!("\\left({}\\right)", parts.join(", ")), Tight::Atom)
            }
            ExprKind::Component(a, axes) => (
                format!("{{{}}}_{{{}}}", self.at_least(a, Tight::Atom), axes.text),
                Tight::Atom,
            ),
            ExprKind::Prime(a) => (
                format!("{{{}}}'", self.at_least(a, Tight::Atom)),
                Tight::Atom,
            ),
            ExprKind::Case(arms) => {
                let arm = |(flavour, value): &(crate::ast::Name, Expr)| {
                    format!("{} & \\text{{{}}}", self.expr(value), words(&flavour.text))
                };
                let arms: Vec<String> = arms.iter().map(arm).collect();
                (
                    format!("\\begin{{cases}} {} \\end{{cases}}", arms.join(" \\\\ ")),
                    Tight::Logic,
                )
            }
        }
    }

    fn at_least(&self, e: &Expr, wanted: Tight) -> String {
        match self.tight(e) {
            (text, tight) if tight >= wanted => text,
            (text, _) => format!("\\left({text}\\right)"),
        }
    }

    fn binary(&self, op: BinaryOp, a: &Expr, b: &Expr) -> (String, Tight) {
        let at = |e: &Expr, tight| self.at_least(e, tight);
        match op {
            BinaryOp::Add => (
                format!("{} + {}", at(a, Tight::Sum), at(b, Tight::Product)),
                Tight::Sum,
            ),
            BinaryOp::Sub => (
                format!("{} - {}", at(a, Tight::Sum), at(b, Tight::Product)),
                Tight::Sum,
            ),
            BinaryOp::Mul => {
                let held = if is_open(a) {
                    Tight::Atom
                } else {
                    Tight::Product
                };
                let (left, right) = (at(a, held), at(b, Tight::Product));
                // A digit must not follow a number.
                let between = if right.starts_with(|c: char| c.is_ascii_digit()) {
                    " \\cdot "
                } else {
                    "\\,"
                };
                (format!("{left}{between}{right}"), Tight::Product)
            }
            BinaryOp::Div => (
                format!("\\frac{{{}}}{{{}}}", self.expr(a), self.expr(b)),
                Tight::Product,
            ),
            BinaryOp::Pow => (
                format!("{{{}}}^{{{}}}", at(a, Tight::Atom), self.expr(b)),
                Tight::Power,
            ),
            BinaryOp::And => (
                format!("{} \\land {}", at(a, Tight::Compare), at(b, Tight::Compare)),
                Tight::Logic,
            ),
            BinaryOp::Or => (
                format!("{} \\lor {}", at(a, Tight::Compare), at(b, Tight::Compare)),
                Tight::Logic,
            ),
        }
    }

    fn call(&self, name: &str, family: Option<&str>, args: &[Argument]) -> (String, Tight) {
        let all: Vec<String> = args.iter().map(|a| self.expr(&a.value)).collect();
        let atom = |k: usize| {
            args.get(k)
                .map_or(String::new(), |a| self.at_least(&a.value, Tight::Atom))
        };
        let product = |k: usize| {
            args.get(k)
                .map_or(String::new(), |a| self.at_least(&a.value, Tight::Product))
        };
        let (one, list) = (all.first().cloned().unwrap_or_default(), all.join(", "));
        let over = |letter: &str| match family {
            Some(family) => format!("\\mathcal{{H}}{letter}^{{\\text{{{}}}}}", words(family)),
            None => format!("\\mathcal{{H}}{letter}"),
        };
        match name {
            "sum" => (
                format!("\\sum_{{j \\in {}}} {}\\,V_j", over(""), product(0)),
                Tight::Product,
            ),
            "sum0" => (
                format!("\\sum_{{j \\in {}}} {}\\,V_j", over("_0"), product(0)),
                Tight::Product,
            ),
            "mean" | "min" | "max" | "count" if family.is_some() || args.len() == 1 => {
                let word = if name == "count" {
                    "\\#".into()
                } else {
                    format!("\\{}", operator(name))
                };
                (
                    format!("{word}_{{j \\in {}}} {}", over(""), product(0)),
                    Tight::Product,
                )
            }
            "ball" => (
                format!(
                    "\\int_{{\\mathcal{{B}}_\\delta}} {}\\,\\mathrm{{d}}V",
                    product(0)
                ),
                Tight::Product,
            ),
            "under" if all.len() == 2 => (
                format!("\\left.{}\\right|_{{\\nabla\\mathbf{{u}} = {one}}}", all[1]),
                Tight::Atom,
            ),
            "norm" => (format!("\\lVert {one} \\rVert"), Tight::Atom),
            "abs" => (format!("\\lvert {one} \\rvert"), Tight::Atom),
            "sqrt" => (format!("\\sqrt{{{one}}}"), Tight::Atom),
            "dot" => (
                format!("{} \\cdot {}", product(0), product(1)),
                Tight::Product,
            ),
            "outer" => (
                format!("{} \\otimes {}", product(0), product(1)),
                Tight::Product,
            ),
            "inverse" => (format!("{{{}}}^{{-1}}", atom(0)), Tight::Power),
            "transpose" => (format!("{{{}}}^{{\\mathsf{{T}}}}", atom(0)), Tight::Power),
            "exp" => (format!("\\mathrm{{e}}^{{{one}}}"), Tight::Power),
            "select" if all.len() == 3 => (
                format!(
                    "\\begin{{cases}} {} & {one} \\\\ {} & \\text{{otherwise}} \\end{{cases}}",
                    all[1], all[2]
                ),
                Tight::Logic,
            ),
            "tr" | "sym" | "dev" | "det" | "diag" | "ln" | "sin" | "cos" | "tan" | "min"
            | "max" => (
                format!("\\{}\\left({list}\\right)", operator(name)),
                Tight::Atom,
            ),
            _ => (
                format!("{}\\left({list}\\right)", symbols::name(name, false)),
                Tight::Atom,
            ),
        }
    }
}

fn marked(letter: &str, bonds: &Bonds) -> String {
    match marks(bonds) {
        marks if marks.is_empty() => letter.into(),
        marks => format!("{letter}^{{{marks}}}"),
    }
}

/// The family of bonds, and a zero for those of the undamaged body.
fn marks(bonds: &Bonds) -> String {
    let family = bonds
        .family
        .as_ref()
        .map(|f| format!("\\text{{{}}}", words(f)));
    let whole = (bonds.word == "sum0").then(|| "0".to_string());
    let marks: Vec<String> = family.into_iter().chain(whole).collect();
    marks.join(",")
}

/// Whether what follows would seem to belong to it: the end of a sum over bonds, or of a product of vectors.
fn is_open(e: &Expr) -> bool {
    let open = [
        "sum", "sum0", "ball", "mean", "min", "max", "count", "dot", "outer",
    ];
    match &e.kind {
        ExprKind::Call { name, .. } => open.contains(&name.text.as_str()),
        ExprKind::Binary(BinaryOp::Mul, _, b) => is_open(b),
        ExprKind::Neg(a) => is_open(a),
        _ => false,
    }
}

/// LaTeX knows some operators by name; the others are set upright.
fn operator(name: &str) -> String {
    match name {
        "det" | "ln" | "sin" | "cos" | "tan" | "min" | "max" => name.into(),
        _ => format!("operatorname{{{name}}}"),
    }
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}
