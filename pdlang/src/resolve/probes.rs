//! Probes of a law: written numbers become SI values, names become ids.
//!
//! A probe is read when its law is right. Everything in it is evaluated here, in the order of the text, so
//! that what is expected may use parameters, `delta`, `dim` and what a `let` of the probe has named, but
//! nothing that the law computes.

mod expected;

use crate::ast::{self, Components, Name, ProbeLine, Setting};
use crate::check::{duplicates, flavours, probes as say};
use crate::diag::Diagnostic;
use crate::ir::{BinaryOp, Flavour, InfluenceFn, Law, Shape};
use crate::probe::{MAX_NODES, MAX_REACH, Node, Place, Probe};
use crate::resolve::influence;
use crate::resolve::library::Library;
use crate::resolve::numbers::Numbers;
use crate::units::Unit;

/// The probe, unless something is wrong with it.
pub(crate) fn probe(
    written: &ast::Probe,
    law: &Law,
    energy: Option<&str>,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<Probe> {
    let Some(flavour) = Flavour::ALL
        .into_iter()
        .find(|f| f.name() == written.flavour.text)
    else {
        report.push(flavours::unknown(&written.flavour));
        return None;
    };
    let before = report.len();
    let mut reader = Reader {
        law,
        energy,
        flavour,
        values: Numbers::new(library, flavour),
        failed: false,
        report,
    };
    reader.values.add("dim", flavour.dim() as f64, Unit::NUMBER);
    let probe = reader.probe(written);
    probe.filter(|_| report.len() == before)
}

struct Reader<'a> {
    law: &'a Law,
    /// What the law calls its energy.
    energy: Option<&'a str>,
    flavour: Flavour,
    values: Numbers<'a>,
    /// Something is wrong already: what only follows from it is not told.
    failed: bool,
    report: &'a mut Vec<Diagnostic>,
}

/// What the `where` of a probe sets.
struct Settings {
    params: Vec<f64>,
    influences: Vec<(InfluenceFn, Vec<f64>)>,
    horizon: f64,
    cross: f64,
    without: Vec<String>,
}

impl Reader<'_> {
    fn probe(&mut self, written: &ast::Probe) -> Option<Probe> {
        let settings = self.settings(written);
        self.failed = settings.is_none();
        let horizon = settings.as_ref().map_or(1.0, |s| s.horizon);
        let place = self.place(written, horizon)?;
        let mut expectations = Vec::new();
        for line in &written.lines {
            if let ProbeLine::Expect(expected) = line {
                expectations.extend(self.expectation(expected, &place, horizon));
            }
        }
        let settings = settings?;
        let expects = |line: &ProbeLine| matches!(line, ProbeLine::Expect(_));
        if !written.lines.iter().any(expects) {
            return self.wrong(say::nothing_expected(&written.name));
        }
        Some(Probe {
            name: written.name.text.clone(),
            flavour: self.flavour,
            params: settings.params,
            influences: settings.influences,
            horizon: settings.horizon,
            cross: settings.cross,
            without: settings.without,
            place,
            expectations,
            span: written.name.span,
        })
    }

    fn wrong<T>(&mut self, finding: Diagnostic) -> Option<T> {
        self.report.push(finding);
        None
    }

    // ---- what is set

    fn settings(&mut self, written: &ast::Probe) -> Option<Settings> {
        let law = self.law;
        let mut given: Vec<Name> = Vec::new();
        let mut params: Vec<Option<f64>> = law.params.iter().map(|p| p.default).collect();
        let mut influences: Vec<Option<InfluenceFn>> =
            law.influences.iter().map(|i| i.default.clone()).collect();
        let (mut horizon, mut cross, mut without) = (None, 1.0, Vec::new());
        let mut wrong: Vec<&str> = Vec::new();
        for setting in &written.settings {
            let name = &setting.name;
            if !duplicates::among(&given, name, self.report) {
                wrong.push(&name.text);
                continue;
            }
            given.push(name.clone());
            let read = if let Some(k) = law.params.iter().position(|p| p.name == name.text) {
                params[k] = self.param(setting, &law.params[k]);
                // Whatever rests on it has a value, so that the rest is read.
                let value = params[k].unwrap_or(1.0);
                self.values
                    .add(&name.text, value, law.params[k].unit.clone());
                params[k].map(drop)
            } else if let Some(k) = law.influences.iter().position(|i| i.name == name.text) {
                let expr = self.one(&setting.value);
                influences[k] =
                    expr.and_then(|e| influence::choice(e, self.values.library, self.report));
                influences[k].as_ref().map(drop)
            } else if law.weights.iter().any(|w| w.name == name.text) {
                without.push(name.text.clone());
                match self.scalar(&setting.value, &Unit::NUMBER) {
                    Some(1.0) => Some(()),
                    Some(_) => self.wrong(say::not_one(name, setting.value.span)),
                    None => None,
                }
            } else {
                let area = Unit::length().times(&Unit::length());
                match (name.text.as_str(), self.flavour.dim()) {
                    ("delta", _) => {
                        horizon = self.positive(setting, &Unit::length());
                        self.values
                            .add("delta", horizon.unwrap_or(1.0), Unit::length());
                        horizon.map(drop)
                    }
                    ("thickness", 2) => {
                        let given = self.positive(setting, &Unit::length());
                        cross = given.unwrap_or(cross);
                        given.map(drop)
                    }
                    ("area", 1) => {
                        let given = self.positive(setting, &area);
                        cross = given.unwrap_or(cross);
                        given.map(drop)
                    }
                    _ => self.wrong(say::unknown_setting(name, &self.settable())),
                }
            };
            if read.is_none() {
                wrong.push(&name.text);
            }
        }
        let settings = self.complete(written, params, influences, horizon, cross, &wrong)?;
        wrong.is_empty().then_some(Settings {
            without,
            ..settings
        })
    }

    /// The value of a parameter, within its bounds.
    fn param(&mut self, setting: &Setting, param: &crate::ir::Param) -> Option<f64> {
        let value = self.scalar(&setting.value, &param.unit)?;
        match crate::check::bounds::contains(param.lower, param.upper, value) {
            true => Some(value),
            false => self.wrong(say::outside(&setting.name, setting.value.span)),
        }
    }

    fn complete(
        &mut self,
        written: &ast::Probe,
        params: Vec<Option<f64>>,
        influences: Vec<Option<InfluenceFn>>,
        horizon: Option<f64>,
        cross: f64,
        wrong: &[&str],
    ) -> Option<Settings> {
        let law = self.law;
        let mut missing: Vec<&str> = Vec::new();
        for (param, value) in law.params.iter().zip(&params) {
            if value.is_none() {
                missing.push(&param.name);
            }
            self.values
                .add_new(&param.name, value.unwrap_or(1.0), &param.unit);
        }
        for (slot, function) in law.influences.iter().zip(&influences) {
            missing.extend(function.is_none().then_some(slot.name.as_str()));
        }
        missing.extend(horizon.is_none().then_some("delta"));
        if horizon.is_none() {
            self.values.add_new("delta", 1.0, &Unit::length());
        }
        // What was given and is wrong has been told.
        let told = missing.iter().any(|name| wrong.contains(name));
        missing.retain(|name| !wrong.contains(name));
        if !missing.is_empty() {
            return self.wrong(say::missing(&written.name, &missing));
        }
        if told {
            return None;
        }
        let with_values = |f: InfluenceFn| {
            let values = f.params.iter().map(|p| p.default).collect::<Option<_>>()?;
            Some((f, values))
        };
        Some(Settings {
            params: params.into_iter().collect::<Option<_>>()?,
            influences: influences
                .into_iter()
                .map(|f| with_values(f?))
                .collect::<Option<_>>()?,
            horizon: horizon?,
            cross,
            without: Vec::new(),
        })
    }

    fn settable(&self) -> Vec<String> {
        let params = self.law.params.iter().map(|p| p.name.clone());
        let slots = self.law.influences.iter().map(|i| i.name.clone());
        let cross = match self.flavour.dim() {
            1 => Some("area"),
            2 => Some("thickness"),
            _ => None,
        };
        let own = ["delta"].into_iter().chain(cross).map(String::from);
        let weights = self.law.weights.iter().map(|w| w.name.clone());
        params.chain(slots).chain(weights).chain(own).collect()
    }

    // ---- where

    /// The body; names for numbers are given on the way, for what follows them.
    fn place(&mut self, written: &ast::Probe, horizon: f64) -> Option<Place> {
        let (mut nodes, mut lattice) = (Vec::new(), None);
        let (mut names, mut named): (Vec<Name>, Vec<Name>) = (Vec::new(), Vec::new());
        for line in &written.lines {
            match line {
                ProbeLine::Let(name, expr) => {
                    if !duplicates::among(&named, name, self.report) {
                        return None;
                    }
                    let (value, unit) = self.values.number(expr, self.report)?;
                    self.values.add(&name.text, value, unit);
                    named.push(name.clone());
                }
                ProbeLine::Node {
                    name,
                    position,
                    settings,
                } => {
                    if !duplicates::among(&names, name, self.report) {
                        return None;
                    }
                    let node = self.node(name, position, settings);
                    self.failed |= node.is_none();
                    nodes.push(node.unwrap_or_else(|| Node::named(&name.text)));
                    names.push(name.clone());
                }
                ProbeLine::Lattice {
                    spacing,
                    settings,
                    span,
                } => {
                    if lattice.is_some() {
                        return self.wrong(say::two_bodies(*span));
                    }
                    let read = self.lattice(spacing, settings, horizon);
                    self.failed |= read.is_none();
                    let place = read.unwrap_or(Place::Lattice {
                        spacing: 1.0,
                        gradient: [[0.0; 3]; 3],
                        fields: Vec::new(),
                    });
                    lattice = Some((place, *span));
                }
                _ => {}
            }
        }
        let cuts = self.cuts(written, &nodes, horizon);
        match (lattice, nodes.len()) {
            (None, 0) => self.wrong(say::no_body(&written.name)),
            (Some((_, span)), n) if n > 0 || !cuts.is_empty() => self.wrong(say::two_bodies(span)),
            (Some((lattice, _)), _) => Some(lattice),
            (None, n) if n > MAX_NODES => self.wrong(say::too_large(&written.name, MAX_NODES)),
            (None, _) => {
                if let Some((a, b)) = coinciding(&nodes).filter(|_| !self.failed) {
                    return self.wrong(say::coincide(&names[a], &names[b]));
                }
                Some(Place::Nodes(nodes, cuts))
            }
        }
    }

    fn node(&mut self, name: &Name, position: &Components, settings: &[Setting]) -> Option<Node> {
        let at = self.vector(position, &Unit::length());
        let mut right = at.is_some();
        let mut node = Node {
            position: at.unwrap_or_default(),
            ..Node::named(&name.text)
        };
        let mut volume = false;
        for setting in settings {
            let read = match setting.name.text.as_str() {
                "V" => {
                    volume = true;
                    let given = self.positive(setting, &Unit::volume());
                    given.map(|v| node.volume = v)
                }
                "u" => {
                    let given = self.vector(&setting.value, &Unit::length());
                    given.map(|u| node.u = u)
                }
                "v" => {
                    let given = self.vector(&setting.value, &Unit::velocity());
                    given.map(|v| node.v = v)
                }
                _ => {
                    let given = self.field(setting, &["V", "u", "v"]);
                    given.map(|field| node.fields.push(field))
                }
            };
            right &= read.is_some();
        }
        if !volume {
            return self.wrong(say::no_volume(name));
        }
        right.then_some(node)
    }

    fn lattice(
        &mut self,
        spacing: &ast::Expr,
        settings: &[Setting],
        horizon: f64,
    ) -> Option<Place> {
        let place = spacing.span;
        let spacing = self.values.of_unit(spacing, &Unit::length(), self.report);
        let (mut gradient, mut fields) = ([[0.0; 3]; 3], Vec::new());
        let mut right = true;
        for setting in settings {
            let read = match setting.name.text.as_str() {
                "H" => {
                    let values = self.shaped(&setting.value, Shape::Tensor, &Unit::NUMBER);
                    for (k, value) in values.iter().flatten().enumerate() {
                        gradient[k / self.flavour.dim()][k % self.flavour.dim()] = *value;
                    }
                    values.map(drop)
                }
                _ => self.field(setting, &["H"]).map(|field| fields.push(field)),
            };
            right &= read.is_some();
        }
        let spacing = spacing.filter(|_| right)?;
        let fits = spacing > 0.0 && horizon >= spacing && horizon <= MAX_REACH * spacing;
        if !fits && !self.failed {
            return self.wrong(say::reach(place, MAX_REACH));
        }
        Some(Place::Lattice {
            spacing,
            gradient,
            fields,
        })
    }

    fn field(
        &mut self,
        setting: &Setting,
        others: &[&str],
    ) -> Option<(crate::ir::FieldId, Vec<f64>)> {
        let fields = &self.law.fields;
        let Some(k) = fields.iter().position(|f| f.name == setting.name.text) else {
            let mut known: Vec<String> = others.iter().map(|n| n.to_string()).collect();
            known.extend(fields.iter().map(|f| f.name.clone()));
            return self.wrong(say::unknown_setting(&setting.name, &known));
        };
        let (shape, unit) = (fields[k].shape, fields[k].unit.clone());
        let values = self.shaped(&setting.value, shape, &unit)?;
        Some((crate::ir::FieldId(k as u32), values))
    }

    fn cuts(&mut self, written: &ast::Probe, nodes: &[Node], horizon: f64) -> Vec<(usize, usize)> {
        let mut cuts = Vec::new();
        for line in &written.lines {
            if let ProbeLine::Cut(a, b) = line {
                cuts.extend(self.bond(a, b, nodes, horizon));
            }
        }
        cuts
    }

    fn bond(&mut self, a: &Name, b: &Name, nodes: &[Node], horizon: f64) -> Option<(usize, usize)> {
        let (from, to) = (self.number_of(a, nodes)?, self.number_of(b, nodes)?);
        let bonded = self.failed || crate::probe::bonded(&nodes[from], &nodes[to], horizon);
        match from != to && bonded {
            true => Some((from, to)),
            false => self.wrong(say::no_bond(a, b)),
        }
    }

    fn number_of(&mut self, name: &Name, nodes: &[Node]) -> Option<usize> {
        let found = nodes.iter().position(|node| node.name == name.text);
        if found.is_none() {
            let known: Vec<String> = nodes.iter().map(|node| node.name.clone()).collect();
            self.report.push(say::unknown_node(name, &known));
        }
        found
    }

    // ---- numbers

    fn one<'e>(&mut self, written: &'e Components) -> Option<&'e ast::Expr> {
        match written.rows.as_slice() {
            [row] if row.len() == 1 => row.first(),
            _ => self.wrong(say::components(written.span, Shape::Scalar, self.flavour)),
        }
    }

    fn scalar(&mut self, written: &Components, unit: &Unit) -> Option<f64> {
        let expr = self.one(written)?;
        self.values.of_unit(expr, unit, self.report)
    }

    fn positive(&mut self, setting: &Setting, unit: &Unit) -> Option<f64> {
        let value = self.scalar(&setting.value, unit)?;
        match value > 0.0 && value.is_finite() {
            true => Some(value),
            false => self.wrong(say::not_positive(&setting.name, setting.value.span)),
        }
    }

    fn vector(&mut self, written: &Components, unit: &Unit) -> Option<[f64; 3]> {
        let values = self.shaped(written, Shape::Vector, unit)?;
        Some(std::array::from_fn(|a| {
            values.get(a).copied().unwrap_or_default()
        }))
    }

    fn shaped(&mut self, written: &Components, shape: Shape, unit: &Unit) -> Option<Vec<f64>> {
        self.components(written, shape, Some(unit))
    }

    /// The components, row by row, of which there must be as many as the shape has.
    fn components(
        &mut self,
        written: &Components,
        shape: Shape,
        unit: Option<&Unit>,
    ) -> Option<Vec<f64>> {
        let dim = self.flavour.dim();
        let (rows, columns) = match shape {
            Shape::Scalar | Shape::Boolean => (1, 1),
            Shape::Vector => (1, dim),
            Shape::Symmetric | Shape::Tensor => (dim, dim),
        };
        let fits = written.rows.len() == rows && written.rows.iter().all(|r| r.len() == columns);
        let square = matches!(shape, Shape::Symmetric | Shape::Tensor);
        if let [row] = written.rows.as_slice()
            && let [one] = row.as_slice()
            && let Some(factor) = uniform(one, square).filter(|_| square || !fits)
        {
            let value = match unit {
                Some(unit) => self.values.of_unit(&factor, unit, self.report)?,
                None => self.values.number(&factor, self.report)?.0,
            };
            let diagonal = |k: usize| {
                if k / columns == k % columns {
                    value
                } else {
                    0.0
                }
            };
            return Some((0..rows * columns).map(diagonal).collect());
        }
        if !fits {
            return self.wrong(say::components(written.span, shape, self.flavour));
        }
        let exprs = written.rows.iter().flatten();
        exprs
            .map(|expr| match unit {
                Some(unit) => self.values.of_unit(expr, unit, self.report),
                None => Some(self.values.number(expr, self.report)?.0),
            })
            .collect()
    }
}

/// What stands for all components: `0`, and of a tensor a number times `I`; then that number.
fn uniform(written: &ast::Expr, square: bool) -> Option<ast::Expr> {
    use ast::ExprKind::*;
    let within = |kind| {
        Some(ast::Expr {
            kind,
            span: written.span,
        })
    };
    let boxed = |e: &ast::Expr| uniform(e, square).map(Box::new);
    match &written.kind {
        Number(0.0, _) => Some(written.clone()),
        Name(name) if name == "I" && square => within(Number(1.0, None)),
        Neg(a) => within(Neg(boxed(a)?)),
        Binary(BinaryOp::Div, a, b) => within(Binary(BinaryOp::Div, boxed(a)?, b.clone())),
        Binary(BinaryOp::Mul, a, b) => match boxed(a) {
            Some(a) => within(Binary(BinaryOp::Mul, a, b.clone())),
            None => within(Binary(BinaryOp::Mul, a.clone(), boxed(b)?)),
        },
        _ => None,
    }
}

/// Two nodes at the same place.
fn coinciding(nodes: &[Node]) -> Option<(usize, usize)> {
    (0..nodes.len())
        .flat_map(|b| (0..b).map(move |a| (a, b)))
        .find(|(a, b)| nodes[*a].position == nodes[*b].position)
}
