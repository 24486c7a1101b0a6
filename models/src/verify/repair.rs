//! The definition that a wrong constant comes from.
//!
//! Input: the constants of all flavours, some of them wrong. Every definition and answer of the law, and every term that one
//! adds up, is multiplied by a number such that the first wrong constant of a flavour is right. It is to blame if then all are
//! right, with other parameters too, and in every flavour in which something is wrong. Of several, the one whose numbers are
//! the simplest fractions comes first, then the first in the text. Where no number helps, what changes the constants that
//! are wrong and none that is right is named.

use pdlang::ir::{ExprId, Flavour, Law, Shape};
use std::f64::consts::PI;

use super::constants::{self, EXACT, Families, Quantity};
use super::place::{Place, expr_of, multiplied, terms};
use super::subject::{PRESSURE, Subject, fits, has_unit};

/// Largest numerator and denominator of a simple fraction.
const SIMPLE: i64 = 128;
/// Of a number that is none.
const EFFORT: i64 = 100_000;
const STEPS: usize = 16;

/// Longest text that is quoted.
const QUOTE: usize = 60;

/// A place, and what may mend it in a flavour.
#[derive(Clone, Debug)]
pub struct Cure {
    pub place: Place,
    pub advice: String,
}

/// What can be multiplied.
#[derive(Clone, Copy)]
struct Suspect {
    expr: ExprId,
    /// The number of the term, of how many.
    term: (usize, usize),
}

impl Suspect {
    /// As sentences name it.
    fn name(self, place: &Place) -> String {
        match self.term {
            (_, 1) => place.to_string(),
            (k, _) => format!("term {} of {place}", k + 1),
        }
    }

    /// What the advice is about, as it stands in the text, where that is short.
    fn quote(self, subject: &Subject) -> String {
        let span = subject.law.exprs[self.expr.index()].span;
        let text = subject.text.get(span.start as usize..span.end as usize);
        let short = |t: &&str| !span.prelude && t.len() <= QUOTE && !t.contains('\n');
        match text.filter(short) {
            Some(text) if self.term.1 > 1 => format!("; the term is `{text}`"),
            _ => String::new(),
        }
    }
}

/// A flavour in which a constant is wrong.
struct Ward {
    flavour: Flavour,
    families: Families,
    list: Vec<Quantity>,
    /// Values of parameters, and what the law declares with them.
    trials: [(Vec<f64>, Vec<f64>); 2],
    /// Relative errors with the first; `None` where there is no number.
    off: Vec<Option<f64>>,
}

impl Ward {
    fn new(subject: &Subject, flavour: Flavour) -> Option<Ward> {
        let law = subject.law;
        let list = constants::quantities(law, &subject.params, flavour);
        let trial = |params: Vec<f64>| {
            let value = |q: &Quantity| constants::expected(*q, law, &params, flavour);
            let expected: Option<Vec<f64>> = list.iter().map(value).collect();
            expected.map(|expected| (params, expected))
        };
        let trials = [trial(subject.params.clone())?, trial(others(subject))?];
        let families = Families::coarse(law, flavour, subject.horizon);
        let mut ward = Ward {
            flavour,
            families,
            list,
            trials,
            off: Vec::new(),
        };
        ward.off = (0..ward.list.len())
            .map(|k| ward.off(subject, law, 0, k))
            .collect();
        ward.first().map(|_| ward)
    }

    /// Relative error of a constant of a law.
    fn off(&self, subject: &Subject, law: &Law, trial: usize, k: usize) -> Option<f64> {
        let (params, expected) = &self.trials[trial];
        let settings = constants::settings(subject, self.flavour, params);
        let found = constants::measure(self.list[k], law, &self.families, &settings).ok()?;
        let scale = if expected[k] == 0.0 { 1.0 } else { expected[k] };
        Some((found - expected[k]) / scale).filter(|off| off.is_finite())
    }

    fn right(&self, k: usize) -> bool {
        self.off[k].is_some_and(|off| off.abs() <= EXACT)
    }

    /// The first constant that is wrong.
    fn first(&self) -> Option<usize> {
        (0..self.list.len()).find(|k| !self.right(*k))
    }

    /// The number that makes everything right.
    fn cure(&self, subject: &Subject, suspect: Suspect) -> Option<f64> {
        let first = self.first()?;
        let of = |f: f64| multiplied(subject.law, suspect.expr, f);
        let factor = solve(|f| self.off(subject, &of(f), 0, first))?;
        let mended = of(factor);
        let right = |trial: usize, k: usize| {
            self.off(subject, &mended, trial, k)
                .is_some_and(|off| off.abs() <= EXACT)
        };
        let all = (0..2).all(|trial| (0..self.list.len()).all(|k| right(trial, k)));
        all.then_some(factor)
    }

    /// Whether a suspect changes what is wrong, and nothing that is right.
    fn decides(&self, subject: &Subject, suspect: Suspect) -> bool {
        let other = multiplied(subject.law, suspect.expr, 1.01);
        (0..self.list.len()).all(|k| {
            let changes = match (self.off(subject, &other, 0, k), self.off[k]) {
                (Some(now), Some(before)) => (now - before).abs() > 1e-9,
                (now, before) => now.is_some() != before.is_some(),
            };
            changes != self.right(k)
        })
    }
}

/// What may mend the constants of each flavour in which one is wrong.
pub fn find(subject: &Subject) -> Vec<(Flavour, Cure)> {
    let flavours = subject.law.flavours.iter();
    let wards: Vec<Ward> = flavours
        .filter_map(|flavour| Ward::new(subject, *flavour))
        .collect();
    let suspects = suspects(subject);
    best(subject, &wards, &suspects).unwrap_or_else(|| {
        let deciding = |ward: &Ward| {
            let suspect = suspects
                .iter()
                .rev()
                .find(|s| s.term.1 > 1 && ward.decides(subject, **s));
            let suspect =
                suspect.or_else(|| suspects.iter().find(|s| ward.decides(subject, **s)))?;
            let place = subject.place_of(suspect.expr)?;
            let advice = format!(
                "it depends on {}, on which nothing that is right depends{}",
                suspect.name(&place),
                suspect.quote(subject)
            );
            Some((ward.flavour, Cure { place, advice }))
        };
        wards.iter().filter_map(deciding).collect()
    })
}

/// The suspect that mends all flavours with the simplest numbers.
fn best(subject: &Subject, wards: &[Ward], suspects: &[Suspect]) -> Option<Vec<(Flavour, Cure)>> {
    let mut best: Option<(i64, Vec<(Flavour, Cure)>)> = None;
    for suspect in suspects {
        let Some(place) = subject.place_of(suspect.expr) else {
            continue;
        };
        // Of two, the term of a sum is more than a guess: something else in it stays.
        let mut effort = i64::from(suspect.term.1 == 1);
        let mut cures = Vec::new();
        for ward in wards {
            let Some(factor) = ward.cure(subject, *suspect) else {
                break;
            };
            let (more, words) = fraction(factor);
            effort += 2 * more;
            let quote = suspect.quote(subject);
            let only = match wards.len() {
                1 if subject.law.flavours.len() > 1 => " in this flavour alone (`case flavour`)",
                _ => "",
            };
            let advice = match factor == 0.0 {
                true => format!(
                    "without {} all is what the law declares{only}{quote}",
                    suspect.name(&place)
                ),
                false => format!(
                    "{} times {words} gives all that the law declares{only}{quote}",
                    suspect.name(&place)
                ),
            };
            cures.push((
                ward.flavour,
                Cure {
                    place: place.clone(),
                    advice,
                },
            ));
        }
        let least = best.as_ref().map_or(i64::MAX, |(least, _)| *least);
        if cures.len() == wards.len() && effort < least {
            best = Some((effort, cures));
        }
    }
    best.map(|(_, cures)| cures)
}

/// Definitions, then answers, each whole and term by term.
fn suspects(subject: &Subject) -> Vec<Suspect> {
    let law = subject.law;
    let definitions = subject.definitions().map(|def| def.expr);
    let answers = law.responses.iter().map(expr_of);
    let mut list = Vec::new();
    for expr in definitions.chain(answers) {
        let parts = terms(law, expr);
        let count = parts.len();
        if count > 1 {
            list.push(Suspect { expr, term: (0, 1) });
        }
        list.extend(parts.into_iter().enumerate().map(|(k, expr)| Suspect {
            expr,
            term: (k, count),
        }));
    }
    list.retain(|s| law.exprs[s.expr.index()].shape != Shape::Boolean);
    list
}

/// Other values of the elastic parameters.
fn others(subject: &Subject) -> Vec<f64> {
    let mut factors = [1.3, 0.85, 1.17, 0.93].into_iter().cycle();
    let pairs = subject.law.params.iter().zip(&subject.params);
    let other = pairs.map(|(param, value)| {
        let elastic = has_unit(&param.unit, PRESSURE) || param.unit.is_number();
        if !elastic || !value.is_finite() || *value == 0.0 {
            return *value;
        }
        let changed = factors
            .next()
            .map(|f| f * value)
            .filter(|v| fits(param, *v));
        changed.unwrap_or(*value)
    });
    other.collect()
}

/// A root of a function near 1, by parabolas through its last three values: most constants are of second degree in a factor.
fn solve(f: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let mut points = [(1.0, f(1.0)?), (1.2, f(1.2)?), (0.8, f(0.8)?)];
    for _ in 0..STEPS {
        let [(x0, f0), (x1, f1), (x2, f2)] = points;
        let (d01, d12) = ((f1 - f0) / (x1 - x0), (f2 - f1) / (x2 - x1));
        let a = (d12 - d01) / (x2 - x0);
        let b = a * (x2 - x1) + d12;
        // Rounding may put the top of a parabola that touches zero on its wrong side.
        let root = (b * b - 4.0 * f2 * a).max(0.0).sqrt();
        let below = if b < 0.0 { b - root } else { b + root };
        let step = if below == 0.0 {
            return None;
        } else {
            -2.0 * f2 / below
        };
        let x = x2 + step;
        if !x.is_finite() || x.abs() > 1e6 {
            return None;
        }
        let value = f(x)?;
        if value.abs() < 1e-12 || step.abs() < 1e-13 || points.iter().any(|(p, _)| *p == x) {
            points[2] = (x, value);
            break;
        }
        points = [points[1], points[2], (x, value)];
    }
    let (x, value) = points[2];
    (value.abs() <= EXACT * 1e-1).then_some(if x.abs() < 1e-6 { 0.0 } else { x })
}

/// How far a factor is from a simple one, and how it is written: a fraction, also of pi.
fn fraction(factor: f64) -> (i64, String) {
    if factor == 0.0 {
        return (SIMPLE, "0".into());
    }
    let mut best = (EFFORT, format!("{factor:.6}"));
    for (power, words) in [(0, ""), (1, " pi"), (-1, "/pi"), (2, " pi^2")] {
        let plain = factor / PI.powi(power);
        for q in 1..=SIMPLE {
            let p = (plain * q as f64).round();
            if p != 0.0
                && p.abs() <= SIMPLE as f64
                && (plain - p / q as f64).abs() < 3e-7 * plain.abs()
            {
                let effort = p.abs() as i64 + q + 50 * i64::from(power.abs());
                if effort < best.0 {
                    let number = if q == 1 {
                        format!("{p}")
                    } else {
                        format!("{p}/{q}")
                    };
                    best = (effort, format!("{number}{words}"));
                }
                break;
            }
        }
    }
    best
}
