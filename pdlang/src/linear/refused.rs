//! Which laws cannot be linearised, and where the text says so.

use std::collections::{HashMap, HashSet};

use crate::diag::Diagnostic;
use crate::ir::{Builtin, ExprId, ExprKind, Law, Reduction, Response};
use crate::resolve::walk::operands;
use crate::span::Span;

/// Laws that cannot be linearised whatever their answers are.
pub fn refused(law: &Law) -> Vec<Diagnostic> {
    let mut moving = Moving::of(law);
    let mut found = Vec::new();
    for h in &law.histories {
        if moving.moves(h.update) {
            let why = format!("its history `{}` remembers displacements", h.name);
            let label = "its update reads what the displacement changes";
            found.push(refusal(law, why, h.span, label));
        }
    }
    if let Some(e) = law.after_step {
        let why = "it replaces velocities".to_string();
        let place = law.exprs[e.index()].span;
        found.push(refusal(law, why, place, "after every step"));
    }
    found
}

fn refusal(law: &Law, why: String, place: Span, label: &str) -> Diagnostic {
    let message = format!("`{}` cannot be linearised: {why}", law.name);
    Diagnostic::error("PD091", message)
        .at(place, label)
        .help("a linearised law is the slope of its answers at rest; use the law as it is")
}

/// Where the value of `e` has no slope.
pub(super) fn rough(law: &Law, e: ExprId) -> Diagnostic {
    let answer = |r: &Response| match r {
        Response::Energy(a) if *a == e => Some("energy"),
        Response::Pair(_, a) if *a == e => Some("pair force"),
        Response::State(_, a) if *a == e => Some("force state"),
        Response::Force(a) if *a == e => Some("force"),
        Response::Rate(_, a) if *a == e => Some("rate"),
        _ => None,
    };
    let answer = law.responses.iter().find_map(answer).unwrap_or("answer");
    let (definition, place) = Moving::of(law).kink(e, None).unwrap_or((None, e));
    let name = match definition {
        Some(d) => format!("`{}`", law.defs[d].name),
        None => format!("its {answer}"),
    };
    let why = format!("{name} is not smooth at rest");
    let label = "this has no slope where nothing is displaced";
    refusal(law, why, law.exprs[place.index()].span, label)
}

/// Which expressions displacements change.
struct Moving<'a> {
    law: &'a Law,
    memo: HashMap<ExprId, bool>,
    /// What [`Moving::kink`] has looked at.
    seen: HashSet<ExprId>,
}

impl<'a> Moving<'a> {
    fn of(law: &'a Law) -> Moving<'a> {
        Moving {
            law,
            memo: HashMap::new(),
            seen: HashSet::new(),
        }
    }

    /// What an expression is made of, a definition of its own.
    fn parts(&self, e: ExprId) -> Vec<ExprId> {
        match &self.law.exprs[e.index()].kind {
            ExprKind::Def(d) => vec![self.law.defs[d.index()].expr],
            kind => operands(kind),
        }
    }

    fn moves(&mut self, e: ExprId) -> bool {
        if let Some(known) = self.memo.get(&e) {
            return *known;
        }
        let eta = matches!(self.law.exprs[e.index()].kind, ExprKind::Eta);
        let found = eta || self.parts(e).into_iter().any(|part| self.moves(part));
        self.memo.insert(e, found);
        found
    }

    /// The first choice, absolute value or extreme that displacements decide, and the definition that it is in.
    fn kink(&mut self, e: ExprId, within: Option<usize>) -> Option<(Option<usize>, ExprId)> {
        if !self.seen.insert(e) {
            return None;
        }
        use Builtin::{Abs, Max, Min, Select};
        let deciding = match &self.law.exprs[e.index()].kind {
            ExprKind::Call(Abs | Max | Min, args) => args.clone(),
            ExprKind::Call(Select, args) => args[..1].to_vec(),
            ExprKind::Compare(_, a, b) => vec![*a, *b],
            ExprKind::Reduce(r, _, body) if r.is_extreme() || *r == Reduction::Count => vec![*body],
            _ => Vec::new(),
        };
        if deciding.into_iter().any(|part| self.moves(part)) {
            return Some((within, e));
        }
        let within = match self.law.exprs[e.index()].kind {
            ExprKind::Def(d) if !self.law.defs[d.index()].span.prelude => Some(d.index()),
            _ => within,
        };
        let parts = self.parts(e);
        parts.into_iter().find_map(|part| self.kink(part, within))
    }
}
