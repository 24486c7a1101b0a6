//! What a probe expects: a quantity of the law at its place, its value, and how near.

use super::Reader;
use crate::ast;
use crate::check::probes as say;
use crate::ir::{Home, Response, Shape};
use crate::probe::{Expectation, Place, Quantity, TOLERANCE, Within};
use crate::units::Unit;

impl Reader<'_> {
    pub(super) fn expectation(
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
            (Place::Lattice { .. }, _) => self.wrong(say::bonds_without_names(&written.name)),
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
}
