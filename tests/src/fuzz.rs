//! What anybody may do to the language and to scenes: whatever the text, there is an answer, and never a panic.
//! The targets of `tests/fuzz`, and what `tests/hardness.rs` asks of mutations.

use std::path::Path;

use pdlang::assemble::{self, Kinematics};
use pdlang::diag::Diagnostic;
use pdlang::ir::Law;
use pdlang::{emit, fmt, front, probe};
use pdlang_models::language::Pdlang;
use pdlang_models::page;
use pdlang_runtime::body::Flavour;
use pdlang_runtime::engine::{self, Isa, Traversal};
use pdlang_runtime::scene::{Nodes, Scene};

use crate::agreement::{Answer, Question, Scale, spec_for};
use crate::bodies;

/// Of the nodes of a scene: about ten thousand of them.
const MOST_BYTES: u64 = 440_000;
/// Largest difference of two interpreters, in units of what is being measured.
const AGREE: f64 = 1e-6;

/// Numbers and letters that nobody expects.
const ODD: [&str; 12] = [
    "0",
    "-1",
    "1e400",
    "1e-400",
    "-1e308",
    "nan",
    "99999999999999999999",
    "0.1",
    "\u{0}",
    "ω",
    "\r\n",
    "'",
];

/// What became of a text: how far it came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Came {
    /// Laws without errors, and how many of them, with a dimension each, became tapes.
    pub laws: usize,
    pub compiled: usize,
    /// Bodies on which two interpreters answered with numbers.
    pub compared: usize,
}

/// Text -> parse -> check -> lower -> derive -> tapes; the law as defined and the tapes agree; every page, its waves among them.
///
/// # Panics
/// When they do not, or anything else panics.
pub fn language(text: &str) -> Came {
    let checked = front::file(text);
    rendered(text, &checked.diagnostics);
    let _ = fmt::format(text);
    let mut came = Came::default();
    if checked.has_errors() {
        return came;
    }
    for law in &checked.laws {
        came.laws += 1;
        let _ = probe::run(law);
        for dim in 1..=3 {
            let flavours = Flavour::ALL.into_iter().filter(|f| f.dim() == dim);
            let served = |f: &Flavour| law.flavours.iter().any(|g| g.name() == f.name());
            let Some(flavour) = flavours.into_iter().find(served) else {
                continue;
            };
            for kinematics in [Kinematics::General, Kinematics::Linearised] {
                match pdlang::sound::compiled(law, dim, kinematics) {
                    Err(diagnostics) => rendered(text, &diagnostics),
                    Ok((_, unsound)) => {
                        assert!(unsound.is_empty(), "unsound in {dim}D: {unsound:?}\n{text}");
                        came.compiled += 1;
                        if kinematics == Kinematics::General {
                            came.compared += usize::from(agree(text, law, flavour));
                        }
                    }
                }
            }
        }
    }
    for stage in emit::Stage::ALL.into_iter().chain([emit::Stage::Explained]) {
        let _ = emit::emit(text, stage, None);
    }
    let _ = page::page(
        text,
        "fuzz.pd",
        emit::Stage::Markdown,
        None,
        Some("waves.svg"),
    );
    came
}

fn rendered(text: &str, diagnostics: &[Diagnostic]) {
    for finding in diagnostics {
        let in_prelude = finding.labels.iter().any(|(span, _)| span.prelude);
        assert!(!in_prelude, "points into the prelude: {finding:?}\n{text}");
        assert!(!finding.render(text, "fuzz.pd", false).is_empty());
    }
}

/// The law as defined and its tapes, on a small body in a random state. False where an answer is no number.
fn agree(text: &str, law: &Law, flavour: Flavour) -> bool {
    let shape = match flavour.dim() {
        1 => [5, 1, 1],
        2 => [3, 3, 1],
        _ => [3, 2, 2],
    };
    let body = bodies::lattice(flavour, shape, false);
    let question = Question::deformed(law, body, 1e-2, 1);
    // How much the answer owes to the last digits of the state: laws of chance need not be well conditioned.
    let mut beside = question.clone();
    let last = beside.path.last_mut().into_iter().flatten().flatten();
    last.for_each(|u| *u *= 1.0 + 1e-12);
    let ((expected, mut scale), (moved, _)) = (question.oracle(), beside.oracle());
    floor(&mut scale, &question);
    if !numbers(&expected) || !numbers(&moved) {
        return false;
    }
    let owed = moved.difference(&expected, &scale).worst();
    for traversal in [Traversal::Lattice, Traversal::Cloud] {
        let made = question.try_engine(question.interpreted(), traversal, Some(Isa::Scalar));
        // Too large, and said so.
        let Ok(mut engine) = made else { return false };
        let difference = question.ask(&mut engine).difference(&expected, &scale);
        assert!(
            difference.worst() <= AGREE + 1e3 * owed,
            "{} in {flavour:?}, {traversal:?}: {difference}\n{text}",
            law.name
        );
    }
    convolved(text, &question, &scale, owed);
    true
}

/// What cancels to nothing in one order of operations need not in another: rounding of the parameters is no difference.
fn floor(scale: &mut Scale, question: &Question) {
    let finite = question.params.iter().filter(|p| p.is_finite());
    let least = 1e-12 * finite.fold(0.0_f64, |most, p| most.max(p.abs()));
    for scale in [&mut scale.energy, &mut scale.tangent, &mut scale.rates] {
        *scale = scale.max(least);
    }
}

/// Sums by convolution are those over bonds one by one, of the law as it is and at small displacements, where it has any.
fn convolved(text: &str, question: &Question, scale: &Scale, owed: f64) {
    let (mut whole, dim) = (question.clone(), question.body.flavour.dim());
    whole.broken.clear();
    for kinematics in [Kinematics::General, Kinematics::Linearised] {
        if assemble::spec(whole.law, dim, kinematics).is_err() {
            continue;
        }
        let tapes = engine::Law::interpreted(spec_for(whole.law, dim, kinematics));
        let made = [Traversal::Lattice, Traversal::Convolution]
            .map(|t| whole.try_engine(tapes.clone(), t, Some(Isa::Scalar)));
        let [Ok(mut direct), Ok(mut convolved)] = made else {
            continue;
        };
        let expected = whole.ask(&mut direct);
        if numbers(&expected) {
            let difference = whole.ask(&mut convolved).difference(&expected, scale);
            assert!(
                difference.worst() <= AGREE + 1e3 * owed,
                "{whole}, {kinematics:?} by convolution: {difference}\n{text}"
            );
        }
    }
}

fn numbers(answer: &Answer) -> bool {
    let vectors = [&answer.force, &answer.tangent, &answer.velocity];
    let mut vectors = vectors.into_iter().flat_map(|v| v.as_flattened());
    let mut others = answer.energy.iter().chain(answer.rates.iter().flatten());
    let sound = |v: &f64| v.abs() < 1e100;
    vectors.all(sound) && others.all(sound)
}

/// A scene: read, and built where its body is small.
///
/// # Panics
/// When anything does.
pub fn scene(text: &str) -> bool {
    let path = Path::new("fuzz.toml");
    let shown = match Scene::parse(text, path, &Pdlang) {
        Err(problems) => problems.render(false),
        Ok(mut scene) => {
            if let Nodes::Carved(carve) = &mut scene.nodes {
                carve.memory = Some(MOST_BYTES);
            }
            match scene.simulation() {
                Err(problems) => problems.render(false),
                Ok(_) => return true,
            }
        }
    };
    assert!(!shown.is_empty(), "refused without a word:\n{text}");
    false
}

/// xorshift64*, Vigna 2016: enough to make nonsense.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    pub fn below(&mut self, n: usize) -> usize {
        ((self.next() >> 33) as usize) % n.max(1)
    }

    pub fn pick<T: Clone>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())].clone()
    }
}

/// Splits where a token could end; a text is the concatenation of its pieces.
pub fn pieces(text: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut start = 0;
    let mut last = None;
    for (at, letter) in text.char_indices() {
        let class = if letter.is_alphanumeric() || letter == '_' {
            0
        } else {
            1 + letter as u32
        };
        if last.is_some_and(|last| last != class) {
            pieces.push(&text[start..at]);
            start = at;
        }
        last = Some(class);
    }
    pieces.push(&text[start..]);
    pieces
}

/// One of the texts with up to four of its pieces left out, doubled, exchanged or taken from another.
pub fn mutant(random: &mut Random, texts: &[String]) -> String {
    let base = random.pick(texts);
    let mut text = pieces(&base);
    let other = random.pick(texts);
    let others = pieces(&other);
    for _ in 0..1 + random.below(4) {
        let at = random.below(text.len());
        match random.below(5) {
            0 => drop(text.remove(at)),
            1 => text.insert(at, random.pick(&others)),
            2 => text[at] = random.pick(&others),
            3 => text[at] = random.pick(&ODD),
            _ => {
                let other = random.below(text.len());
                text.swap(at, other);
            }
        }
        if text.is_empty() {
            break;
        }
    }
    text.concat()
}
