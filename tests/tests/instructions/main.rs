//! The inner loops of the catalogue as machine code: a row per sweep in `fixtures/instructions.txt`.
//!
//! An optimisation that is lost (of the compiler, of the traversals, of the lane types) brings a root, a division, a
//! call or more arithmetic into the loop over bonds, and this fails. After a deliberate change, `UPDATE_EXPECT=1 cargo
//! test --release -p pdlang-tests --test instructions` writes the table anew: read the difference.
#![cfg(target_arch = "x86_64")]

mod machine;

use machine::{Counts, Kind, bond_loop, bond_loops};
use pdlang_models::registry::{CATALOGUE, Entry};
use pdlang_runtime::engine::Law;
use pdlang_runtime::kernel::{Bond, Entries, Instances, Lane, Node, Run, Streams, Sweep};
use pdlang_runtime::spec::{Op, Stage, SweepSpec};
use pdlang_runtime::sweep_entries;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What stands above the rows.
const HEAD: &str = "\
# The loops over bonds of all sweeps that run at every step, in two and three dimensions: instructions per row of
# bonds, of which there are four (AVX2) or eight (AVX-512). Two numbers are those of the instance for whole families
# and of the one for any, where they differ; the second also tests what may break.
#
# Roots, estimates of reciprocal roots, divisions, gather instructions and calls are as listed, exactly. Fused
# multiply-adds, other arithmetic, operands in memory and on the stack (spills) depend on the compiler's release and
# options: the table has those of an ordinary release build, and a few more are accepted.
";

/// Compared exactly; for the others a few more are accepted.
fn exact(kind: Kind) -> bool {
    use Kind::*;
    matches!(kind, Roots | Estimates | Divisions | Gathers | Calls)
}

fn accepted(kind: Kind, expected: usize) -> usize {
    match kind {
        _ if exact(kind) => expected,
        Kind::Fused | Kind::Other => expected + expected / 10,
        _ => expected + expected / 4 + 4,
    }
}

/// An instruction set as the loops see it.
#[derive(Clone, Copy, PartialEq)]
enum Isa {
    Avx2,
    Avx512,
}

impl Isa {
    fn name(self) -> &'static str {
        match self {
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }

    fn instances(self, entries: &Entries) -> Instances {
        match self {
            Isa::Avx2 => entries.avx2,
            Isa::Avx512 => entries.avx512,
        }
    }

    fn lanes(self) -> usize {
        match self {
            Isa::Avx2 => 4,
            Isa::Avx512 => 8,
        }
    }
}

/// The instances of a sweep in one traversal.
struct Loops<'a> {
    law: &'a str,
    /// The family, where it is not that of the horizon.
    family: Option<&'a str>,
    dim: usize,
    sweep: &'a SweepSpec,
    over: Over,
    isa: Isa,
    instances: [Run; 2],
}

/// What the loop goes over: the rows of a lattice, or of a cloud, lists or runs.
#[derive(Clone, Copy, PartialEq)]
enum Over {
    Lattice,
    Lists,
    Runs,
}

impl Loops<'_> {
    /// Law, dimension, sweep, traversal, instruction set. Components go by the name of their tensor.
    fn key(&self) -> String {
        let tensor = |name: &str| {
            name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_')
                .to_string()
        };
        let names: BTreeSet<String> = self.sweep.name.split(' ').map(tensor).collect();
        let names: Vec<String> = names.into_iter().collect();
        let traversal = match self.over {
            Over::Lattice => "lattice",
            Over::Lists => "cloud",
            Over::Runs => "runs",
        };
        let (law, dim, isa) = (self.law, self.dim, self.isa.name());
        let family = self.family.map(|name| format!("[{name}]"));
        let (names, family) = (names.join(","), family.unwrap_or_default());
        format!("{law} {dim}d {names}{family} {traversal} {isa}")
    }

    /// How many instructions of a kind the tape asks for on a row of bonds, each operation for itself.
    fn asked(&self, kind: Kind) -> usize {
        let cloud = self.over != Over::Lattice;
        let formed = match cloud {
            true => &self.sweep.from_streams.ops[..],
            false => &[],
        };
        let ops = || self.sweep.bond.ops.iter().chain(formed);
        let count = |is: fn(&Op) -> bool| ops().filter(|op| is(op)).count();
        // In a cloud 1/|xi| is made of positions, once.
        let lengths = usize::from(cloud && ops().any(|op| matches!(op, Op::Ix)));
        let reciprocal = count(|op| matches!(op, Op::Rsqrt(_))) + lengths;
        // AVX2 has no estimate in double precision.
        let (estimates, exact) = match self.isa {
            Isa::Avx2 => (0, reciprocal),
            Isa::Avx512 => (reciprocal, 0),
        };
        match kind {
            Kind::Roots => count(|op| matches!(op, Op::Sqrt(_))) + exact,
            Kind::Estimates => estimates,
            Kind::Divisions => {
                count(|op| matches!(op, Op::Div(..)) || matches!(op, Op::Powi(_, n) if *n < 0))
                    + exact
            }
            Kind::Calls => {
                let calls = |op: &Op| {
                    matches!(
                        op,
                        Op::Exp(_) | Op::Ln(_) | Op::Sin(_) | Op::Cos(_) | Op::Tan(_) | Op::Pow(..)
                    )
                };
                count(calls) * self.isa.lanes()
            }
            // An estimate is refined by four.
            Kind::Fused => {
                // The square of |xi| in values that are formed is the one under 1/|xi|.
                let squared = formed.iter().any(|op| matches!(op, Op::Fma(..)));
                count(|op| matches!(op, Op::Fma(..) | Op::AddTo(..)))
                    + 4 * estimates
                    + if squared { 0 } else { (self.dim - 1) * lengths }
            }
            _ => 0,
        }
    }

    /// Per row of bonds. Fused operations come from a tape alone: where a loop has more, it takes several rows at a time.
    fn counts(&self) -> [Counts; 2] {
        let of_one = |found: Counts| {
            let rows = found
                .get(Kind::Fused)
                .div_ceil(self.asked(Kind::Fused).max(1));
            found.of_one(rows.max(1))
        };
        self.instances.map(|run| {
            let found = bond_loops(run).into_iter().map(of_one);
            let memory = |c: &Counts| c.get(Kind::Memory);
            let found = match self.over {
                Over::Lattice => found.take(1).next(),
                Over::Lists => found.take(2).max_by_key(memory),
                Over::Runs => found.take(2).min_by_key(memory),
            };
            found.unwrap_or_else(|| panic!("{}: no loop", self.key()))
        })
    }
}

/// Every sweep of the catalogue that has bonds and runs at every step, in two and three dimensions.
fn visit(mut each: impl FnMut(Loops)) {
    let of = |entry: &'static Entry| {
        let linearised = entry
            .linearised
            .map(|law| (format!("{}_linearised", entry.name), law));
        std::iter::once((entry.name.to_string(), entry.kernels)).chain(linearised)
    };
    for (name, compiled) in CATALOGUE.iter().flat_map(of) {
        for kernel in compiled.kernels.iter().filter(|k| k.dim > 1) {
            let spec = Law::compiled(compiled, kernel.dim)
                .expect("a law of the catalogue")
                .spec;
            for (position, entries) in kernel.sweeps {
                let sweep = &spec.sweeps[*position];
                if sweep.stage != Stage::Step || sweep.bond.ops.is_empty() {
                    continue;
                }
                for over in [Over::Lattice, Over::Lists, Over::Runs] {
                    for isa in [Isa::Avx2, Isa::Avx512] {
                        let instances = isa.instances(entries);
                        let instances = match over {
                            Over::Lattice => instances.lattice,
                            _ => instances.cloud,
                        };
                        let (law, dim) = (name.as_str(), kernel.dim);
                        let number = sweep.family as usize;
                        let family = (number > 0).then(|| spec.families[number].name.as_str());
                        each(Loops {
                            law,
                            family,
                            dim,
                            sweep,
                            over,
                            isa,
                            instances,
                        });
                    }
                }
            }
        }
    }
}

/// Rows by their keys: for every kind the counts of both instances.
type Table = BTreeMap<String, Vec<[usize; 2]>>;

fn row(loops: &Loops) -> Vec<[usize; 2]> {
    let counts = loops.counts();
    Kind::ALL.map(|kind| counts.map(|c| c.get(kind))).to_vec()
}

/// Columns of one width.
fn write(rows: &[(String, Vec<[usize; 2]>)]) -> String {
    let cell = |[whole, any]: &[usize; 2]| match whole == any {
        true => whole.to_string(),
        false => format!("{whole}/{any}"),
    };
    let titles = ["law", "dim", "sweep", "traversal", "isa"].map(String::from);
    let mut lines = vec![
        titles
            .into_iter()
            .chain(Kind::ALL.map(Kind::name))
            .collect::<Vec<_>>(),
    ];
    for (key, cells) in rows {
        let words = key.split(' ').map(String::from);
        lines.push(words.chain(cells.iter().map(cell)).collect());
    }
    let width = |k: usize| lines.iter().map(|line| line[k].len()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    let mut text = String::from(HEAD);
    for line in lines {
        let padded: Vec<String> = line
            .iter()
            .zip(&widths)
            .map(|(word, w)| format!("{word:w$}"))
            .collect();
        text += padded.join("  ").trim_end();
        text.push('\n');
    }
    text
}

fn read(text: &str) -> Table {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let row = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let cell = |word: &&str| {
            let (whole, any) = word.split_once('/').unwrap_or((word, word));
            [whole, any].map(|n| n.parse().expect("a count"))
        };
        (words[..5].join(" "), words[5..].iter().map(cell).collect())
    };
    lines.map(row).collect()
}

/// What differs by more than is accepted, a line each.
fn differences(expected: &Table, found: &Table) -> Vec<String> {
    let mut lines = vec![];
    for (key, cells) in found {
        let Some(listed) = expected.get(key) else {
            lines.push(format!("{key}: not in the table"));
            continue;
        };
        for (kind, (listed, cells)) in Kind::ALL.into_iter().zip(listed.iter().zip(cells)) {
            for (instance, (n, found)) in ["whole", "any"].iter().zip(listed.iter().zip(cells)) {
                if *found > accepted(kind, *n) || exact(kind) && found != n {
                    lines.push(format!("{key} {instance}: {} {n} -> {found}", kind.name()));
                }
            }
        }
    }
    let gone = expected.keys().filter(|key| !found.contains_key(*key));
    lines.extend(gone.map(|key| format!("{key}: in the table only")));
    lines
}

#[test]
#[cfg_attr(debug_assertions, ignore = "checks of debug builds stand in the loops")]
fn inner_loops_are_as_listed() {
    let mut rows = vec![];
    visit(|loops| rows.push((loops.key(), row(&loops))));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/instructions.txt");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, write(&rows)).unwrap();
    }
    let expected = read(&std::fs::read_to_string(&path).unwrap_or_default());
    let count = rows.len();
    let found = Table::from_iter(rows);
    assert_eq!(found.len(), count, "two sweeps of one name");
    let wrong = differences(&expected, &found);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What no loop may hold more of than its tape says, whatever the table has.
#[test]
#[cfg_attr(debug_assertions, ignore = "checks of debug builds stand in the loops")]
fn loops_hold_no_more_than_their_tapes() {
    let mut wrong = vec![];
    visit(|loops| {
        for kind in Kind::ALL.into_iter().filter(|kind| exact(*kind)) {
            let (found, asked) = (loops.counts().map(|c| c.get(kind)), loops.asked(kind));
            if found.into_iter().any(|n| n > asked) {
                let (key, kind) = (loops.key(), kind.name());
                wrong.push(format!("{key}: {found:?} {kind}, the tape has {asked}"));
            }
        }
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A force made badly: a true root, a division per component and a function that calls the library.
struct Careless;

impl Sweep<3> for Careless {
    type Pre<L: Lane> = ();
    type Acc<L: Lane> = [L; 3];
    const STREAMS: usize = 1;
    #[inline(always)]
    fn zero<L: Lane>(&self) -> [L; 3] {
        [L::splat(0.0); 3]
    }
    #[inline(always)]
    fn pre<L: Lane, N: Node<L>>(&self, _node: &N) {}
    #[inline(always)]
    fn bond<L: Lane, B: Bond<L, 3>>(&self, _pre: &(), bond: &mut B, acc: &mut [L; 3]) {
        let y0 = bond.xi(0).add(bond.eta(0));
        let y1 = bond.xi(1).add(bond.eta(1));
        let y2 = bond.xi(2).add(bond.eta(2));
        let length = y0.mul(y0).add(y1.mul(y1)).add(y2.mul(y2)).sqrt();
        let force = length.sub(bond.geo(0)).exp();
        bond.add(&mut acc[0], force, y0.div(length));
        bond.add(&mut acc[1], force, y1.div(length));
        bond.add(&mut acc[2], force, y2.div(length));
    }
    #[inline(always)]
    fn post<L: Lane, N: Node<L>>(&self, _pre: &(), acc: &[L; 3], node: &mut N) {
        node.out(0, acc[0]);
        node.out(1, acc[1]);
        node.out(2, acc[2]);
    }
    #[inline(always)]
    fn geo<L: Lane, B: Bond<L, 3> + Streams<L>>(&self, bond: &B, k: usize) -> L {
        bond.stream(k)
    }
}

const CARELESS: Entries = sweep_entries!(Careless, 3);

#[test]
#[cfg_attr(debug_assertions, ignore = "checks of debug builds stand in the loops")]
fn a_careless_loop_is_found_out() {
    for isa in [Isa::Avx2, Isa::Avx512] {
        let instances = isa.instances(&CARELESS);
        for run in [instances.lattice, instances.cloud].concat() {
            let found = bond_loop(run).expect("it sums over bonds");
            let kinds = [Kind::Roots, Kind::Divisions, Kind::Calls, Kind::Fused];
            let seen = kinds.map(|kind| found.get(kind));
            assert_eq!(seen, [1, 3, isa.lanes(), 3]);
        }
    }
}

#[test]
fn a_table_that_differs_is_reported() {
    let cells = |n: usize, fused| {
        let mut cells = vec![[0, 0]; Kind::ALL.len()];
        cells[Kind::Divisions as usize] = [0, n];
        cells[Kind::Fused as usize] = [fused, fused];
        cells
    };
    let row = |n, fused| vec![("law 3d force cloud avx512".into(), cells(n, fused))];
    let listed = read(&write(&row(1, 20)));
    let against = |n, fused| differences(&listed, &row(n, fused).into_iter().collect());
    assert_eq!(against(1, 20), [""; 0]);
    // Two more fused operations are accepted, and any number less; not so for divisions.
    assert_eq!(against(1, 22), [""; 0]);
    assert_eq!(against(1, 10), [""; 0]);
    let start = "law 3d force cloud avx512 any:";
    assert_eq!(against(2, 20), [format!("{start} divisions 1 -> 2")]);
    assert_eq!(against(0, 20), [format!("{start} divisions 1 -> 0")]);
    assert_eq!(against(1, 23).len(), 2);
    let missing = differences(&listed, &Table::new());
    assert_eq!(missing, ["law 3d force cloud avx512: in the table only"]);
    assert_eq!(differences(&Table::new(), &listed).len(), 1);
}
