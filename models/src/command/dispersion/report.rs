//! The waves of one series, as tables for a reader and as JSON.

use pdlang_models::waves::{self, Moving, Study};
use serde_json::{Value, json};

use super::super::table::Table;

/// What a heading says of a series.
pub(super) struct Shown {
    pub law: String,
    pub params: Vec<(String, f64)>,
    pub given: Vec<(String, f64)>,
    pub influences: Vec<String>,
    pub written: Option<String>,
    pub reach: f64,
}

/// Six digits.
fn digits(value: f64) -> Value {
    let scientific = format!("{value:.5e}");
    let power = scientific
        .split_once('e')
        .and_then(|(_, p)| p.parse::<i32>().ok());
    match power {
        _ if value == 0.0 => json!("0"),
        Some(power @ -3..6) => {
            let places = (5 - power) as usize;
            json!(format!("{value:.places$}"))
        }
        _ => json!(scientific),
    }
}

fn maybe(value: Option<f64>) -> Value {
    value.map_or(Value::Null, digits)
}

fn vector(v: &[f64; 3], dim: usize) -> String {
    let shown: Vec<String> = v
        .iter()
        .take(dim)
        .map(|c| format!("{}", rounded(*c)))
        .collect();
    format!("({})", shown.join(", "))
}

/// Four digits behind the point, without a negative zero.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

pub(super) fn text_of(shown: &Shown, study: &Study) -> String {
    let dim = study.flavour.dim();
    let dx = study.spacing;
    let motion = study.moving == Moving::Displacement;
    let given: Vec<String> = shown
        .given
        .iter()
        .map(|(n, v)| format!("{n} = {v}"))
        .collect();
    let influence = shown
        .written
        .clone()
        .unwrap_or_else(|| shown.influences.join(", "));
    let mut heading = vec![shown.law.clone(), study.flavour.name().into()];
    heading.extend(given);
    if !influence.is_empty() {
        heading.push(format!("influence {influence}"));
    }
    heading.push(format!("horizon {} dx, dx = {dx:e} m", shown.reach));
    if motion {
        heading.push(format!("density {} kg/m^3", study.density));
    }
    heading.push(format!("along {}", vector(&study.direction, dim)));
    let mut text = format!("{}\n", heading.join(", "));
    for warning in &study.warnings {
        text += &format!("warning: {warning}\n");
    }
    for note in &study.notes {
        text += &format!("note: {note}\n");
    }

    let unit = if motion {
        "speed of long waves [m/s]"
    } else {
        "diffusivity [m^2/s]"
    };
    let mut speeds = Table::new(&["branch", "moves along", unit, "of the continuum", "ratio"]);
    for b in &study.branches {
        let value = |v: f64| waves::frequency(study.moving, v);
        let continuum = b.continuum.map(value);
        speeds.row(vec![
            json!(b.name),
            if motion {
                json!(vector(&b.polarisation, dim))
            } else {
                Value::Null
            },
            digits(value(b.lattice)),
            maybe(continuum),
            maybe(continuum.filter(|c| *c > 0.0).map(|c| value(b.lattice) / c)),
        ]);
    }
    text += &format!("\n{}", speeds.text());
    if !study.moduli.is_empty() {
        let mut moduli = Table::new(&[
            "constant",
            "of the lattice",
            "of the continuum",
            "declared",
            "lattice/declared",
        ]);
        for m in &study.moduli {
            moduli.row(vec![
                json!(m.name),
                digits(m.lattice),
                digits(m.continuum),
                digits(m.declared),
                digits(m.lattice / m.declared),
            ]);
        }
        text += &format!("\n{}", moduli.text());
    }

    let headings: &[&'static str] = match motion {
        true => &[
            "k dx",
            "branch",
            "Omega [rad/s]",
            "group velocity [m/s]",
            "continuum",
            "local",
            "longitudinal",
            "energy",
        ],
        false => &["k dx", "branch", "decay [1/s]", "of the continuum", "local"],
    };
    let speeds = study.branches.iter().map(|b| b.lattice.abs().sqrt());
    let fastest = speeds.fold(0.0, f64::max);
    let mut table = Table::new(headings);
    for row in &study.rows {
        for (b, wave) in row.lattice.iter().enumerate() {
            let other = |list: &Option<Vec<f64>>| {
                maybe(list.as_ref().map(|l| waves::frequency(study.moving, l[b])))
            };
            let along = |g: [f64; 3]| {
                let speed: f64 = (0..3).map(|a| g[a] * study.direction[a]).sum();
                // Without rounding, where it is none.
                if speed.abs() < 1e-9 * fastest {
                    0.0
                } else {
                    speed
                }
            };
            let along = wave.group.map(along);
            let own = waves::frequency(study.moving, wave.squared);
            let mut cells = vec![
                digits(row.k * dx),
                json!(study.branches[b].name),
                digits(own),
            ];
            if motion {
                cells.push(maybe(along));
            }
            cells.extend([other(&row.continuum), other(&row.local)]);
            if motion {
                cells.push(json!(format!("{:.3}", wave.longitudinal)));
                cells.push(json!(mark(wave, study)));
            }
            table.row(cells);
        }
    }
    text += &format!("\n{}\n", table.text());
    text += &summary(study);
    text + "\n"
}

fn mark(wave: &waves::Wave, study: &Study) -> &'static str {
    let none = waves::NOTHING * study.step.fastest;
    match wave.squared {
        v if v < -none * none => "grows",
        _ if wave.omega <= none => "none",
        _ => "",
    }
}

/// What holds for the whole Brillouin zone.
fn summary(study: &Study) -> String {
    let (dim, dx) = (study.flavour.dim(), study.spacing);
    let scaled = |k: &[f64; 3]| vector(&k.map(|c| c * dx / std::f64::consts::PI), dim);
    let modes = |list: &[waves::ZeroMode]| {
        let one = |z: &waves::ZeroMode| match z.count {
            1 => scaled(&z.k),
            n => format!("{} ({n} branches)", scaled(&z.k)),
        };
        list.iter().map(one).collect::<Vec<_>>().join(", ")
    };
    let mut text = String::new();
    let zone = &study.zone;
    if study.zero.is_empty() && zone.zero.is_empty() && zone.zero_points == 0 {
        text += "modes without energy: none\n";
    } else {
        if !study.zero.is_empty() {
            text += &format!(
                "modes without energy in this direction, k dx/pi: {}\n",
                modes(&study.zero)
            );
        }
        text += &format!(
            "modes without energy in the Brillouin zone, k dx/pi up to sign and order: {}; {} of {} points have one\n",
            modes(&zone.zero),
            zone.zero_points,
            zone.points
        );
    }
    let (what, unit) = match study.moving {
        Moving::Displacement => ("frequency", "rad/s"),
        Moving::Field(_) => ("rate of decay", "1/s"),
    };
    text += &format!(
        "largest {what} in the Brillouin zone: {:.6e} {unit} at k dx/pi = {}; 2 over it: {:.6e} s\n",
        study.step.fastest,
        scaled(&zone.largest.k),
        study.step.dt
    );
    text + &match &study.free {
        Some((step, nodes)) => format!(
            "with free surfaces (a block of {nodes} nodes, an upper estimate): {:.4e} {unit}, stable step {:.4e} s\n",
            step.fastest, step.dt
        ),
        None => "with free surfaces: not asked, the block would be too large; `pdlang plan` has the step of a scene\n".into(),
    }
}

pub(super) fn page(shown: &Shown, study: &Study) -> Value {
    let dim = study.flavour.dim();
    let cut = |v: &[f64; 3]| v[..dim].to_vec();
    let modes = |list: &[waves::ZeroMode]| -> Vec<Value> {
        list.iter()
            .map(|z| json!({ "k": cut(&z.k), "branches": z.count }))
            .collect()
    };
    let pairs = |list: &[(String, f64)]| -> Value {
        let finite = list.iter().filter(|(_, v)| v.is_finite());
        finite
            .map(|(n, v)| (n.clone(), json!(v)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let row = |r: &waves::Row| {
        let wave = |w: &waves::Wave| {
            json!({
                "squared": w.squared,
                "frequency": waves::frequency(study.moving, w.squared),
                "group_velocity": w.group.as_ref().map(cut),
                "longitudinal": w.longitudinal,
            })
        };
        let other = |list: &Option<Vec<f64>>| -> Value {
            let value = |v: &f64| waves::frequency(study.moving, *v);
            json!(
                list.as_ref()
                    .map(|l| l.iter().map(value).collect::<Vec<f64>>())
            )
        };
        json!({
            "k": r.k,
            "lattice": r.lattice.iter().map(wave).collect::<Vec<_>>(),
            "continuum": other(&r.continuum),
            "local": other(&r.local),
        })
    };
    json!({
        "law": shown.law,
        "flavour": study.flavour.name(),
        "moves": match study.moving {
            Moving::Displacement => "displacement",
            Moving::Field(_) => "field",
        },
        "parameters": pairs(&shown.params),
        "influence": shown.written.clone().unwrap_or_else(|| shown.influences.join(", ")),
        "horizon": shown.reach,
        "spacing": study.spacing,
        "density": study.density,
        "direction": cut(&study.direction),
        "edge": study.edge,
        "branches": study.branches.iter().map(|b| json!({
            "name": b.name,
            "polarisation": cut(&b.polarisation),
            "long_waves": waves::frequency(study.moving, b.lattice),
            "long_waves_of_continuum": b.continuum.map(|c| waves::frequency(study.moving, c)),
        })).collect::<Vec<_>>(),
        "constants": study.moduli.iter().map(|m| json!({
            "name": m.name,
            "lattice": m.lattice,
            "continuum": m.continuum,
            "declared": m.declared,
        })).collect::<Vec<_>>(),
        "rows": study.rows.iter().map(row).collect::<Vec<_>>(),
        "zero_energy": {
            "direction": modes(&study.zero),
            "zone": modes(&study.zone.zero),
            "points": study.zone.points,
            "zero_points": study.zone.zero_points,
        },
        "largest": {
            "frequency": study.step.fastest,
            "k": cut(&study.zone.largest.k),
            "step": study.step.dt,
        },
        "free_block": study.free.as_ref().map(|(step, nodes)| json!({
            "frequency": step.fastest,
            "step": step.dt,
            "nodes": nodes,
        })),
        "asymmetry": study.asymmetry,
        "warnings": study.warnings,
        "notes": study.notes,
    })
}
