//! What all sections of a scene share: the language, the named constants, the list of problems.

use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;

use super::document::{Data, Value};
use super::formula;
use super::problem::Problem;
use super::section::Section;

use crate::language::{
    Compiled, Complaint, Constant, Expected, Exponents, Language, Variable, dimension,
};
use crate::spec::{Op, Tape};

/// A named expression of `[let]`: a constant, or a function of the coordinates, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    pub name: String,
    pub unit: Exponents,
    /// Reads `Var(k)`, the k-th of [`COORDINATES`].
    pub tape: Tape,
}

impl Named {
    pub fn constant(name: &str, value: f64, unit: Exponents) -> Named {
        Named {
            name: name.into(),
            unit,
            tape: literal(value),
        }
    }
}

/// Names that every expression knows; `[let]` cannot define them.
pub(super) const COORDINATES: [(&str, Exponents); 4] = [
    ("x", dimension::LENGTH),
    ("y", dimension::LENGTH),
    ("z", dimension::LENGTH),
    ("t", dimension::TIME),
];

pub(super) struct Reader<'a> {
    pub language: &'a dyn Language,
    /// Folder of the scene file: relative paths start here.
    pub directory: &'a Path,
    text: &'a str,
    named: RefCell<Vec<Named>>,
    problems: RefCell<Vec<Problem>>,
}

impl<'a> Reader<'a> {
    pub fn new(language: &'a dyn Language, directory: &'a Path, text: &'a str) -> Reader<'a> {
        Reader {
            language,
            directory,
            text,
            named: RefCell::default(),
            problems: RefCell::default(),
        }
    }

    pub fn complain(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }

    pub fn problems(&self) -> Vec<Problem> {
        self.problems.borrow().clone()
    }

    pub fn has_problems(&self) -> bool {
        !self.problems.borrow().is_empty()
    }

    /// Complains about the type of a value, unless it has been complained about already.
    pub fn wrong_type<T>(&self, value: &Value, expected: &str) -> Option<T> {
        if !matches!(value.data, Data::Unusable("not a finite number")) {
            let problem = Problem::new(format!("expected {expected}"))
                .at(value.span.clone(), format!("this is {}", value.kind()));
            self.complain(problem);
        }
        None
    }

    pub fn section_of(
        &'a self,
        value: &'a Value,
        title: String,
        span: Range<usize>,
    ) -> Option<Section<'a>> {
        match &value.data {
            Data::Table(entries) => Some(Section::new(self, title, span, entries)),
            _ => self.wrong_type(value, "a table"),
        }
    }

    pub fn define(&self, named: Named) {
        self.named.borrow_mut().push(named);
    }

    /// The names of [let] that are numbers, not functions of the coordinates.
    pub fn constants(&self) -> Vec<Constant> {
        let named = self.named.borrow();
        let constant = |n: &Named| Constant {
            name: n.name.clone(),
            value: formula::value(&n.tape),
            unit: n.unit,
        };
        let mut found: Vec<Constant> = named.iter().map(constant).collect();
        found.retain(|c| c.value.is_finite());
        found
    }

    /// A number in SI units, or a text with a unit, or an expression of named constants.
    pub fn quantity(&self, value: &Value, unit: Exponents) -> Option<f64> {
        match &value.data {
            Data::Number(n, _) => Some(*n),
            Data::Text(text) => self.number(text, value, unit),
            _ => {
                let name = self.language.unit_name(unit);
                let expected = match unit {
                    dimension::NUMBER => "a number".to_string(),
                    _ => format!("a number in {name} or a text with a unit"),
                };
                self.wrong_type(value, &expected)
            }
        }
    }

    /// One quantity per dimension; the components beyond are 0.
    pub fn vector(&self, value: &Value, unit: Exponents, dim: usize) -> Option<[f64; 3]> {
        let list = self.components(value, dim)?;
        let mut vector = [0.0; 3];
        for (component, item) in vector.iter_mut().zip(list) {
            *component = self.quantity(item, unit)?;
        }
        Some(vector)
    }

    /// The items of a list that must have so many: one per dimension, or those of a tensor.
    pub fn components<'v>(&self, value: &'v Value, count: usize) -> Option<&'v [Value]> {
        match &value.data {
            Data::List(list) if list.len() == count => Some(list),
            Data::List(list) => {
                let problem = Problem::new(format!("expected {count} components"))
                    .at(value.span.clone(), format!("this has {}", list.len()));
                self.complain(problem);
                None
            }
            _ => self.wrong_type(value, &format!("a list of {count} components")),
        }
    }

    /// Value of an expression without coordinates.
    fn number(&self, text: &str, place: &Value, unit: Exponents) -> Option<f64> {
        let number = formula::value(&self.compiled(text, place, 0, Expected::Unit(unit))?.tape);
        if number.is_finite() {
            return Some(number);
        }
        let problem = Problem::new("this expression has no finite value")
            .at(place.span.clone(), format!("gives {number}"));
        self.complain(problem);
        None
    }

    /// An expression in the first `coordinates` of x, y, z, t and in named expressions, as a tape that
    /// reads `Var(k)`, the k-th coordinate. A number stands for itself.
    pub fn expression(
        &self,
        value: &Value,
        coordinates: usize,
        expected: Expected,
    ) -> Option<Compiled> {
        match (&value.data, expected) {
            (Data::Number(n, _), Expected::Unit(unit)) => Some(Compiled {
                tape: literal(*n),
                unit,
            }),
            (Data::Number(n, _), Expected::Scalar) => Some(Compiled {
                tape: literal(*n),
                unit: dimension::NUMBER,
            }),
            (Data::Text(text), _) => self.compiled(text, value, coordinates, expected),
            _ => self.wrong_type(value, "a number or an expression in quotes"),
        }
    }

    fn compiled(
        &self,
        text: &str,
        place: &Value,
        coordinates: usize,
        expected: Expected,
    ) -> Option<Compiled> {
        let named = self.named.borrow();
        let known = &COORDINATES[..coordinates];
        let variables: Vec<Variable> = known
            .iter()
            .map(|(name, unit)| Variable {
                name: name.to_string(),
                unit: *unit,
            })
            .chain(named.iter().map(|n| Variable {
                name: n.name.clone(),
                unit: n.unit,
            }))
            .collect();
        let found = self.language.expression(text, &variables, expected);
        let found = found
            .map_err(|complaints| self.complain_all(complaints, text, place))
            .ok()?;
        let tapes: Vec<&Tape> = named.iter().map(|n| &n.tape).collect();
        let tape = formula::splice(&found.tape, coordinates as u32, &tapes);
        match formula::last_variable(&tape).and_then(|k| COORDINATES.get(k as usize)) {
            Some((name, _)) if !known.iter().any(|(k, _)| k == name) => {
                let problem =
                    Problem::new(format!("this depends on `{name}`, which has no value here"));
                self.complain(problem.at(place.span.clone(), "through a name of [let]"));
                None
            }
            _ => Some(Compiled {
                tape,
                unit: found.unit,
            }),
        }
    }

    /// Moves complaints about the text of a value to their places in the scene.
    pub fn complain_all(&self, complaints: Vec<Complaint>, text: &str, place: &Value) {
        for complaint in complaints {
            let span = self.inside(place, text, &complaint.span);
            let problem = Problem::new(complaint.message).at(span, complaint.label);
            self.complain(Problem {
                help: complaint.help,
                ..problem
            });
        }
    }

    /// Range of the scene for a range of the text in quotes; the whole value if it was written with escapes.
    fn inside(&self, place: &Value, text: &str, span: &Range<usize>) -> Range<usize> {
        let written = self.text.get(place.span.clone()).unwrap_or("");
        let quotes = if written.starts_with("\"\"\"") || written.starts_with("'''") {
            3
        } else {
            1
        };
        match written.get(quotes..quotes + text.len()) {
            Some(same) if same == text => {
                let start = place.span.start + quotes;
                start + span.start..start + span.end
            }
            _ => place.span.clone(),
        }
    }

    /// A value as a message shows it: `-0.5 m`.
    pub fn shown(&self, value: f64, unit: Exponents) -> String {
        match unit {
            dimension::NUMBER => format!("{value}"),
            _ => format!("{value} {}", self.language.unit_name(unit)),
        }
    }
}

fn literal(value: f64) -> Tape {
    Tape {
        ops: vec![Op::Lit(value)],
        outs: vec![0],
    }
}
