//! How long a formula is. The slope of a product of n sums over bonds is a sum of n such products, and its change has n times
//! as many again: at thirty a page of that would be as long as a book.

use super::algebra::{Atom, Kind, Sum};

/// Factors of a formula that a page still shows: what is printed on about three pages.
pub(super) const MOST_FACTORS: usize = 600;

/// Names, functions and reductions in a sum of products.
pub(super) fn factors(sum: &Sum) -> usize {
    let products = sum.0.iter();
    products.flat_map(|p| p.atoms()).map(of_atom).sum()
}

fn of_atom(atom: &Atom) -> usize {
    match &atom.kind {
        Kind::Name(_) | Kind::Written(_) => 1,
        Kind::Call(_, _, args) | Kind::Vector(args) => 1 + args.iter().map(factors).sum::<usize>(),
        Kind::Prime(a) => of_atom(a),
        Kind::Sum(a) | Kind::Component(a, _) | Kind::Not(a) => factors(a),
        Kind::Power(a, b) | Kind::Compare(_, a, b) | Kind::Logic(_, a, b) => {
            factors(a) + factors(b)
        }
    }
}
