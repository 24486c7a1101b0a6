//! PD104: an energy beside a bond force, whose forces add up.

use crate::ast::{Item, Model, ResponseKind};
use crate::diag::Diagnostic;

const CODE: &str = "PD104";

/// A warning for each `pair` or `state` of a model that has an energy too.
pub(crate) fn warnings(model: &Model) -> Vec<Diagnostic> {
    let responses = || {
        model.items.iter().filter_map(|item| match item {
            Item::Response(response) => Some(response),
            _ => None,
        })
    };
    let Some(energy) = responses().find(|r| r.kind == ResponseKind::Energy) else {
        return Vec::new();
    };
    let on_bonds = |kind| matches!(kind, ResponseKind::Pair | ResponseKind::State);
    let forces = responses().filter(|r| on_bonds(r.kind));
    forces
        .map(|force| {
            let (f, w) = (&force.name, &energy.name);
            let message = format!("the forces of `{}` and `{}` add up", f.text, w.text);
            Diagnostic::warning(CODE, message)
                .at(f.span, "a force of its own")
                .at(w.span, "the force of this energy is beside it")
                .help("an energy already gives its force; an energy only to look at is a `node` value")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::check::tests::law;
    use crate::front;

    #[test]
    fn warns_of_every_force_beside_an_energy() {
        let found = |items: &str| -> Vec<String> {
            let findings = front::file(&law(items)).diagnostics.into_iter();
            let added = findings.filter(|f| f.code == super::CODE);
            added.map(|f| f.message).collect()
        };
        let force = "K*s/(delta*ball(1))";
        assert_eq!(found(""), [""; 0]);
        assert_eq!(
            found(&format!("pair f = {force} state g = {force}")),
            [
                "the forces of `f` and `W` add up",
                "the forces of `g` and `W` add up"
            ]
        );
    }
}
