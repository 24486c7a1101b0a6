//! Scenes: TOML text to validated data, and from there to a ready simulation.
//!
//! Input: the text and a [`Language`]. Output: a [`Scene`], or every problem that could be found at once,
//! each with its place in the text. Nothing large is allocated before [`Scene::setup`].

mod absorbing;
mod body;
mod conditions;
mod constants;
mod document;
mod family;
mod formula;
pub mod implied;
mod matching;
mod material;
pub mod node_table;
mod output;
mod problem;
mod reader;
mod section;
mod setup;
mod shape;
mod time;

pub use body::Nodes;
pub use family::{Family, Horizon};
pub use material::{Influence, Material};
pub use problem::{Problem, Problems};
pub use section::nearest;

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::conditions::Condition;
use crate::contact::Indenter;
use crate::language::Language;
use crate::language::dimension::LENGTH;
use crate::matching::Matching;
use crate::observe::Outputs;
use crate::shape::{Shape, Surface};
use crate::simulate::{End, StepRule};
use reader::{Named, Reader};
use section::Section;

/// A scene that has been understood.
#[derive(Clone)]
pub struct Scene {
    /// File name without its extension; outputs are named after it.
    pub name: String,
    /// Folder of the file: relative paths start there.
    pub directory: PathBuf,
    pub title: String,
    pub nodes: Nodes,
    pub family: Family,
    pub material: Material,
    pub cracks: Vec<Surface>,
    pub no_fail: Vec<Shape>,
    pub initial: Vec<Condition>,
    pub conditions: Vec<Condition>,
    pub indenters: Vec<Indenter>,
    pub matching: Vec<Matching>,
    absorbing: Vec<absorbing::Layer>,
    pub end: End,
    pub step: StepRule,
    /// Whether sweeps may leave out the chunks in which nothing changes.
    pub sleep: bool,
    pub outputs: Outputs,
    /// Whether a table of all nodes (position, displacement, force, energy) is written at the end.
    pub node_table: bool,
    source: Source,
}

/// The text, for problems that show only when the body is built.
#[derive(Clone, Debug, Default)]
struct Source {
    path: String,
    text: String,
    body: Range<usize>,
    /// Of the entries of the lists of a scene.
    matching: Vec<Range<usize>>,
    initial: Vec<Range<usize>>,
    conditions: Vec<Range<usize>>,
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// A file that cannot be read, and everything that is wrong with its text.
    pub fn read(path: &Path, language: &dyn Language) -> Result<Scene, Problems> {
        let shown = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| {
            let problem = Problem::new(format!("cannot read the scene `{shown}`: {error}"))
                .help("give the path of a scene file, for example examples/disc-impact.toml");
            Problems::without_text(&shown, problem)
        })?;
        Scene::parse(&text, path, language)
    }

    /// Reads a scene from its text; `path` names it in messages and is where relative paths start.
    ///
    /// # Errors
    /// Everything that is wrong with the text.
    pub fn parse(text: &str, path: &Path, language: &dyn Language) -> Result<Scene, Problems> {
        let shown = path.display().to_string();
        let directory = path.parent().unwrap_or(Path::new(""));
        let (entries, syntax) = document::parse(text);
        let reader = Reader::new(language, directory, text);
        let broken = !syntax.is_empty();
        syntax.into_iter().for_each(|p| reader.complain(p));
        // After broken syntax the rest of the text may be misread: more messages would be guesses.
        if !broken {
            let name = path
                .file_stem()
                .map_or_else(String::new, |s| s.to_string_lossy().into());
            let source = Source {
                path: shown.clone(),
                text: text.into(),
                ..Source::default()
            };
            let root = Section::new(&reader, "the scene", text.len()..text.len(), &entries);
            if let Some(scene) = read(root, name, source)
                && !reader.has_problems()
            {
                return Ok(scene);
            }
        }
        Err(Problems::sorted(&shown, text, reader.problems()))
    }
}

fn read(root: Section<'_>, name: String, source: Source) -> Option<Scene> {
    let reader = root.reader;
    let title = root.text("title").map(|t| t.value.to_string());
    if let Some(constants) = root.section("let") {
        constants::read(constants);
    }
    let body = root.section("body");
    let body = root.require("body", body, "{ .. }: where the nodes are");
    let place = body.as_ref().map_or(0..0, |b| b.span.clone());
    let flavour = body.as_ref().and_then(body::flavour);
    let spacing = body.as_ref().and_then(body::spacing);
    if let Some(dx) = &spacing {
        reader.define(Named::constant("dx", dx.value, LENGTH));
    }
    let family = root.section("family");
    let family = root.require("family", family, "{ horizon = \"3 dx\" }");
    let family = family.and_then(|s| family::read(s, spacing.as_ref()));
    let time = root.section("time");
    let time = root
        .require("time", time, "{ steps = 1000 }")
        .and_then(time::read);
    let material = root.section("material");
    let material = root.require("material", material, "{ model = \"pmb\", .. }");
    let lists = [
        "crack",
        "no_fail",
        "indenter",
        "initial",
        "condition",
        "matching",
        "absorbing",
    ];
    let lists = lists.map(|k| root.sections(k));
    let sides = lists[5].iter().map(|s| s.span.clone()).collect();
    let output = root.section("output");
    root.finish();

    // The rest needs the dimension, and part of it the law: without them no key can be judged.
    let Some(flavour) = flavour else {
        body.iter().for_each(Section::abandon);
        return None;
    };
    let dim = flavour.dim();
    let nodes = body.and_then(|s| body::read(s, flavour, spacing.as_ref().map(|s| s.value)));
    let material = material.and_then(|s| material::read(s, dim, spacing.as_ref()));
    let [
        cracks,
        no_fails,
        indenters,
        initial,
        conditions,
        matched,
        layers,
    ] = lists;
    let cracks = collect(cracks, |s| crack(s, dim));
    let no_fail = collect(no_fails, |s| no_fail(s, dim));
    let indenters = collect(indenters, |s| conditions::indenter(s, dim));
    let material = material?;
    let spec = &material.law.spec;
    let initial = collect(initial, |s| conditions::initial(s, spec));
    let conditions = collect(conditions, |s| conditions::condition(s, spec));
    let matching = collect(matched, |s| matching::read(s, spec));
    let absorbing = collect(layers, |s| absorbing::read(s, spec));
    let output = output.unwrap_or_else(|| Section::new(reader, "[output]", 0..0, &[]));
    let output = output::read(output, spec, time.map(|t| t.0));

    let (end, step, sleep) = time?;
    let (outputs, nodes_asked) = output?;
    let (initial, initial_places) = initial?.into_iter().flatten().unzip();
    let (conditions, condition_places) = conditions?.into_iter().flatten().unzip();
    Some(Scene {
        title: title.unwrap_or_else(|| name.clone()),
        directory: reader.directory.to_path_buf(),
        name,
        nodes: nodes?,
        family: family?,
        cracks: cracks?,
        no_fail: no_fail?,
        initial,
        conditions,
        indenters: indenters?,
        matching: matching?,
        absorbing: absorbing?,
        end,
        step,
        sleep,
        outputs,
        // Forces that are evaluated once are there to be compared.
        node_table: nodes_asked || end == End::Steps(0),
        material,
        source: Source {
            body: place,
            matching: sides,
            initial: initial_places,
            conditions: condition_places,
            ..source
        },
    })
}

/// Reads all sections, so that the problems of all show.
fn collect<'a, T>(
    sections: Vec<Section<'a>>,
    read: impl FnMut(Section<'a>) -> Option<T>,
) -> Option<Vec<T>> {
    let read: Vec<Option<T>> = sections.into_iter().map(read).collect();
    read.into_iter().collect()
}

fn crack(section: Section<'_>, dim: usize) -> Option<Surface> {
    let surface = shape::surface(&section, dim);
    section.finish();
    surface
}

fn no_fail(section: Section<'_>, dim: usize) -> Option<Shape> {
    let region = conditions::region(&section, dim);
    section.finish();
    region
}

#[cfg(test)]
mod tests;
