//! What can be wrong with a law. One check, one file, one code, and its tests beside it; here is the list.
//!
//! A check states a finding: what is wrong, at which token, what was expected, what to do. When to ask
//! is the business of `resolve`.

pub(crate) mod added; // PD104: an energy beside a bond force, whose forces add up
pub(crate) mod annotations; // PD016: a declared shape or unit is not what stands behind it
pub(crate) mod arity; // PD006: arguments that do not fit a function
pub(crate) mod balls; // PD022: `ball` of something that is no constant of the horizon
pub(crate) mod bounds; // PD033: an interval that is empty, a default outside of it
pub(crate) mod breaks; // PD044, PD106: bonds that break by something that is not theirs
pub(crate) mod citations; // PD031: no paper, or no equation number
pub(crate) mod components; // PD008: components that a value does not have
pub(crate) mod cycles; // PD005: definitions that need themselves
pub(crate) mod descriptions; // PD032: a parameter without a description
pub(crate) mod differences; // PD105: a difference of two equal values
pub(crate) mod duplicates; // PD003: a name for two things
pub(crate) mod ends; // PD042: a pair force, or a family that carries forces, that is not the same from both ends
pub(crate) mod exponents; // PD014: a power whose unit is unknown
pub(crate) mod families; // PD025: a family that is not part of the reference horizon
pub(crate) mod flavours; // PD010: a case that is not about the five flavours
pub(crate) mod habits; // help with what is called otherwise elsewhere
pub(crate) mod half; // PD041: a field at half steps that cannot be stepped
pub(crate) mod homes; // PD020: a value where it does not live
pub(crate) mod influences; // PD050: an influence function that is not complete
pub(crate) mod kept; // PD028: a history of the bonds of one family, read on those of another
pub(crate) mod knowns; // PD036: what is known of a check that does not exist
pub(crate) mod meets; // PD035: an unknown way for two materials to meet
pub(crate) mod names; // PD002: a name that means nothing here
pub(crate) mod numbers; // PD013: a unit where only a number makes sense
pub(crate) mod parts; // PD043: a field on a part of the body that a run could change
pub(crate) mod primes; // PD021: a prime on what has no other end
pub(crate) mod probed; // PD061: a law that does not give the value that a probe expects
pub(crate) mod probes; // PD060: a probe that does not fit its law
pub(crate) mod quantities; // PD034: a default, bound or argument that does not have the right unit
pub(crate) mod reserved; // PD004: a name that the language uses itself
pub(crate) mod responses; // PD040: a law that does not answer, or answers twice
pub(crate) mod rings; // PD024: an energy that needs the neighbours of neighbours
pub(crate) mod shadowing; // PD101: a name of the prelude, defined again
pub(crate) mod shapes; // PD007: scalars, vectors and tensors that do not fit together
pub(crate) mod size; // PD009: a law without end
pub(crate) mod suggest;
pub(crate) mod sums; // PD023: a sum of values that do not belong to its bonds
pub(crate) mod syntax; // PD001: not a law at all
pub(crate) mod titles; // PD030: a law without a title
pub(crate) mod under; // PD026: `under` of what a gradient does not determine
pub(crate) mod unit_mismatch; // PD012: units that differ where they must agree
pub(crate) mod unit_of_response; // PD015: a response in the wrong unit
pub(crate) mod units; // PD011: a unit or kind that does not exist
pub(crate) mod unprobed; // PD103: a law without a probe
pub(crate) mod unused; // PD102: a definition that nothing uses
pub(crate) mod uses; // PD070: a file that cannot be used
pub(crate) mod weights; // PD027: a weight that is not determined by the reference body

#[cfg(test)]
pub(crate) mod tests;

use crate::ir::Shape;

/// A shape in words.
pub(crate) fn shape_name(shape: Shape) -> &'static str {
    match shape {
        Shape::Scalar => "a scalar",
        Shape::Vector => "a vector",
        Shape::Symmetric => "a symmetric tensor",
        Shape::Tensor => "a tensor",
        Shape::Boolean => "a condition",
    }
}
