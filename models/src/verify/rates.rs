//! What flows along bonds, and the heat of deformation.
//!
//! A scalar field whose rate is zero where the field is the same everywhere is one that is exchanged along bonds: then the
//! volume integral of capacity times rate is zero, whole, broken and where two materials meet, and what is uneven becomes
//! less so. A rate of temperature that follows the velocity belongs to a force that follows the temperature: the heat that
//! velocities `v` take at temperatures `T` is `T0` times the work of the thermal force on `v`, whatever both are.

use pdlang::ir::{BinaryOp, ExprId, ExprKind, Flavour, Home, Response, Shape};
use pdlang_runtime::body::Body;

use super::ask::{self, Case, largest};
use super::place::{Place, expr_of};
use super::subject::{Subject, TEMPERATURE, has_unit};
use super::{Level, Verdict, balance, bodies, constants, place};

/// Rounding of a sum of rates.
const BALANCED: f64 = 1e-10;

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    const CHECKS: [&str; 2] = ["conservation", "dissipation"];
    let law = subject.law;
    let mut verdicts = Vec::new();
    for (k, field) in law.fields.iter().enumerate() {
        let rate = |r: &Response| matches!(r, Response::Rate(f, _) if f.index() == k);
        if !law.responses.iter().any(rate) || field.shape != Shape::Scalar {
            continue;
        }
        let (body, materials) = balance::halves(subject, flavour);
        let capacities: Vec<f64> = materials
            .iter()
            .map(|p| constants::capacity(law, p).unwrap_or(1.0))
            .collect();
        if !exchanged(subject, flavour, &field.name, &body)? {
            let why = format!("`{}` has sources of its own", field.name);
            verdicts.extend(CHECKS.map(|check| Verdict::skip(check, flavour, &why)));
            continue;
        }
        let (mut made, mut uphill) = (0.0_f64, f64::NEG_INFINITY);
        let mut at_interface = false;
        let [lattice, cloud] = ask::bodies_of(subject, flavour);
        for (body, materials) in [
            (lattice, vec![subject.params.clone()]),
            (cloud, vec![subject.params.clone()]),
            (body, materials.clone()),
        ] {
            for half in [false, true] {
                let values = pattern(&body);
                let mut case =
                    Case::of_materials(subject, flavour, body.clone(), materials.clone())?;
                if half {
                    case.cut(&bodies::half_broken(&body, subject.horizon, 3));
                }
                case.set_field(&field.name, |node| values[node]);
                let rate = case.rate(&field.name);
                let of =
                    |i: usize| capacities[usize::from(body.material.get(i).copied().unwrap_or(0))];
                let heat: Vec<f64> = (0..rate.len())
                    .map(|i| rate[i] * body.volume[i] * of(i))
                    .collect();
                let size: f64 = heat
                    .iter()
                    .map(|h| h.abs())
                    .sum::<f64>()
                    .max(f64::MIN_POSITIVE);
                let lost = (heat.iter().sum::<f64>() / size).abs();
                let lost = if lost.is_nan() { f64::INFINITY } else { lost };
                if lost > made {
                    at_interface = materials.len() > 1 && made <= BALANCED;
                    made = lost;
                }
                let flow: f64 = heat.iter().zip(&values).map(|(h, v)| h * v).sum();
                uphill = uphill.max(flow / (size * largest(&values)));
            }
        }
        let conserved = Verdict::error(CHECKS[0], flavour, made, BALANCED).of(field.name.clone());
        let guilty = if made > BALANCED {
            unbalanced(subject, k)
        } else {
            None
        };
        verdicts.push(conserved.blames(guilty.or(subject.rate_place(k)), |name| {
            let where_ = if at_interface { " where two materials meet" } else { "" };
            format!("{:.0e} of what flows is made or lost{where_}: {name} differs from the two ends of a bond", made)
        }));
        let level = if uphill <= BALANCED {
            Level::Pass
        } else {
            Level::Fail
        };
        let verdict = Verdict {
            measured: Some(uphill),
            expected: Some(0.0),
            ..Verdict::new(CHECKS[1], flavour, level)
        };
        verdicts.push(
            verdict
                .of(field.name.clone())
                .blames(subject.rate_place(k), |name| {
                    format!(
                        "`{}` flows from low to high: a sign of {name} is wrong",
                        field.name
                    )
                }),
        );
    }
    if verdicts.is_empty() {
        let skip = |check| Verdict::skip(check, flavour, "no scalar field has a rate");
        verdicts.extend(CHECKS.map(skip));
    }
    Ok(verdicts)
}

/// Values without structure.
fn pattern(body: &Body) -> Vec<f64> {
    let mut random = bodies::Random(77);
    body.x.iter().map(|_| random.signed()).collect()
}

/// Whether nothing happens where the field is the same everywhere.
fn exchanged(
    subject: &Subject,
    flavour: Flavour,
    field: &str,
    body: &Body,
) -> Result<bool, String> {
    let body = Body {
        material: Vec::new(),
        ..body.clone()
    };
    let mut case = Case::new(subject, flavour, body.clone())?;
    case.set_field(field, |_| 1.0);
    let even = largest(&case.rate(field));
    let values = pattern(&body);
    case.set_field(field, |node| values[node]);
    Ok(even <= 1e-9 * largest(&case.rate(field)))
}

/// A constant or node value of the law that stands outside of the sum that it scales: it belongs to one end of the bonds.
fn unbalanced(subject: &Subject, field: usize) -> Option<Place> {
    let law = subject.law;
    let of = |r: &&Response| matches!(r, Response::Rate(f, _) if f.index() == field);
    let sums = |e: ExprId| place::contains(law, e, &|kind| matches!(kind, ExprKind::Reduce(..)));
    let mut queue = vec![expr_of(law.responses.iter().find(of)?)];
    while let Some(expr) = queue.pop() {
        let kind = &law.exprs[expr.index()].kind;
        if let ExprKind::Binary(BinaryOp::Mul, a, b) = *kind {
            for (factor, rest) in [(a, b), (b, a)] {
                if let (ExprKind::Def(def), true) = (&law.exprs[factor.index()].kind, sums(rest))
                    && law.defs[def.index()].home != Home::Bond
                    && !law.defs[def.index()].span.prelude
                {
                    return subject.place(law.defs[def.index()].span);
                }
            }
        }
        queue.extend(kind.operands());
    }
    None
}

/// Heat of deformation and thermal force.
pub fn coupling(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    const CHECK: &str = "coupling";
    let law = subject.law;
    let fields = ask::scalar_fields(law, TEMPERATURE);
    let heated = fields.iter().find(|(.., rated)| *rated);
    let absolute = law
        .params
        .iter()
        .position(|p| has_unit(&p.unit, TEMPERATURE));
    let (Some((k, field, _)), Some(absolute), true) = (heated, absolute, subject.has_force())
    else {
        let why = "the law has no heat of deformation";
        return Ok(vec![Verdict::skip(CHECK, flavour, why)]);
    };
    let capacity = constants::capacity(law, &subject.params).unwrap_or(1.0);
    let t0 = subject.params[absolute];
    let mut worst = (0.0_f64, 1.0);
    let mut taken = false;
    for body in ask::bodies_of(subject, flavour) {
        let values = pattern(&body);
        let v = bodies::deformation(&body, 1.0, 21);
        let mut case = Case::new(subject, flavour, body.clone())?;
        case.set_velocity(&v);
        let rate = case.rate(&field.name);
        taken |= rate.iter().any(|r| *r != 0.0);
        let heat: f64 = (0..rate.len())
            .map(|i| values[i] * capacity * body.volume[i] * rate[i])
            .sum();
        let mut warm = Case::new(subject, flavour, body.clone())?;
        warm.set_field(&field.name, |node| values[node]);
        let force = warm.force();
        let power = |i: usize| body.volume[i] * (0..3).map(|a| force[i][a] * v[i][a]).sum::<f64>();
        let work: f64 = (0..force.len()).map(power).sum();
        let size: f64 = (0..force.len())
            .map(|i| power(i).abs())
            .sum::<f64>()
            .max(f64::MIN_POSITIVE);
        let off = ((heat + t0 * work) / (t0 * size)).abs();
        if off > worst.0 || off.is_nan() {
            worst = (off, -heat / (t0 * work));
        }
    }
    if !taken {
        let why = format!(
            "one way: `{0}` acts on the body, and no deformation on `{0}`",
            field.name
        );
        return Ok(vec![Verdict::skip(CHECK, flavour, &why)]);
    }
    let verdict = Verdict::error(CHECK, flavour, worst.0, BALANCED).of(field.name.clone());
    Ok(vec![verdict.blames(subject.rate_place(*k), |name| {
        format!("the heat that {name} takes from a deformation is {:.4} of what the thermal force works", worst.1)
    })])
}
