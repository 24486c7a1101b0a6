//! What all sections of a scene share: the language, the named constants, the list of problems.

use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;

use super::document::{Data, Value};
use super::problem::Problem;
use super::section::Section;
use super::value;
use crate::language::{Compiled, Complaint, Expected, Exponents, Language, Variable, dimension};
use crate::spec::{Op, Tape};

/// A named constant of `[let]`, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Constant {
    pub name: String,
    pub value: f64,
    pub unit: Exponents,
}

/// Names that every expression knows; a constant cannot take them.
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
    constants: RefCell<Vec<Constant>>,
    problems: RefCell<Vec<Problem>>,
}

impl<'a> Reader<'a> {
    pub fn new(language: &'a dyn Language, directory: &'a Path, text: &'a str) -> Reader<'a> {
        Reader {
            language,
            directory,
            text,
            constants: RefCell::default(),
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

    pub fn define(&self, constant: Constant) {
        self.constants.borrow_mut().push(constant);
    }

    /// A number in SI units, or a text with a unit, or an expression of named constants.
    pub fn quantity(&self, value: &Value, unit: Exponents) -> Option<f64> {
        match &value.data {
            Data::Number(n, _) => Some(*n),
            Data::Text(text) => {
                let (number, _) = self.number(text, value, Expected::Unit(unit), &[])?;
                Some(number)
            }
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

    /// The items of a list that must have one item per dimension.
    pub fn components<'v>(&self, value: &'v Value, dim: usize) -> Option<&'v [Value]> {
        match &value.data {
            Data::List(list) if list.len() == dim => Some(list),
            Data::List(list) => {
                let problem = Problem::new(format!("expected {dim} components, one per dimension"))
                    .at(value.span.clone(), format!("this has {}", list.len()));
                self.complain(problem);
                None
            }
            _ => self.wrong_type(value, &format!("a list of {dim} components")),
        }
    }

    /// Value and unit of an expression of named constants, and of `extra` ones.
    pub fn number(
        &self,
        text: &str,
        place: &Value,
        expected: Expected,
        extra: &[Constant],
    ) -> Option<(f64, Exponents)> {
        let mut known = self.constants.borrow().clone();
        known.extend_from_slice(extra);
        let found = self.compiled(text, place, &[], &known, expected)?;
        let number = value::of(&found.tape);
        if number.is_finite() {
            return Some((number, found.unit));
        }
        let problem = Problem::new("this expression has no finite value")
            .at(place.span.clone(), format!("gives {number}"));
        self.complain(problem);
        None
    }

    /// An expression in the first `coordinates` of x, y, z, t and in named constants, as a tape that
    /// reads `Var(k)` = the k-th coordinate. A number stands for itself.
    pub fn expression(
        &self,
        value: &Value,
        coordinates: usize,
        expected: Expected,
    ) -> Option<Tape> {
        match &value.data {
            Data::Number(n, _) if expected != Expected::Condition => Some(Tape {
                ops: vec![Op::Lit(*n)],
                outs: vec![0],
            }),
            Data::Text(text) => {
                let constants = self.constants.borrow().clone();
                let coordinates = &COORDINATES[..coordinates];
                Some(
                    self.compiled(text, value, coordinates, &constants, expected)?
                        .tape,
                )
            }
            _ => self.wrong_type(value, "an expression in quotes"),
        }
    }

    fn compiled(
        &self,
        text: &str,
        place: &Value,
        coordinates: &[(&str, Exponents)],
        constants: &[Constant],
        expected: Expected,
    ) -> Option<Compiled> {
        let coordinate = |(name, unit): &(&str, Exponents)| Variable {
            name: name.to_string(),
            unit: *unit,
        };
        let constant = |c: &Constant| Variable {
            name: c.name.clone(),
            unit: c.unit,
        };
        let variables: Vec<Variable> = coordinates
            .iter()
            .map(coordinate)
            .chain(constants.iter().map(constant))
            .collect();
        match self.language.expression(text, &variables, expected) {
            Ok(mut found) => {
                substitute(&mut found.tape, coordinates.len(), constants);
                Some(found)
            }
            Err(complaints) => {
                self.complain_all(complaints, text, place);
                None
            }
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

/// Puts the values of constants in the place of the variables that stand behind the coordinates.
fn substitute(tape: &mut Tape, coordinates: usize, constants: &[Constant]) {
    for op in &mut tape.ops {
        if let Op::Var(k) = op
            && let Some(constant) = (*k as usize)
                .checked_sub(coordinates)
                .and_then(|k| constants.get(k))
        {
            *op = Op::Lit(constant.value);
        }
    }
}
