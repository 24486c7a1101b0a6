//! An evaluation is a function of the state.
//!
//! On a lattice with holes and a cloud with half of the bonds broken: evaluated again, also after another state in
//! between, every answer has the same bits; with the nodes in another order it is the same up to rounding.

use pdlang::ir::Flavour;

use super::ask::{self, Case, largest, relative};
use super::subject::{Subject, TEMPERATURE};
use super::{Verdict, balance, bodies};

const STRAIN: f64 = 1e-2;
const ORDER: f64 = 1e-10;

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    let mut worst = 0.0_f64;
    let mut repeats = true;
    for body in ask::bodies_of(subject, flavour) {
        let mut case = Case::new(subject, flavour, body.clone())?;
        let broken = bodies::half_broken(&body, subject.horizon, 5);
        case.cut(&broken);
        balance::warm(subject, &mut case);
        let u = bodies::deformation(&body, STRAIN, 6);
        let first = answers(subject, &mut case, &u);
        answers(subject, &mut case, &bodies::deformation(&body, STRAIN, 9));
        repeats &= first == answers(subject, &mut case, &u);

        let (other, order) = bodies::shuffled(&body, 1);
        let mut shuffled = Case::new(subject, flavour, other)?;
        shuffled.cut(&moved(&broken, &order));
        for (_, field, _) in ask::scalar_fields(subject.law, TEMPERATURE) {
            for slot in case.engine.state_slots(&field.name).unwrap_or_default() {
                let here = |node: usize| {
                    case.engine
                        .value(&case.state, slot, case.engine.slot(order[node]))
                };
                shuffled.set_field(&field.name, here);
            }
        }
        let placed: Vec<[f64; 3]> = order.iter().map(|k| u[*k]).collect();
        let again = answers(subject, &mut shuffled, &placed);
        for (a, b) in first.iter().zip(&again) {
            // Vectors per node, node after node.
            let width = a.len() / order.len().max(1);
            let there: Vec<f64> = order
                .iter()
                .flat_map(|k| a[k * width..][..width].to_vec())
                .collect();
            worst = worst.max(relative(&there, b, largest(a)));
        }
    }
    let error = if repeats { worst } else { f64::INFINITY };
    let verdict = Verdict::error("purity", flavour, error, ORDER);
    Ok(vec![verdict.blames(
        subject.force_place(),
        |name| match repeats {
            true => format!("the answers of {name} depend on the order of the nodes"),
            false => format!("{name} answers differently when it is asked twice"),
        },
    )])
}

/// Pairs of nodes in the other order.
fn moved(
    pairs: &std::collections::HashSet<(usize, usize)>,
    order: &[usize],
) -> std::collections::HashSet<(usize, usize)> {
    let mut place = vec![0; order.len()];
    for (to, from) in order.iter().enumerate() {
        place[*from] = to;
    }
    pairs.iter().map(|(i, j)| (place[*i], place[*j])).collect()
}

fn answers(subject: &Subject, case: &mut Case, u: &[[f64; 3]]) -> Vec<Vec<f64>> {
    case.displace(u);
    let mut answers = vec![case.force().into_flattened(), case.energy()];
    for (_, field, rated) in ask::scalar_fields(subject.law, TEMPERATURE) {
        if rated {
            answers.push(case.rate(&field.name));
        }
    }
    answers
}
