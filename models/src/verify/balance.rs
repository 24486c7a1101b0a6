//! Balance of momentum, and a turn of the whole body.
//!
//! On a lattice with holes and a cloud, whole and with half of the bonds broken, strained by a percent: forces sum to
//! nothing, also where two materials meet; so do their moments about the deformed positions; and where the deformed body
//! is turned by one radian, forces turn with it and energies stay. The definition that is to blame is the first one, in the
//! order in which they depend on each other, whose value does neither stay nor turn.

use pdlang::ir::{Flavour, Home};
use pdlang::oracle::{self, Ball, Oracle, Value};
use pdlang_runtime::body::Body;

use super::ask::{self, Case, Vectors, largest, relative};
use super::place::Place;
use super::subject::{FORCE_DENSITY, PRESSURE, Subject, TEMPERATURE, fits, has_unit};
use super::{Level, Verdict, bodies};

const STRAIN: f64 = 1e-2;
const ANGLE: f64 = 1.0;
/// Rounding of sums of forces, whose own rounding is that of lengths over the strain.
const MOMENTUM: f64 = 1e-10;
const TURNED: f64 = 1e-9;

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    const CHECKS: [&str; 3] = ["linear_momentum", "angular_momentum", "objectivity"];
    if !subject.has_force() {
        let skip = |check| Verdict::skip(check, flavour, "the law has no force");
        return Ok(CHECKS.map(skip).to_vec());
    }
    let (mut linear, mut angular, mut turned) = (0.0_f64, 0.0_f64, 0.0_f64);
    for body in ask::bodies_of(subject, flavour) {
        for half in [false, true] {
            let broken = bodies::half_broken(&body, subject.horizon, 3);
            let mut case = Case::new(subject, flavour, body.clone())?;
            if half {
                case.cut(&broken);
            }
            warm(subject, &mut case);
            let u = bodies::deformation(&body, STRAIN, 4);
            let (force, energy) = answer(&mut case, &u);
            let (sum, moment) = sums(&body, &u, &force);
            (linear, angular) = (linear.max(sum), angular.max(moment));
            if flavour.dim() == 1 {
                continue;
            }
            let (rotated, same) = answer(&mut case, &turn(&body, &u));
            let about: Vectors = rotate(&body, &force);
            let scale = largest(force.as_flattened());
            turned = turned
                .max(relative(
                    rotated.as_flattened(),
                    about.as_flattened(),
                    scale,
                ))
                .max(relative(&same, &energy, largest(&energy)));
        }
    }
    let interface = interface(subject, flavour)?;
    let place = subject.force_place();
    let lost = if linear > MOMENTUM {
        unbalanced(subject, flavour)
    } else {
        None
    };
    let first = Verdict::error(CHECKS[0], flavour, linear.max(interface), MOMENTUM).blames(lost.or(place.clone()), |name| {
        let where_ = if linear > MOMENTUM { "" } else { " where two materials meet" };
        format!("forces do not sum to nothing{where_}: what {name} gives one end of a bond, the other does not lose")
    });
    if flavour.dim() == 1 {
        let skip = |check| Verdict::skip(check, flavour, "nothing turns in one dimension");
        return Ok(vec![first, skip(CHECKS[1]), skip(CHECKS[2])]);
    }
    let second = Verdict::error(CHECKS[1], flavour, angular, MOMENTUM).blames(place.clone(), |name| {
        format!("the forces of {name} turn the body as a whole: they do not act along the deformed bonds")
    });
    let mut third = Verdict::error(CHECKS[2], flavour, turned, TURNED);
    if third.level == Level::Fail {
        let unturned = unturned(subject, flavour).or(place);
        third = third.blames(unturned, |name| {
            format!("a turn by {ANGLE} rad changes {name}: it reads displacements where only lengths and angles of deformed bonds are the same")
        });
    }
    Ok(vec![first, second, third])
}

/// Gives temperatures a pattern, so that what they do is seen.
pub fn warm(subject: &Subject, case: &mut Case) {
    for (k, field, _) in ask::scalar_fields(subject.law, TEMPERATURE) {
        let mut random = bodies::Random(k as u64 + 11);
        let values: Vec<f64> = case.body.x.iter().map(|_| 50.0 * random.signed()).collect();
        case.set_field(&field.name, |node| values[node]);
    }
}

fn answer(case: &mut Case, u: &[[f64; 3]]) -> (Vectors, Vec<f64>) {
    case.displace(u);
    (case.force(), case.energy())
}

/// Sum of the forces over that of their sizes, and of their moments about deformed positions.
fn sums(body: &Body, u: &[[f64; 3]], force: &[[f64; 3]]) -> (f64, f64) {
    let (mut sum, mut moment, mut size) = ([0.0; 3], [0.0; 3], 0.0);
    let middle = centre(body);
    let mut arm = 0.0_f64;
    for (i, f) in force.iter().enumerate() {
        let load = f.map(|c| c * body.volume[i]);
        let y: [f64; 3] = std::array::from_fn(|a| body.x[i][a] + u[i][a] - middle[a]);
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            sum[a] += load[a];
            moment[a] += y[b] * load[c] - y[c] * load[b];
        }
        size += norm(load);
        arm = arm.max(norm(y));
    }
    let part = |worst: f64, scale: f64| if worst == 0.0 { 0.0 } else { worst / scale };
    (
        part(largest(&sum), size),
        part(largest(&moment), size * arm),
    )
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn centre(body: &Body) -> [f64; 3] {
    std::array::from_fn(|a| body.x.iter().map(|x| x[a]).sum::<f64>() / body.x.len() as f64)
}

/// Displacements of the body that is displaced by `u` and then turned.
fn turn(body: &Body, u: &[[f64; 3]]) -> Vectors {
    let moved: Vectors = body
        .x
        .iter()
        .zip(u)
        .map(|(x, u)| std::array::from_fn(|a| x[a] + u[a]))
        .collect();
    let turned = rotate(body, &moved);
    turned
        .iter()
        .zip(&body.x)
        .map(|(y, x)| std::array::from_fn(|a| y[a] - x[a]))
        .collect()
}

/// Vectors turned as [`turn`] turns bodies.
fn rotate(body: &Body, vectors: &[[f64; 3]]) -> Vectors {
    let like = Body {
        x: vectors.to_vec(),
        ..body.clone()
    };
    let change = bodies::rotation(&like, ANGLE);
    vectors
        .iter()
        .zip(&change)
        .map(|(v, d)| std::array::from_fn(|a| v[a] + d[a]))
        .collect()
}

/// Two materials side by side: the sum of the forces over that of their sizes.
fn interface(subject: &Subject, flavour: Flavour) -> Result<f64, String> {
    let (body, materials) = halves(subject, flavour);
    let mut case = Case::of_materials(subject, flavour, body, materials)?;
    warm(subject, &mut case);
    let u = bodies::deformation(&case.body, STRAIN, 5);
    let (force, _) = answer(&mut case, &u);
    Ok(sums(&case.body, &u, &force).0)
}

/// A body of two materials, the second stiffer and a better conductor.
pub fn halves(subject: &Subject, flavour: Flavour) -> (Body, Vec<Vec<f64>>) {
    let [mut body, _] = ask::bodies_of(subject, flavour);
    let middle = centre(&body)[0];
    body.material = body.x.iter().map(|x| u8::from(x[0] > middle)).collect();
    let other = (subject.law.params.iter().zip(&subject.params)).map(|(param, value)| {
        let factor = match () {
            () if has_unit(&param.unit, PRESSURE) => 2.0,
            () if has_unit(&param.unit, super::subject::CONDUCTIVITY) => 3.0,
            () => 1.0,
        };
        Some(value * factor)
            .filter(|v| fits(param, *v))
            .unwrap_or(*value)
    });
    let other = other.collect();
    (body, vec![subject.params.clone(), other])
}

/// The first force density of a node that does not sum to nothing.
fn unbalanced(subject: &Subject, flavour: Flavour) -> Option<Place> {
    let (body, explicit) = few(subject, flavour);
    let settings = subject.settings(flavour, Ball::Integral { cross: body.cross });
    let oracle = Oracle::new(subject.law, &explicit, &settings).ok()?;
    let mut state = oracle.state();
    state.u = bodies::deformation(&body, STRAIN, 4);
    let found = subject.definitions().find(|def| {
        if def.home != Home::Node || !has_unit(&def.unit, FORCE_DENSITY) {
            return false;
        }
        let values: Vec<Vec<f64>> = match oracle.named(&state, &def.name) {
            Ok(values) => values.iter().map(flat).collect(),
            Err(_) => return false,
        };
        let width = values.first().map_or(0, Vec::len);
        (0..width).any(|k| {
            let loads: Vec<f64> = values
                .iter()
                .zip(&body.volume)
                .map(|(v, volume)| v[k] * volume)
                .collect();
            let size: f64 = loads.iter().map(|l| l.abs()).sum();
            loads.iter().sum::<f64>().abs() > 1e-9 * size
        })
    });
    found.and_then(|def| subject.place(def.span))
}

/// A few nodes of a cloud, as the oracle has them.
fn few(subject: &Subject, flavour: Flavour) -> (Body, oracle::Body) {
    let [_, cloud] = ask::bodies_of(subject, flavour);
    let middle = centre(&cloud);
    let away = |i: &usize| norm(std::array::from_fn(|a| cloud.x[*i][a] - middle[a]));
    let mut near: Vec<usize> = (0..cloud.x.len()).collect();
    near.sort_by(|i, j| away(i).total_cmp(&away(j)));
    near.truncate(14);
    let body = Body {
        x: near.iter().map(|i| cloud.x[*i]).collect(),
        volume: near.iter().map(|i| cloud.volume[*i]).collect(),
        ..cloud
    };
    let nodes = body.x.iter().zip(&body.volume);
    let nodes = nodes
        .map(|(x, v)| oracle::Node {
            position: *x,
            volume: *v,
        })
        .collect();
    let explicit = oracle::Body::within(nodes, subject.horizon);
    (body, explicit)
}

/// The first definition whose values neither stay nor turn with the body.
fn unturned(subject: &Subject, flavour: Flavour) -> Option<Place> {
    let (body, explicit) = few(subject, flavour);
    let settings = subject.settings(flavour, Ball::Integral { cross: body.cross });
    let oracle = Oracle::new(subject.law, &explicit, &settings).ok()?;
    let mut state = oracle.state();
    state.u = bodies::deformation(&body, STRAIN, 4);
    let mut rotated = state.clone();
    rotated.u = turn(&body, &state.u);
    let unit: Vectors = (0..3)
        .map(|k| std::array::from_fn(|a| f64::from(u8::from(a == k))))
        .collect();
    let columns = rotate(&body, &unit);
    let q: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i]));
    for def in subject
        .definitions()
        .filter(|def| def.home != Home::Constant)
    {
        let (before, after) = (
            oracle.named(&state, &def.name).ok()?,
            oracle.named(&rotated, &def.name).ok()?,
        );
        let scale = before
            .iter()
            .chain(&after)
            .flat_map(flat)
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        let ways = before.first().map_or(0, |v| ways(v, &q).len());
        let fits = |way: usize| {
            before.iter().zip(&after).all(|(a, b)| {
                let expected = ways_of(a, &q, way);
                relative(&flat(&expected), &flat(b), scale) < 1e-6
            })
        };
        if !(0..ways).any(fits) {
            return subject.place(def.span);
        }
    }
    None
}

fn ways_of(value: &Value<f64>, q: &[[f64; 3]; 3], way: usize) -> Value<f64> {
    ways(value, q)[way]
}

/// The ways in which a value may follow a turn `q`.
fn ways(value: &Value<f64>, q: &[[f64; 3]; 3]) -> Vec<Value<f64>> {
    let times = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|k| (0..3).map(|j| a[i][j] * b[j][k]).sum()))
    };
    match value {
        Value::Vector(v) => {
            let turned = std::array::from_fn(|i| (0..3).map(|k| q[i][k] * v[k]).sum());
            vec![*value, Value::Vector(turned)]
        }
        Value::Tensor(t) => {
            let back = std::array::from_fn(|i| std::array::from_fn(|k| q[k][i]));
            let (left, right) = (times(q, t), times(t, &back));
            // A gradient of positions turns on the left, its change as well, less the unit tensor.
            let unit: [[f64; 3]; 3] =
                std::array::from_fn(|i| std::array::from_fn(|k| f64::from(u8::from(i == k))));
            let moved =
                std::array::from_fn(|i| std::array::from_fn(|k| left[i][k] + q[i][k] - unit[i][k]));
            vec![
                *value,
                Value::Tensor(left),
                Value::Tensor(right),
                Value::Tensor(times(&left, &back)),
                Value::Tensor(moved),
            ]
        }
        other => vec![*other],
    }
}

fn flat(value: &Value<f64>) -> Vec<f64> {
    match value {
        Value::Scalar(a) => vec![*a],
        Value::Vector(v) => v.to_vec(),
        Value::Tensor(t) => t.as_flattened().to_vec(),
        Value::Boolean(b) => vec![f64::from(u8::from(*b))],
    }
}
