//! Machine code of compiled sweeps, read from their function pointers: the loop over bonds, and what is in it.
//!
//! Instructions are decoded along every path from the entry. The loop over bonds is the innermost one in which vectors
//! are added or multiplied: in the loop over chunks, prologue and epilogue stand outside of it, and what it has within
//! (lanes taken one by one) is scalar. Copies of it for the two halves of a chunk count once, the larger one.
use iced_x86::{Decoder, DecoderOptions, FlowControl, Instruction, Mnemonic, OpKind, Register};
use pdlang_runtime::kernel::Run;
use std::collections::{BTreeMap, BTreeSet};

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Roots,
    /// Of reciprocal roots.
    Estimates,
    Divisions,
    /// The gather instructions of the processor.
    Gathers,
    Calls,
    Fused,
    /// Sums, differences, products, larger and smaller.
    Other,
    /// Vector instructions with an operand in memory outside of the stack, and on the stack.
    Memory,
    Spills,
}

impl Kind {
    pub const ALL: [Kind; 9] = [
        Kind::Roots,
        Kind::Estimates,
        Kind::Divisions,
        Kind::Gathers,
        Kind::Calls,
        Kind::Fused,
        Kind::Other,
        Kind::Memory,
        Kind::Spills,
    ];

    pub fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

/// What a loop holds: instructions of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Counts([usize; Kind::ALL.len()]);

/// The loop over bonds of an instance; `None` where it computes nothing.
pub fn bond_loop(run: Run) -> Option<Counts> {
    bond_loops(run).into_iter().next()
}

/// All innermost loops that compute, those that compute most first: a cloud has one for lists and one for runs.
pub fn bond_loops(run: Run) -> Vec<Counts> {
    let code = reachable(run as usize as u64);
    let loops = loops(run as usize as u64, &code);
    let counted = |body: &BTreeSet<u64>| Counts::of(body.iter().map(|at| &code[at]));
    let computes = |body: &BTreeSet<u64>| counted(body).arithmetic() > 0;
    let busy: Vec<&BTreeSet<u64>> = loops.values().filter(|body| computes(body)).collect();
    let innermost = |body: &&BTreeSet<u64>| {
        let within = |other: &BTreeSet<u64>| other.len() < body.len() && other.is_subset(body);
        !busy.iter().any(|other| within(other))
    };
    let mut found: Vec<Counts> = busy
        .iter()
        .copied()
        .filter(innermost)
        .map(counted)
        .collect();
    found.sort_unstable_by_key(|c| std::cmp::Reverse((c.arithmetic(), c.0)));
    match loops.len() {
        0 | 1 => vec![],
        _ => found,
    }
}

/// No instance of a sweep is longer: whatever is was not read right.
const LONGEST: usize = 100_000;

/// The instructions that can be reached, by address. Calls are taken to return.
fn reachable(entry: u64) -> BTreeMap<u64, Instruction> {
    let mut code = BTreeMap::new();
    let mut open = vec![entry];
    while let Some(at) = open.pop() {
        if code.contains_key(&at) {
            continue;
        }
        // SAFETY: what can be reached is mapped. No instruction is longer than 15 bytes, and a program goes on for
        // longer behind its last sweep.
        let bytes = unsafe { std::slice::from_raw_parts(at as *const u8, 15) };
        let instruction = Decoder::with_ip(64, bytes, at, DecoderOptions::NONE).decode();
        assert!(!instruction.is_invalid(), "no instruction at {at:#x}");
        assert!(code.len() < LONGEST, "{entry:#x} does not end");
        open.extend(successors(&instruction));
        code.insert(at, instruction);
    }
    code
}

fn successors(instruction: &Instruction) -> Vec<u64> {
    let next = instruction.next_ip();
    match instruction.flow_control() {
        FlowControl::Next | FlowControl::Call | FlowControl::IndirectCall => vec![next],
        FlowControl::ConditionalBranch => vec![instruction.near_branch_target(), next],
        FlowControl::UnconditionalBranch => vec![instruction.near_branch_target()],
        FlowControl::Return | FlowControl::Exception => vec![],
        other => panic!("{other:?} at {:#x}", instruction.ip()),
    }
}

/// Natural loops by their heads: what reaches an edge back to the head without passing it.
fn loops(entry: u64, code: &BTreeMap<u64, Instruction>) -> BTreeMap<u64, BTreeSet<u64>> {
    let mut before: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
    for (&at, instruction) in code {
        for next in successors(instruction) {
            before.entry(next).or_default().push(at);
        }
    }
    let mut loops: BTreeMap<u64, BTreeSet<u64>> = BTreeMap::new();
    for (from, head) in back_edges(entry, code) {
        let body = loops.entry(head).or_default();
        body.insert(head);
        let mut open = vec![from];
        while let Some(at) = open.pop() {
            if body.insert(at) {
                open.extend(before.get(&at).into_iter().flatten());
            }
        }
    }
    // A loop with a second way in would take in the entry.
    let whole = |head: &u64, body: &BTreeSet<u64>| *head == entry || !body.contains(&entry);
    assert!(loops.iter().all(|(head, body)| whole(head, body)));
    loops
}

/// Edges to an instruction that a depth-first walk is still below.
fn back_edges(entry: u64, code: &BTreeMap<u64, Instruction>) -> Vec<(u64, u64)> {
    let mut edges = vec![];
    let mut seen = BTreeSet::from([entry]);
    let mut below = BTreeSet::from([entry]);
    let mut path = vec![(entry, successors(&code[&entry]))];
    while let Some((at, rest)) = path.last_mut() {
        let at = *at;
        match rest.pop() {
            Some(next) if below.contains(&next) => edges.push((at, next)),
            Some(next) if seen.insert(next) => {
                below.insert(next);
                path.push((next, successors(&code[&next])));
            }
            Some(_) => {}
            None => {
                below.remove(&at);
                path.pop();
            }
        }
    }
    edges
}

impl Counts {
    fn of<'a>(code: impl Iterator<Item = &'a Instruction>) -> Counts {
        let mut counts = Counts::default();
        for instruction in code {
            let kinds = [calculation(instruction), transfer(instruction)];
            kinds
                .into_iter()
                .flatten()
                .for_each(|kind| counts.0[kind as usize] += 1);
        }
        counts
    }

    pub fn get(&self, kind: Kind) -> usize {
        self.0[kind as usize]
    }

    fn arithmetic(&self) -> usize {
        self.get(Kind::Fused) + self.get(Kind::Other)
    }

    /// Of a loop that takes several rows of bonds at a time, the share of one.
    pub fn of_one(self, rows: usize) -> Counts {
        Counts(self.0.map(|n| n.div_ceil(rows)))
    }
}

fn calculation(instruction: &Instruction) -> Option<Kind> {
    use Mnemonic::*;
    let name = format!("{:?}", instruction.mnemonic());
    Some(match instruction.mnemonic() {
        Vsqrtpd | Vsqrtsd | Sqrtpd | Sqrtsd => Kind::Roots,
        Vrsqrt14pd | Vrsqrt14sd => Kind::Estimates,
        Vdivpd | Vdivsd | Divpd | Divsd | Div | Idiv => Kind::Divisions,
        Vaddpd | Vsubpd | Vmulpd | Vmaxpd | Vminpd => Kind::Other,
        Call => Kind::Calls,
        _ if name.contains("gather") => Kind::Gathers,
        _ if name.starts_with("Vfm") || name.starts_with("Vfnm") => Kind::Fused,
        _ => return None,
    })
}

fn transfer(instruction: &Instruction) -> Option<Kind> {
    let operands = 0..instruction.op_count();
    let memory = operands
        .clone()
        .any(|k| instruction.op_kind(k) == OpKind::Memory);
    let vector = operands
        .clone()
        .any(|k| instruction.op_register(k).is_vector_register());
    match instruction.memory_base() {
        _ if !memory || !vector => None,
        Register::RSP => Some(Kind::Spills),
        _ => Some(Kind::Memory),
    }
}
