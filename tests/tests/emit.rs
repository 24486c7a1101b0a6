//! What `pdlang emit` prints: every stage of a law in `fixtures/emit`, and the pages in `docs/laws`.
//!
//! After a deliberate change, `UPDATE_EXPECT=1 cargo test -p pdlang-tests --test emit` writes them anew: read
//! the difference.
//!
//! Texts are compared letter by letter. In pictures places may differ by a pixel: they come from sines, whose last digits are others
//! on another machine, and are rounded.

use pdlang::assemble::{Kinematics, specs};
use pdlang::emit::{Stage, emit};
use pdlang::explain::{Work, works};
use pdlang::spec::SweepSpec;
use pdlang_models::page::page;
use pdlang_models::registry::{self, CATALOGUE};
use pdlang_models::waves::plot::FINE;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What is new in the file of that path, in words.
fn compare(path: PathBuf, found: &str, wrong: &mut Vec<String>) {
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, found).unwrap();
        return;
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    let differs = match path.extension().is_some_and(|ending| ending == "svg") {
        true => picture_differs(&kept, found),
        false => (kept != found).then(String::new),
    };
    if let Some(what) = differs {
        wrong.push(format!("{} {what}", path.display()));
    }
}

/// Attributes of a picture that are places in it.
const PLACES: [&str; 9] = ["points", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy"];

/// Where two pictures differ: in a place by more than a pixel of the screen, or in anything else.
fn picture_differs(kept: &str, found: &str) -> Option<String> {
    let pieces = |text: &str| text.split('"').map(String::from).collect::<Vec<_>>();
    let (kept, found) = (pieces(kept), pieces(found));
    if kept.len() != found.len() {
        return Some(format!(
            "has {} attributes for {}",
            found.len() / 2,
            kept.len() / 2
        ));
    }
    // Attributes stand in quotes, behind their names.
    let name = |k: usize| match k % 2 {
        0 => "text",
        _ => kept[k - 1].rsplit(' ').next().unwrap_or_default(),
    };
    let same = |k: &usize| {
        let place = PLACES.contains(&name(*k).trim_end_matches('='));
        kept[*k] == found[*k] || place && near(&kept[*k], &found[*k])
    };
    let other = (0..kept.len()).find(|k| !same(k))?;
    let (name, a, b) = (name(other), kept[other].trim(), found[other].trim());
    Some(format!("has {name} {b} for {a}"))
}

/// Whether places are as many, and each within a pixel.
fn near(a: &str, b: &str) -> bool {
    let numbers = |text: &str| -> Option<Vec<f64>> {
        let all = text.split([' ', ',']).filter(|n| !n.is_empty());
        all.map(|n| n.parse().ok()).collect()
    };
    let (Some(a), Some(b)) = (numbers(a), numbers(b)) else {
        return false;
    };
    a.len() == b.len()
        && a.iter()
            .zip(&b)
            .all(|(a, b)| (a - b).abs() <= f64::from(FINE))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

#[test]
fn stages_of_the_journey() {
    let mut wrong = Vec::new();
    for (name, stages) in [
        ("pmb", Stage::ALL.as_slice()),
        ("lps", &[Stage::Ast, Stage::Ir, Stage::Passes]),
    ] {
        let entry = CATALOGUE.iter().find(|e| e.name == name).unwrap();
        for stage in stages {
            let found = emit(entry.text, *stage, Some(&entry.link())).unwrap();
            let file = format!("fixtures/emit/{name}.{}.txt", stage.name());
            compare(root().join(file), &found, &mut wrong);
        }
    }
    assert!(wrong.is_empty(), "changed: {}", wrong.join(", "));
}

/// Editors say of a definition when it is computed, for one dimension: it is the same time in all.
#[test]
fn definitions_are_computed_at_the_same_time_in_all_dimensions() {
    for entry in CATALOGUE {
        let specs = specs(&entry.law().unwrap(), Kinematics::General).unwrap();
        let times: Vec<BTreeSet<(&str, &str)>> = specs
            .iter()
            .map(|spec| {
                let works = works(spec).into_iter().zip(&spec.sweeps);
                let named = |(work, sweep): (Work, &SweepSpec)| {
                    let here = |slots: &[u32]| sweep.out.iter().any(|slot| slots.contains(slot));
                    let named = spec.named.iter().filter(move |(_, slots)| here(slots));
                    let times = named.map(|(name, _)| (name.as_str(), work.when));
                    times.collect::<Vec<_>>()
                };
                works.flat_map(named).collect()
            })
            .collect();
        for other in &times[1..] {
            assert_eq!(&times[0], other, "{}", entry.name);
        }
    }
}

#[test]
fn pages_of_the_catalogue_are_current() {
    let mut wrong = Vec::new();
    let docs = root().join("../docs/laws");
    for entry in CATALOGUE {
        let (link, picture) = (entry.link(), entry.picture());
        let made = page(
            entry.text,
            entry.name,
            Stage::Markdown,
            Some(&link),
            Some(&picture),
        );
        let made = made.unwrap_or_else(|found| panic!("{found:?}"));
        compare(
            docs.join(entry.name).with_extension("md"),
            &made.text,
            &mut wrong,
        );
        if let Some(drawn) = made.picture {
            compare(docs.join(picture), &drawn, &mut wrong);
        }
        assert!(docs.join(&link).exists(), "{link} is not there");
    }
    assert!(wrong.is_empty(), "regenerate: {}", wrong.join(", "));
}

/// A picture that is drawn otherwise is noticed: only places may move, and these by a pixel.
#[test]
fn what_is_wrong_in_a_picture_is_noticed() {
    let entry = registry::find("pmb").unwrap();
    let kept = fs::read_to_string(root().join("../docs/laws").join(entry.picture())).unwrap();
    let with = |from: &str, to: &str| {
        let other = kept.replacen(from, to, 1);
        assert_ne!(kept, other, "{from}");
        picture_differs(&kept, &other)
    };
    let (_, rest) = kept.split_once("points=\"").unwrap();
    let points = rest.split('"').next().unwrap();
    let (first, others) = points.split_once(' ').unwrap();
    let (x, y) = first.split_once(',').unwrap();
    let x: u32 = x.parse().unwrap();
    let moved = |by: u32| with(points, &format!("{},{y} {others}", x + by));
    assert_eq!(moved(1), None);
    assert_eq!(moved(FINE), None);
    assert!(moved(FINE + 1).is_some());
    let line = with(points, others).unwrap();
    assert!(line.starts_with("has points="), "{line}");
    for (from, to) in [
        ("continuum", "lattice"),
        ("\n0.5\n", "\n0.6\n"),
        ("#1F77B4", "#1F77B5"),
        ("stroke-width=\"8\"", "stroke-width=\"9\""),
        ("points=\"", "points=\"a,"),
        ("x=\"0\"", "x=\"nan\""),
        ("<polyline fill=\"none\"", "<polyline"),
    ] {
        assert!(with(from, to).is_some(), "{from} as {to}");
    }
}

/// The words of a page, without marks, formulas and line ends.
fn words(text: &str) -> String {
    let marks = ["`", "$", "#", "\\texttt{", "\\", "{", "}"];
    let bare = marks
        .iter()
        .fold(text.to_string(), |t, mark| t.replace(mark, " "));
    bare.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The forms of a page are of one model: headings and sentences are the same in all.
#[test]
fn forms_of_a_page_say_the_same() {
    for name in ["lps", "heat", "correspondence"] {
        let entry = CATALOGUE.iter().find(|e| e.name == name).unwrap();
        let of = |stage| words(&page(entry.text, name, stage, None, None).unwrap().text);
        let forms = [Stage::Terminal, Stage::Markdown, Stage::Latex].map(of);
        for part in [
            "Parameters",
            "Definitions",
            "The law as it is written",
            "Waves and moduli",
            "Related laws",
            &words(&entry.kernels_said()),
            "How it is computed",
            "takes away",
            "Probes",
            "Its bonds",
            &words(&entry.law().unwrap().cites[0]),
        ] {
            for form in &forms {
                assert!(form.contains(part), "{name}: `{part}` is missing in {form}");
            }
        }
        assert_eq!(forms[0].contains("The tangent"), name != "heat");
        assert!(!forms[0].contains("frac"), "{}", forms[0]);
    }
}
