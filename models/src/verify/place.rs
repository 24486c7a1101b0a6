//! Which definition of the text a finding is about.

use pdlang::ir::{self, BinaryOp, Def, ExprId, ExprKind, Home, Law, Reduction, Response};
use pdlang::span::Span;

use super::subject::Subject;

/// A definition as it is headed in the text, `energy W`, and where it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    pub name: String,
    pub line: usize,
    pub column: usize,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "`{}` (line {})", self.name, self.line)
    }
}

/// Words that head a definition with a value.
const HEADS: [&str; 11] = [
    "let", "node", "bond", "energy", "pair", "state", "force", "rate", "weight", "update", "break",
];

/// The definition that holds a place of the text; `None` for what stands in another file.
pub fn of_span(text: &str, span: Span) -> Option<Place> {
    if span.prelude {
        return None;
    }
    let at = (0..=(span.start as usize).min(text.len()))
        .rev()
        .find(|k| text.is_char_boundary(*k))?;
    let starts = text[..at]
        .rmatch_indices('\n')
        .map(|(k, _)| k + 1)
        .chain([0]);
    let headed = |start: &usize| {
        let word: String = text[*start..]
            .trim_start()
            .chars()
            .take_while(|c| c.is_alphanumeric())
            .collect();
        HEADS.contains(&word.as_str()) || word == "model" || word == "param"
    };
    let start = starts
        .clone()
        .find(headed)
        .or_else(|| starts.clone().next())?;
    let body = text[start..]
        .lines()
        .next()
        .unwrap_or_default()
        .trim_start();
    let end = body
        .find(['=', ':', '"', '{'])
        .or_else(|| body.find(" when"));
    let of_line = text[..at].rfind('\n').map_or(0, |k| k + 1);
    Some(Place {
        name: body[..end.unwrap_or(body.len())].trim_end().to_string(),
        line: text[..at].matches('\n').count() + 1,
        column: text[of_line..at].chars().count() + 1,
    })
}

impl Subject<'_> {
    pub fn place(&self, span: Span) -> Option<Place> {
        of_span(self.text, span)
    }

    /// Of what a function of the library makes, that of its arguments.
    pub fn place_of(&self, expr: ExprId) -> Option<Place> {
        let mut queue = std::collections::VecDeque::from([expr]);
        let mut seen = std::collections::HashSet::new();
        while let Some(expr) = queue.pop_front() {
            if !seen.insert(expr) {
                continue;
            }
            let found = &self.law.exprs[expr.index()];
            let place = self.place(found.span);
            if place.is_some() {
                return place;
            }
            queue.extend(found.kind.operands());
        }
        None
    }

    /// The first answer of the law about force.
    pub fn force_place(&self) -> Option<Place> {
        let first = self
            .law
            .responses
            .iter()
            .find(|r| !matches!(r, Response::Rate(..)));
        first.and_then(|r| self.place_of(expr_of(r)))
    }

    /// The energy.
    pub fn energy_place(&self) -> Option<Place> {
        let first = self
            .law
            .responses
            .iter()
            .find(|r| matches!(r, Response::Energy(_)));
        first.and_then(|r| self.place_of(expr_of(r)))
    }

    /// The rate of a field.
    pub fn rate_place(&self, field: usize) -> Option<Place> {
        let of = |r: &&Response| matches!(r, Response::Rate(f, _) if f.index() == field);
        let found = self.law.responses.iter().find(of);
        found.and_then(|r| self.place_of(expr_of(r)))
    }

    /// The definitions of the law's own text that its answers need, in the order in which they depend on each other.
    pub fn definitions(&self) -> impl Iterator<Item = &Def> {
        let law = self.law;
        let answers = law.responses.iter().map(expr_of);
        let answers = answers.chain(law.breaks.iter().map(|b| b.when)).collect();
        let mut needed = vec![false; law.defs.len()];
        for expr in law.all_behind(answers) {
            if let ExprKind::Def(def) = law.exprs[expr.index()].kind {
                needed[def.index()] = true;
            }
        }
        let defs = law.defs.iter().zip(needed);
        defs.filter(|(def, needed)| *needed && !def.span.prelude)
            .map(|(def, _)| def)
    }

    pub fn has_force(&self) -> bool {
        self.law
            .responses
            .iter()
            .any(|r| !matches!(r, Response::Rate(..)))
    }

    pub fn has_energy(&self) -> bool {
        self.law
            .responses
            .iter()
            .any(|r| matches!(r, Response::Energy(_)))
    }
}

pub fn expr_of(response: &Response) -> ExprId {
    match response {
        Response::Energy(e)
        | Response::Force(e)
        | Response::Pair(_, e)
        | Response::State(_, e)
        | Response::Rate(_, e) => *e,
    }
}

/// The terms that an expression adds up, through signs, factors and sums over bonds.
pub fn terms(law: &Law, expr: ExprId) -> Vec<ExprId> {
    use BinaryOp::{Add, Div, Mul, Sub};
    // The terms of a constant factor, as in `dim*(dim + 2)*G`, are none of the sum.
    let varies = |e: &&ExprId| law.exprs[e.index()].home != Home::Constant;
    let inside = |list: &[ExprId]| {
        let sides = list.iter().filter(varies);
        let found = sides.map(|e| terms(law, *e)).find(|parts| parts.len() > 1);
        found.unwrap_or_else(|| vec![expr])
    };
    match law.exprs[expr.index()].kind {
        ExprKind::Binary(Add | Sub, a, b) => [terms(law, a), terms(law, b)].concat(),
        ExprKind::Neg(a) => terms(law, a),
        ExprKind::Binary(Mul, a, b) => inside(&[b, a]),
        ExprKind::Binary(Div, a, _) | ExprKind::Reduce(Reduction::Sum | Reduction::Sum0, _, a) => {
            inside(&[a])
        }
        _ => vec![expr],
    }
}

/// Whether an expression holds what is asked for, directly or through definitions.
pub fn contains(law: &Law, expr: ExprId, asked: &dyn Fn(&ExprKind) -> bool) -> bool {
    let all = law.all_behind(vec![expr]);
    all.iter().any(|e| asked(&law.exprs[e.index()].kind))
}

/// Whether an expression depends on how the body is displaced.
pub fn moves(law: &Law, expr: ExprId) -> bool {
    contains(law, expr, &|kind| matches!(kind, ExprKind::Eta))
}

/// A law in which an expression is multiplied by a number.
pub fn multiplied(law: &Law, expr: ExprId, factor: f64) -> Law {
    let mut law = law.clone();
    let old = law.exprs[expr.index()].clone();
    let mut push = |e: ir::Expr| {
        law.exprs.push(e);
        ExprId(law.exprs.len() as u32 - 1)
    };
    let number = push(ir::Expr {
        kind: ExprKind::Number(factor),
        shape: ir::Shape::Scalar,
        home: Home::Constant,
        ..old.clone()
    });
    let value = push(old);
    law.exprs[expr.index()].kind = ExprKind::Binary(BinaryOp::Mul, number, value);
    law
}
