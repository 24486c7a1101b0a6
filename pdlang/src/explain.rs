//! What a law costs and how it is computed: its sweeps, what each reads and does at a bond, and the formulas behind it.
//!
//! Contract. Read from the tapes that run, so that nothing here can differ from them; formulas are those of [`crate::formula`].

use crate::assemble::{self, Kinematics};
use crate::ast::ResponseKind;
use crate::formula::{formula, quantity};
use crate::ir::Law;
use crate::spec::{Spec, Stage, SweepSpec};
use crate::tape::{Op, Tape, operands};

/// What a sweep does at one directed bond, and how often.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Work {
    pub name: String,
    pub when: &'static str,
    /// Which bonds.
    pub over: String,
    /// Numbers that are read at the other end, displacements left out.
    pub far: usize,
    /// Numbers that are stored at the node.
    pub stored: usize,
    pub breaks: bool,
    /// Whether it has anything to do at bonds.
    pub loops: bool,
    /// Additions, multiplications, comparisons and choices; a fused multiplication and addition is two.
    pub flops: usize,
    pub divisions: usize,
    /// Square roots and their reciprocals.
    pub roots: usize,
    /// Exponentials, sines and the like.
    pub functions: usize,
    /// What a cloud keeps of a bond, besides the number of its neighbour and two bits: whether it is there, and intact.
    pub kept: Vec<String>,
    /// Histories and weights of single bonds that it reads or writes, on a lattice as in a cloud.
    pub remembered: Vec<String>,
}

impl Work {
    /// Its name, when it runs and over which bonds.
    fn head(&self) -> String {
        format!("{}: {}, {}", self.name, self.when, self.over)
    }
}

/// The heads of the sweeps that store or remember the quantity, or the answer, of this name; none, if it is formed where it is read.
pub(crate) fn computed(law: &Law, name: &str, answer: Option<ResponseKind>) -> Vec<String> {
    // The sweeps are those of any dimension; in two they are soon made, and tensors are tensors.
    let dims = law.flavours.iter().map(|f| f.dim());
    let dim = dims.min_by_key(|dim| dim.abs_diff(2)).unwrap_or(2);
    let Ok(spec) = assemble::spec(law, dim, Kinematics::General) else {
        return vec![];
    };
    let slots: Vec<u32> = match answer {
        Some(ResponseKind::Energy) => spec.energy.into_iter().collect(),
        Some(ResponseKind::Rate) => {
            let fields = spec.fields.iter().filter(|field| field.name == name);
            let fields: Vec<u32> = fields.flat_map(|field| &field.slots).copied().collect();
            let rates = spec.rates.iter().filter(|r| fields.contains(&r.field));
            rates.map(|r| r.rate).collect()
        }
        Some(_) => spec.force.clone(),
        None => {
            let named = spec.named.iter().filter(|(known, _)| known == name);
            named.flat_map(|(_, slots)| slots).copied().collect()
        }
    };
    let sweeps = spec.sweeps.iter().filter(|s| {
        let puts = s.bond.ops.iter().any(|op| match op {
            Op::PutHistory(k, _) if answer.is_none() => {
                remembered(s.history[*k as usize], &spec) == name
            }
            _ => false,
        });
        puts || s.out.iter().any(|slot| slots.contains(slot))
    });
    sweeps.map(|s| work(s, &spec).head()).collect()
}

/// The sweeps of a law in the order in which they run.
pub fn works(spec: &Spec) -> Vec<Work> {
    spec.sweeps.iter().map(|s| work(s, spec)).collect()
}

fn work(s: &SweepSpec, spec: &Spec) -> Work {
    let count = |wanted: fn(&Op) -> usize| s.bond.ops.iter().map(wanted).sum();
    Work {
        name: called(&s.name),
        when: when(s.stage),
        over: over(s, spec),
        far: s.nbr.len(),
        stored: s.out.len(),
        breaks: s.kills,
        loops: !s.bond.ops.is_empty(),
        flops: flops(&s.bond),
        divisions: count(|op| usize::from(matches!(op, Op::Div(..)))),
        roots: count(|op| usize::from(matches!(op, Op::Sqrt(_) | Op::Rsqrt(_)))),
        functions: count(|op| {
            usize::from(matches!(
                op,
                Op::Exp(_) | Op::Ln(_) | Op::Sin(_) | Op::Cos(_) | Op::Tan(_) | Op::Pow(..)
            ))
        }),
        kept: kept(s, spec),
        remembered: s.history.iter().map(|k| remembered(*k, spec)).collect(),
    }
}

/// `H_0 H_1 sigma_0` is `H sigma`.
fn called(name: &str) -> String {
    let mut stems: Vec<&str> = Vec::new();
    for word in name.split(' ') {
        let number = |(_, end): &(&str, &str)| end.bytes().all(|b| b.is_ascii_digit());
        let stem = word
            .rsplit_once('_')
            .filter(number)
            .map_or(word, |(stem, _)| stem);
        if !stems.contains(&stem) {
            stems.push(stem);
        }
    }
    stems.join(" ")
}

fn flops(tape: &Tape) -> usize {
    let one = |r: &u32| matches!(tape.ops[*r as usize], Op::Lit(1.0));
    let ops = tape.ops.iter();
    ops.filter(|op| !matches!(op, Op::Mul(a, b) if one(a) || one(b)))
        .map(of_op)
        .sum()
}

fn of_op(op: &Op) -> usize {
    match op {
        Op::Fma(..) | Op::AddTo(..) => 2,
        Op::Powi(_, n) => {
            let n = n.unsigned_abs().max(1);
            (n.ilog2() + n.count_ones() - 1) as usize
        }
        Op::Add(..) | Op::Sub(..) | Op::Mul(..) | Op::Neg(_) | Op::Abs(_) | Op::Min(..) => 1,
        Op::Max(..) | Op::MaxTo(..) | Op::Lt(..) | Op::Le(..) | Op::Select(..) => 1,
        _ => 0,
    }
}

/// Streams that may differ from bond to bond: those made of constants alone are one value for all.
fn kept(s: &SweepSpec, spec: &Spec) -> Vec<String> {
    let mut of_bonds: Vec<bool> = vec![];
    for op in &s.streams.ops {
        let here = of_bond(op) || operands(op).iter().any(|r| of_bonds[*r as usize]);
        of_bonds.push(here);
    }
    let differs = |r: &&u32| of_bonds[**r as usize];
    let outs = s.streams.outs.iter().filter(differs);
    outs.map(|r| formula(&s.streams, *r, spec, Some(s)))
        .collect()
}

fn remembered(k: u32, spec: &Spec) -> String {
    let histories = spec.histories.iter().map(|h| &h.name);
    let mut names = histories.chain(spec.weights.iter().map(|w| &w.name));
    names.nth(k as usize).cloned().unwrap_or_default()
}

fn of_bond(op: &Op) -> bool {
    matches!(op, Op::Xi(_) | Op::X | Op::Ix | Op::Omega(_) | Op::Weight)
}

/// How often the sweeps of a stage run.
fn when(stage: Stage) -> &'static str {
    match stage {
        Stage::Reference => "once, at rest",
        Stage::Part => "once, when initial values are set",
        Stage::Family => "once, and again where bonds broke",
        Stage::Step => "at every force evaluation",
        Stage::Energy => "when the energy is asked for",
        Stage::Tangent => "when the tangent is asked for",
        Stage::Update => "once per accepted step",
    }
}

fn over(s: &SweepSpec, spec: &Spec) -> String {
    let bonds = match s.reference {
        true => "all bonds",
        false => "intact bonds",
    };
    format!("{bonds} of `{}`", spec.families[s.family as usize].name)
}

/// What a sweep is for, and what the numbers in its functions are.
pub fn notes(s: &SweepSpec, spec: &Spec) -> Vec<String> {
    let list = |slots: &[u32]| {
        let names: Vec<String> = slots.iter().map(|k| quantity(spec, *k)).collect();
        names.join(", ")
    };
    let mut lines = vec![format!(
        "`{}`, {}: {}.",
        s.name,
        when(s.stage),
        over(s, spec)
    )];
    let mut line = |title: &str, text: String| {
        if !text.is_empty() {
            lines.push(format!("- {title}: {text}"));
        }
    };
    line("own", list(&s.own));
    line("nbr", list(&s.nbr));
    line("out", list(&s.out));
    let mut constants = [&s.geometry, &s.streams, &s.pre, &s.bond, &s.post]
        .into_iter()
        .flat_map(|tape| &tape.ops)
        .filter_map(|op| match op {
            Op::Const(k) => Some(*k),
            _ => None,
        })
        .collect::<Vec<_>>();
    constants.sort_unstable();
    constants.dedup();
    for k in constants {
        if let Some(r) = spec.constants.outs.get(k as usize) {
            line(&format!("c{k}"), formula(&spec.constants, *r, spec, None));
        }
    }
    for (k, r) in s.geometry.outs.iter().enumerate() {
        line(&format!("g{k}"), formula(&s.geometry, *r, spec, Some(s)));
    }
    for (k, r) in s.streams.outs.iter().enumerate() {
        line(
            &format!("stream{k}"),
            formula(&s.streams, *r, spec, Some(s)),
        );
    }
    lines
}

/// The sums of a sweep over the bonds, what breaks them, and what it makes of the sums at the node.
fn sums(s: &SweepSpec, spec: &Spec) -> Vec<String> {
    let shown = |tape: &Tape, r: u32| formula(tape, r, spec, Some(s));
    let mut lines = Vec::new();
    for op in &s.bond.ops {
        match *op {
            Op::Kill(r) => lines.push(format!("breaks where {}", shown(&s.bond, r))),
            Op::AddTo(k, a, b) => {
                let product = Tape {
                    ops: [&s.bond.ops[..], &[Op::Mul(a, b)]].concat(),
                    outs: vec![],
                };
                let r = s.bond.ops.len() as u32;
                lines.push(format!("sum{k} += {}", shown(&product, r)));
            }
            Op::MaxTo(k, a) => lines.push(format!("sum{k} = max(sum{k}, {})", shown(&s.bond, a))),
            Op::PutHistory(k, r) => lines.push(format!("history{k} := {}", shown(&s.bond, r))),
            _ => {}
        }
    }
    for (slot, r) in s.out.iter().zip(&s.post.outs) {
        lines.push(format!(
            "{} = {}",
            quantity(spec, *slot),
            shown(&s.post, *r)
        ));
    }
    lines
}

/// For a terminal: every sweep with its formulas and its costs.
pub fn text(spec: &Spec) -> String {
    let linear = if spec.linearised { ", linearised" } else { "" };
    let mut text = format!("{} in {}D{linear}: {}\n", spec.law, spec.dim, spec.title);
    for (s, w) in spec.sweeps.iter().zip(works(spec)) {
        text += &format!("\n{}\n", w.head());
        let constant = |line: &&String| line.starts_with("- c") || line.starts_with("- g");
        for line in notes(s, spec).iter().filter(constant) {
            text += &format!("    {}\n", line[2..].replacen(": ", " = ", 1));
        }
        for line in sums(s, spec) {
            text += &format!("    {line}\n");
        }
        text += &format!("  {}\n", cost(&w));
    }
    text += "\nwhat a scene takes away:\n";
    for (what, taken) in removes(spec) {
        text += &format!("  {what}: {taken}\n");
    }
    text
}

/// What a scene may say or be, and what that takes away from this.
pub fn removes(spec: &Spec) -> Vec<(&'static str, &'static str)> {
    let works = works(spec);
    let any = |wanted: fn(&Work) -> bool| works.iter().any(wanted);
    let says = [
        (true, "a lattice", "what is kept of a bond, but its bit"),
        (
            any(|w| w.breaks),
            "infinite limits",
            "the test of every bond; and masks, as in families that are intact",
        ),
        (
            any(|w| w.when.contains("energy")),
            "no history, or steps that write none",
            "the sweeps of the energy",
        ),
        (
            any(|w| w.when.contains("again")),
            "no bond that breaks",
            "the sweeps of families after the first",
        ),
        (
            !spec.linearised && !spec.force.is_empty(),
            "`linearised = true`",
            "roots and products of the deformed bond, where the law can",
        ),
        (
            true,
            "a body at rest",
            "the work in chunks of nodes that sleep until something reaches them",
        ),
    ];
    let true_ones = says.into_iter().filter(|(is, ..)| *is);
    true_ones.map(|(_, what, taken)| (what, taken)).collect()
}

/// One sentence about a bond.
fn cost(w: &Work) -> String {
    let mut parts = vec![format!("{} flops", w.flops)];
    let mut add = |n: usize, what: &str| {
        if n > 0 {
            parts.push(format!("{n} {what}{}", if n == 1 { "" } else { "s" }));
        }
    };
    add(w.divisions, "division");
    add(w.roots, "root");
    add(w.functions, "function");
    add(w.far, "number of the other end");
    if !w.loops {
        return "at its nodes alone".into();
    }
    let remembered = match w.remembered.is_empty() {
        true => String::new(),
        false => format!("; it remembers {}", w.remembered.join(" and ")),
    };
    let does = parts.join(", ");
    format!(
        "a bond takes {does}; a cloud keeps {}{remembered}",
        keeps(w)
    )
}

/// What a cloud keeps of a bond for a sweep, with its size.
fn keeps(w: &Work) -> String {
    let bytes = 4.25 + 8.0 * w.kept.len() as f64;
    match w.kept.is_empty() {
        true => format!("{bytes} bytes of it"),
        false => format!("{bytes} bytes of it, with {}", w.kept.join(" and ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(items: &str, kinematics: Kinematics) -> Spec {
        let text =
            format!("model m \"t\" cite \"a, eq. 1\" {{ param K : pressure \"k\" {items} }}");
        let law = crate::front::file(&text);
        assert!(!law.has_errors(), "{:?}", law.diagnostics);
        assemble::spec(&law.laws[0], 1, kinematics).unwrap()
    }

    #[test]
    fn a_linear_bond_is_counted_by_hand() {
        // W = K sum(s^2)/ball(1): the force of a bond is c (y - x)/x^2 twice over along it, linearised c eta/x^2.
        let spec = spec("energy W = K*sum(s^2)/ball(1)", Kinematics::Linearised);
        let force = works(&spec)
            .into_iter()
            .find(|w| w.when.contains("force"))
            .unwrap();
        assert_eq!(
            (force.divisions, force.roots, force.functions, force.far),
            (0, 0, 0, 0)
        );
        // One product of a constant with the extension, added up.
        assert_eq!(force.flops, 2, "{}", text(&spec));
        assert_eq!(force.stored, 1);
    }

    #[test]
    fn every_sum_and_result_is_said() {
        let spec = spec(
            "influence omega = 1/x node m = sum(omega*x^2) node q = sum(omega*x*e)/m energy W = K*q^2 break when s > 1",
            Kinematics::General,
        );
        let text = text(&spec);
        for part in [
            "m = sum0",
            "q = ",
            "force_x = ",
            "breaks where",
            "1 number of the other end",
            "energy = ",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
    }
}
