//! Probes of a law: written numbers become SI values, names become ids.
//!
//! A probe is read when its law is right. Everything in it is evaluated here, in the order of the text, so
//! that what is expected may use parameters, `delta`, `dim` and what a `let` of the probe has named, but
//! nothing that the law computes.

use crate::ast::{self, Components, Name, ProbeLine, Setting};
use crate::check::{duplicates, flavours, probes as say};
use crate::diag::Diagnostic;
use crate::ir::{Flavour, Home, InfluenceFn, Law, Response, Shape};
use crate::probe::{
    Expectation, MAX_NODES, MAX_REACH, Node, Place, Probe, Quantity, TOLERANCE, Within,
};
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
        let settings = self.settings(written)?;
        let place = self.place(written, settings.horizon)?;
        let mut expectations = Vec::new();
        for line in &written.lines {
            if let ProbeLine::Expect(expected) = line {
                expectations.extend(self.expectation(expected, &place, settings.horizon));
            }
        }
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
        for setting in &written.settings {
            let name = &setting.name;
            if !duplicates::among(&given, name, self.report) {
                return None;
            }
            given.push(name.clone());
            if let Some(k) = law.params.iter().position(|p| p.name == name.text) {
                let param = &law.params[k];
                let value = self.scalar(&setting.value, &param.unit)?;
                if !crate::check::bounds::contains(param.lower, param.upper, value) {
                    return self.wrong(say::outside(name, setting.value.span));
                }
                params[k] = Some(value);
                self.values.add(&name.text, value, param.unit.clone());
            } else if let Some(k) = law.influences.iter().position(|i| i.name == name.text) {
                let expr = self.one(&setting.value)?;
                influences[k] = influence::choice(expr, self.values.library, self.report);
                influences[k].as_ref()?;
            } else if law.weights.iter().any(|w| w.name == name.text) {
                if self.scalar(&setting.value, &Unit::NUMBER)? != 1.0 {
                    return self.wrong(say::not_one(name, setting.value.span));
                }
                without.push(name.text.clone());
            } else {
                match (name.text.as_str(), self.flavour.dim()) {
                    ("delta", _) => {
                        let value = self.positive(setting, &Unit::length())?;
                        self.values.add("delta", value, Unit::length());
                        horizon = Some(value);
                    }
                    ("thickness", 2) => cross = self.positive(setting, &Unit::length())?,
                    ("area", 1) => {
                        cross = self.positive(setting, &Unit::length().times(&Unit::length()))?
                    }
                    _ => return self.wrong(say::unknown_setting(name, &self.settable())),
                }
            }
        }
        let settings = self.complete(written, params, influences, horizon, cross)?;
        Some(Settings {
            without,
            ..settings
        })
    }

    fn complete(
        &mut self,
        written: &ast::Probe,
        params: Vec<Option<f64>>,
        influences: Vec<Option<InfluenceFn>>,
        horizon: Option<f64>,
        cross: f64,
    ) -> Option<Settings> {
        let law = self.law;
        let mut missing: Vec<&str> = Vec::new();
        for (param, value) in law.params.iter().zip(&params) {
            match value {
                None => missing.push(&param.name),
                Some(value) => self.values.add_new(&param.name, *value, &param.unit),
            }
        }
        for (slot, function) in law.influences.iter().zip(&influences) {
            missing.extend(function.is_none().then_some(slot.name.as_str()));
        }
        missing.extend(horizon.is_none().then_some("delta"));
        if !missing.is_empty() {
            return self.wrong(say::missing(&written.name, &missing));
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
                    nodes.push(self.node(name, position, settings)?);
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
                    lattice = Some((self.lattice(spacing, settings, horizon)?, *span));
                }
                _ => {}
            }
        }
        let cuts = self.cuts(written, &nodes, horizon)?;
        match (lattice, nodes.len()) {
            (None, 0) => self.wrong(say::no_body(&written.name)),
            (Some((_, span)), n) if n > 0 || !cuts.is_empty() => self.wrong(say::two_bodies(span)),
            (Some((lattice, _)), _) => Some(lattice),
            (None, n) if n > MAX_NODES => self.wrong(say::too_large(&written.name, MAX_NODES)),
            (None, _) => {
                if let Some((a, b)) = coinciding(&nodes) {
                    return self.wrong(say::coincide(&names[a], &names[b]));
                }
                Some(Place::Nodes(nodes, cuts))
            }
        }
    }

    fn node(&mut self, name: &Name, position: &Components, settings: &[Setting]) -> Option<Node> {
        let mut node = Node {
            name: name.text.clone(),
            position: self.vector(position, &Unit::length())?,
            volume: 0.0,
            u: [0.0; 3],
            v: [0.0; 3],
            fields: Vec::new(),
        };
        for setting in settings {
            match setting.name.text.as_str() {
                "V" => node.volume = self.positive(setting, &Unit::volume())?,
                "u" => node.u = self.vector(&setting.value, &Unit::length())?,
                "v" => node.v = self.vector(&setting.value, &Unit::velocity())?,
                _ => node.fields.push(self.field(setting, &["V", "u", "v"])?),
            }
        }
        match node.volume > 0.0 {
            true => Some(node),
            false => self.wrong(say::no_volume(name)),
        }
    }

    fn lattice(
        &mut self,
        spacing: &ast::Expr,
        settings: &[Setting],
        horizon: f64,
    ) -> Option<Place> {
        let place = spacing.span;
        let spacing = self.values.of_unit(spacing, &Unit::length(), self.report)?;
        let (mut gradient, mut fields) = ([[0.0; 3]; 3], Vec::new());
        for setting in settings {
            match setting.name.text.as_str() {
                "H" => {
                    let values = self.shaped(&setting.value, Shape::Tensor, &Unit::NUMBER)?;
                    for (k, value) in values.iter().enumerate() {
                        gradient[k / self.flavour.dim()][k % self.flavour.dim()] = *value;
                    }
                }
                _ => fields.push(self.field(setting, &["H"])?),
            }
        }
        if !(spacing > 0.0 && horizon >= spacing && horizon <= MAX_REACH * spacing) {
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

    fn cuts(
        &mut self,
        written: &ast::Probe,
        nodes: &[Node],
        horizon: f64,
    ) -> Option<Vec<(usize, usize)>> {
        let mut cuts = Vec::new();
        for line in &written.lines {
            if let ProbeLine::Cut(a, b) = line {
                cuts.push(self.bond(a, b, nodes, horizon)?);
            }
        }
        Some(cuts)
    }

    fn bond(&mut self, a: &Name, b: &Name, nodes: &[Node], horizon: f64) -> Option<(usize, usize)> {
        let (from, to) = (self.number_of(a, nodes)?, self.number_of(b, nodes)?);
        match from != to && crate::probe::bonded(&nodes[from], &nodes[to], horizon) {
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

    // ---- what is expected

    fn expectation(
        &mut self,
        written: &ast::Expectation,
        place: &Place,
        horizon: f64,
    ) -> Option<Expectation> {
        let (quantity, shape, unit) = self.quantity(written, place, horizon)?;
        // The unit of an influence function is its own business: then any unit is right.
        let known = unit.opaque.is_empty();
        let value = match known {
            true => self.shaped(&written.value, shape, &unit)?,
            false => self.components(&written.value, shape, None)?,
        };
        let expects_zero = value.iter().all(|v| *v == 0.0);
        let within = match &written.within {
            None => Within::Relative(TOLERANCE),
            Some(expr) => {
                let (value, found) = self.values.number(expr, self.report)?;
                match found.is_number() {
                    _ if !(value.is_finite() && value >= 0.0) => {
                        return self.wrong(say::tolerance(expr.span));
                    }
                    // Zero has no part of itself.
                    true if unit.is_number() && expects_zero => Within::Absolute(value),
                    true => Within::Relative(value),
                    false if found == unit || !known => Within::Absolute(value),
                    false => return self.wrong(say::tolerance(expr.span)),
                }
            }
        };
        let at: Vec<&str> = written
            .place
            .iter()
            .map(|name| name.text.as_str())
            .collect();
        let rate = if written.rate { "rate " } else { "" };
        let at = match at.is_empty() {
            true => String::new(),
            false => format!("({})", at.join(", ")),
        };
        Some(Expectation {
            text: format!("{rate}{}{at}", written.name.text),
            quantity,
            value,
            unit: unit.without_opaque(),
            within,
            span: written.value.span,
        })
    }

    fn on_bond(
        &mut self,
        written: &ast::Expectation,
        place: &Place,
        horizon: f64,
    ) -> Option<(usize, usize)> {
        match (place, written.place.as_slice()) {
            (Place::Nodes(nodes, _), [a, b]) => self.bond(a, b, nodes, horizon),
            _ => self.wrong(say::place(
                &written.name,
                "on a bond between two nodes",
                "(a, b)",
            )),
        }
    }

    /// The quantity that is meant, its shape and its unit.
    fn quantity(
        &mut self,
        written: &ast::Expectation,
        place: &Place,
        horizon: f64,
    ) -> Option<(Quantity, Shape, Unit)> {
        let law = self.law;
        let name = &written.name;
        if written.rate {
            let Some(Response::Rate(field, _)) = law.responses.iter().find(
                |r| matches!(r, Response::Rate(f, _) if law.fields[f.index()].name == name.text),
            ) else {
                let known: Vec<String> = law.fields.iter().map(|f| f.name.clone()).collect();
                return self.wrong(say::unknown_quantity(name, &known));
            };
            let f = &law.fields[field.index()];
            let unit = f.unit.per(&Unit::time());
            let node = self.at_node(written, place)?;
            return Some((Quantity::Rate(*field, node), f.shape, unit));
        }
        if let Some(k) = law.defs.iter().position(|def| def.name == name.text) {
            let (def, id) = (&law.defs[k], crate::ir::DefId(k as u32));
            let quantity = match def.home {
                Home::Constant if written.place.is_empty() => Quantity::Constant(id),
                Home::Constant => return self.wrong(say::place(name, "nowhere", "")),
                Home::Node => Quantity::AtNode(id, self.at_node(written, place)?),
                Home::Bond => {
                    let (from, to) = self.on_bond(written, place, horizon)?;
                    Quantity::OnBond(id, from, to)
                }
            };
            return Some((quantity, def.shape, def.unit.clone()));
        }
        if let Some(k) = law.weights.iter().position(|w| w.name == name.text) {
            let (from, to) = self.on_bond(written, place, horizon)?;
            let id = crate::ir::WeightId(k as u32);
            return Some((Quantity::Weight(id, from, to), Shape::Scalar, Unit::NUMBER));
        }
        if name.text == "force" {
            let node = self.at_node(written, place)?;
            return Some((Quantity::Force(node), Shape::Vector, Unit::force_density()));
        }
        if self.energy == Some(name.text.as_str()) {
            let node = self.at_node(written, place)?;
            return Some((
                Quantity::Energy(node),
                Shape::Scalar,
                Unit::energy_density(),
            ));
        }
        // A copy that `under` made has a name that no text can write.
        let named = law.defs.iter().map(|def| &def.name);
        let named = named.filter(|name| !name.contains(' '));
        let mut known: Vec<String> = named.cloned().collect();
        known.extend(law.weights.iter().map(|w| w.name.clone()));
        known.extend(self.energy.map(String::from));
        known.push("force".into());
        self.wrong(say::unknown_quantity(name, &known))
    }

    fn at_node(&mut self, written: &ast::Expectation, place: &Place) -> Option<usize> {
        match (place, written.place.as_slice()) {
            (Place::Lattice { .. }, []) => Some(0),
            (Place::Nodes(nodes, _), [name]) => self.number_of(name, nodes),
            (Place::Lattice { .. }, _) => {
                self.wrong(say::place(&written.name, "at the node of the lattice", ""))
            }
            (Place::Nodes(..), _) => self.wrong(say::place(&written.name, "at a node", "(a)")),
        }
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

/// Two nodes at the same place.
fn coinciding(nodes: &[Node]) -> Option<(usize, usize)> {
    (0..nodes.len())
        .flat_map(|b| (0..b).map(move |a| (a, b)))
        .find(|(a, b)| nodes[*a].position == nodes[*b].position)
}
