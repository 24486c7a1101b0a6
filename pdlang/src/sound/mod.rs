//! Checks between the stages of the compiler: what each promises to the next. For tests.
//!
//! Contract. Every function returns what is wrong, in words; nothing for what the compiler makes of a law without
//! errors. They read the data of a stage alone and share no code with what made it.
//!
//! Allowed: state slots that nobody reads (a field that only a condition of the scene needs), operations that several
//! tapes repeat, sums of nothing, and the slots that [`unread`] lists: named parts that the schedule stores, as in the
//! tangent of correspondence laws, though no tape ends up reading them.

mod law;
mod polynomials;
mod schedule;
mod spec;
mod tapes;

pub use law::law;
pub use spec::{spec, unread};

use crate::assemble::{self, Between, Kinematics};
use crate::diag::Diagnostic;
use crate::ir::Law;
use crate::spec::Spec;

/// Findings, and what they are about.
#[derive(Default)]
struct Report {
    about: String,
    found: Vec<String>,
}

impl Report {
    fn at(&mut self, about: String) {
        self.about = about;
    }
    fn add(&mut self, what: String) {
        let about = &self.about;
        self.found.push(match about.is_empty() {
            true => what,
            false => format!("{about}: {what}"),
        });
    }
}

/// Compiles a law for bodies of `dim` dimensions and checks it after every stage.
///
/// # Errors
/// As [`assemble::spec`].
pub fn compiled(
    checked: &Law,
    dim: usize,
    kinematics: Kinematics,
) -> Result<(Spec, Vec<String>), Vec<Diagnostic>> {
    let mut found = law(checked);
    let made = assemble::watched(checked, dim, kinematics, &mut |between| match between {
        Between::Answers(algebra, responses) => {
            found.extend(polynomials::check(algebra, responses))
        }
        Between::Schedule(algebra, plan) => found.extend(schedule::check(algebra, plan)),
    })?;
    found.extend(spec(&made));
    Ok((made, found))
}

#[cfg(test)]
mod tests;
