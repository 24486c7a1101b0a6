//! What a text gets from the files that it uses: their functions, definitions and influence functions.
//!
//! A file that is used is read once, however many use it; its models stay its own. It sees what it defines and
//! what it uses itself. Its text is foreign here, as that of the prelude is: no finding points into it, so
//! what is wrong in it is said at the `use`, with the lines of that file.

use crate::ast::{self, Name, Text};
use crate::check::uses as say;
use crate::diag::Diagnostic;
use crate::files::{self, Files};
use crate::parse;
use crate::resolve::library::{self, Library};
use std::collections::HashMap;

/// Adds what the files hold that `file`, which stands at `path`, uses. False when a file is not what it should
/// be: then nothing more can be said about the text.
pub(crate) fn add(
    file: &mut ast::File,
    path: &str,
    files: &mut Files,
    report: &mut Vec<Diagnostic>,
) -> bool {
    let before = report.len();
    let mut reader = Reader {
        files,
        origin: HashMap::new(),
        open: vec![path.to_string()],
        done: Vec::new(),
        found: ast::File::default(),
    };
    for used in std::mem::take(&mut file.uses) {
        if let Err(finding) = reader.read(&used, path, &used) {
            report.push(*finding);
        }
    }
    if report.len() > before {
        return false;
    }
    let (found, origin) = (reader.found, reader.origin);
    let mut free = |name: &Name| match origin.get(&name.text) {
        Some(path) => {
            report.push(say::taken(name, path));
            false
        }
        None => true,
    };
    file.functions.retain(|f| free(&f.name));
    file.definitions.retain(|d| free(&d.name));
    file.influences.retain(|i| free(&i.name));
    file.functions.extend(found.functions);
    file.definitions.extend(found.definitions);
    // An influence function may call what comes before it.
    file.influences.splice(0..0, found.influences);
    true
}

struct Reader<'f, 'g> {
    files: &'f mut Files<'g>,
    /// Which file defines a name.
    origin: HashMap<String, String>,
    /// The files that are being read, each used by the one before.
    open: Vec<String>,
    done: Vec<String>,
    found: ast::File,
}

type Step = Result<(), Box<Diagnostic>>;

impl Reader<'_, '_> {
    /// Reads the file that `used` names in the file at `from`; `place` is the `use` of the text at hand.
    fn read(&mut self, used: &Text, from: &str, place: &Text) -> Step {
        let path = files::beside(from, &used.text);
        if let Some(first) = self.open.iter().position(|open| *open == path) {
            let mut chain = self.open[first..].to_vec();
            chain.push(path);
            return Err(Box::new(say::cycle(place, &chain)));
        }
        if self.done.contains(&path) {
            return Ok(());
        }
        let text = (self.files)(&path).map_err(|why| Box::new(say::missing(place, &path, &why)))?;
        let mut findings = Vec::new();
        let mut file = parse::file(&text, true, &mut findings);
        file.models.clear();
        self.open.push(path.clone());
        for used in std::mem::take(&mut file.uses) {
            self.read(&used, &path, place)?;
        }
        self.open.pop();
        self.check(&file, &text, &mut findings);
        if let Some(finding) = findings.iter().find(|finding| finding.is_error()) {
            let shown = finding.render(&text, &path, false);
            return Err(Box::new(say::broken(place, &path, &shown)));
        }
        self.keep(file, &path, place)?;
        self.done.push(path);
        Ok(())
    }

    /// What is wrong with the definitions of a file, seen from the file.
    fn check(&self, file: &ast::File, text: &str, findings: &mut Vec<Diagnostic>) {
        let mut whole = file.clone();
        // A name that two files define is another finding.
        let functions = self
            .found
            .functions
            .iter()
            .filter(|f| !defines(file, &f.name));
        let definitions = self
            .found
            .definitions
            .iter()
            .filter(|d| !defines(file, &d.name));
        whole.functions.extend(functions.cloned());
        whole.definitions.extend(definitions.cloned());
        drop(Library::of(whole, text, library::prelude(), findings));
    }

    fn keep(&mut self, file: ast::File, path: &str, place: &Text) -> Step {
        let functions = file.functions.iter().map(|f| &f.name);
        let definitions = file.definitions.iter().map(|d| &d.name);
        let influences = file.influences.iter().map(|i| &i.name);
        for name in functions.chain(definitions).chain(influences) {
            let earlier = self.origin.insert(name.text.clone(), path.into());
            if let Some(earlier) = earlier.filter(|earlier| earlier != path) {
                return Err(Box::new(say::twice(place, &name.text, &earlier, path)));
            }
        }
        self.found.functions.extend(file.functions);
        self.found.definitions.extend(file.definitions);
        self.found.influences.extend(file.influences);
        Ok(())
    }
}

fn defines(file: &ast::File, name: &Name) -> bool {
    let functions = file.functions.iter().map(|f| &f.name);
    let definitions = file.definitions.iter().map(|d| &d.name);
    functions
        .chain(definitions)
        .any(|own| own.text == name.text)
}
