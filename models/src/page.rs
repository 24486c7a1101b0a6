//! The page of a law: what the compiler knows of its text, with its waves, its moduli and the laws that it is related to.
//!
//! One page for a terminal, for Markdown and for LaTeX: `pdlang models`, `pdlang emit` and the files of `docs/laws`.

use pdlang::assemble::Kinematics;
use pdlang::diag::Diagnostic;
use pdlang::emit::{self, Part, Request, Stage};
use pdlang::front;
use pdlang::ir::{Flavour, Law};

use crate::verify::{Options, Subject};
use crate::waves::plot::{self, Curve, Series};
use crate::waves::{self, Moving, Study};
use crate::{files, registry, relations};

/// Wave numbers of a picture.
const POINTS: usize = 24;

/// A page and the picture that it shows.
pub struct Page {
    pub text: String,
    /// SVG of the waves, where the law has some.
    pub picture: Option<String>,
}

/// The page of the law of a text, which is called `path` in messages. `link` leads to the text, `picture` to the drawing of the
/// waves; a page without one says how to draw it.
///
/// # Errors
/// All findings, when one of them is an error.
pub fn page(
    text: &str,
    path: &str,
    stage: Stage,
    link: Option<&str>,
    picture: Option<&str>,
) -> Result<Page, Vec<Diagnostic>> {
    let checked = front::file_in(text, path, &mut files::read);
    let mut more = vec![];
    let mut drawn = None;
    // Of several laws in a file, each page would need its own.
    if let [law] = checked.laws.as_slice() {
        more = related(law);
        let (parts, svg) = waves_of(law, text, path, picture);
        more.extend(parts);
        drawn = svg;
    }
    if let Some(entry) = registry::find(path) {
        more.push(Part::Heading("Compiled kernels".into()));
        more.push(Part::Text(entry.kernels_said()));
    }
    let request = Request {
        stage,
        kinematics: Kinematics::General,
        dim: None,
        link,
        more: &more,
    };
    let text = emit::emit_in(text, path, &mut files::read, request)?;
    Ok(Page {
        text,
        picture: drawn,
    })
}

fn related(law: &Law) -> Vec<Part> {
    let sentences: Vec<Part> = relations::of(&law.name)
        .map(|relation| Part::Text(relation.sentence()))
        .collect();
    let heading = (!sentences.is_empty()).then(|| Part::Heading("Related laws".into()));
    heading.into_iter().chain(sentences).collect()
}

/// Two dimensions where the law has them: there both kinds of waves are seen, and little is to be computed.
fn flavour(law: &Law) -> Option<Flavour> {
    let in_2d = law.flavours.iter().find(|f| f.dim() == 2);
    in_2d
        .or_else(|| law.flavours.iter().max_by_key(|f| f.dim()))
        .copied()
}

/// The waves and moduli of a law, or why it has none, and their drawing.
fn waves_of(
    law: &Law,
    text: &str,
    path: &str,
    picture: Option<&str>,
) -> (Vec<Part>, Option<String>) {
    let heading = Part::Heading("Waves and moduli".into());
    let study = match studied(law, text) {
        Ok(study) => study,
        Err(why) => {
            return (
                vec![heading, Part::Text(format!("None are shown: {why}."))],
                None,
            );
        }
    };
    let name = study.flavour.name();
    let mut parts = vec![heading, Part::Text(words(law, &study))];
    let what = format!("Waves of {} along a lattice axis, {name}", law.name);
    let command =
        format!("`pdlang dispersion {path} --flavour {name} --plot FILE.svg` draws its waves.");
    parts.push(match picture {
        Some(path) => Part::Picture(what, path.into()),
        None => Part::Text(command),
    });
    let digits = |v: f64| format!("{v:.3e}");
    let row = |m: &waves::Modulus| {
        vec![
            m.name.clone(),
            digits(m.lattice),
            digits(m.continuum),
            digits(m.declared),
        ]
    };
    let rows: Vec<Vec<String>> = study.moduli.iter().map(row).collect();
    if !rows.is_empty() {
        let columns = vec![
            "constant, in SI",
            "of the lattice",
            "of the continuum",
            "declared",
        ];
        parts.push(Part::Table(columns, rows));
    }
    let series = Series {
        label: String::new(),
        panel: String::new(),
        study,
    };
    (parts, plot::svg(&[series], &Curve::ALL).ok())
}

fn studied(law: &Law, text: &str) -> Result<Study, String> {
    let flavour = flavour(law).ok_or("the law is for no flavour")?;
    let subject = Subject::new(law, text, &Options::default())?;
    let request = waves::Request {
        flavour,
        direction: [1.0, 0.0, 0.0],
        points: POINTS,
    };
    waves::study(&subject, &request)
}

/// Of which body, and what is to be seen.
fn words(law: &Law, study: &Study) -> String {
    let reach = study.horizon / study.spacing;
    let lines = match study.moving {
        Moving::Displacement => "Longitudinal branches are drawn solid, transverse ones dashed",
        Moving::Field(_) => "The rate at which waves of the field decay is drawn solid",
    };
    let zero = match (study.moving, study.zone.zero.is_empty()) {
        (Moving::Field(_), _) => "",
        (_, true) => " No wave is without energy.",
        (_, false) => " Some waves are without energy: they have a ring.",
    };
    format!(
        "In `{}` with a horizon of {reach:.0} spacings and usual values of the parameters. {lines}, the continuum dotted, the local wave \
         equation as thin lines.{zero} `pdlang dispersion {}` has the numbers.",
        study.flavour.name(),
        law.name
    )
}
