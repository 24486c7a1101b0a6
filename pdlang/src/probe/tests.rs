//! Laws with values that are known, and values that are wrong.

use super::*;
use crate::front;

fn outcomes(text: &str) -> Vec<Outcome> {
    let checked = front::file(text);
    assert!(!checked.has_errors(), "{:#?}", checked.diagnostics);
    run(&checked.laws[0])
}

#[track_caller]
fn holds(items: &str) {
    let text = format!("model m \"Test\" cite \"Nobody, eq. 1\" {{ {items} }}");
    for outcome in outcomes(&text) {
        assert!(outcome.holds(), "{outcome:#?}");
    }
}

/// Fourier's law on two nodes: the rate, a field, a constant and a value on a bond.
#[test]
fn a_rate_between_two_nodes() {
    holds(
        "field T : temperature \"temperature\"
         param k : [W/m^6/K] > 0 \"bond conductivity\"
         param c : [J/m^3/K] > 0 \"heat capacity\"
         let q = k/c
         bond dT = T' - T
         rate T = q*sum(dT)
         probe two in bar where k = 2 [W/m^6/K], c = 4 [J/m^3/K], delta = 2 m {
           node a = 0, V = 1 m^3
           node b = 1 m, V = 3 m^3, T = 5 K
           expect q = 0.5 [1/s/m^3]
           expect dT(a, b) = 5 K
           expect rate T(a) = 7.5 [K/s]
           expect rate T(b) = -2.5 [K/s]
         }",
    );
}

/// The gradient of a homogeneous deformation, by sums over the full family of a square lattice.
#[test]
fn a_tensor_on_a_lattice() {
    holds(
        "param c : [N/m^7] > 0 \"stiffness\" influence omega = constant
         node shape : symmetric = sum(omega*outer(xi, xi)) node F : tensor = sum(omega*outer(Y, xi))*inverse(shape)
         node n = sum(1)
         bond z : vector = Y - F*xi
         state T : vector = c*z
         probe sheared in plane_strain where c = 1 [N/m^7], delta = 2 mm, thickness = 1 mm {
           lattice 1 mm, H = ((0.1, 0.2), (-0.3, 0.4))
           expect F = ((1.1, 0.2), (-0.3, 1.4))
           expect n = 12 mm^3
           expect force = (0, 0) within 1e-9 [N/m^3]
         }",
    );
}

/// A broken bond bears no force, the reference sum keeps it.
#[test]
fn broken_bonds() {
    holds(
        "param c : [N/m^6] > 0 \"stiffness\" node n = sum(1) node all = sum0(1) pair f = c*s
         probe cut in slab where c = 2 [N/m^6], delta = 1.5 m {
           node a = 0, V = 1 m^3 node b = 1 m, V = 2 m^3, u = 0.5 m node d = -1 m, V = 1 m^3, u = -0.25 m
           break (a, b)
           expect n(a) = 1 m^3 expect all(a) = 3 m^3 expect force(a) = -0.5 [N/m^3] expect force(b) = 0
         }",
    );
}

#[test]
fn what_is_off_is_found() {
    let text = "model m \"Test\" cite \"Nobody, eq. 1\" { param c : [N/m^6] > 0 \"c\" pair f = c*s
        probe p in slab where c = 2 [N/m^6], delta = 1.5 m {
          node a = 0, V = 1 m^3 node b = 1 m, V = 2 m^3, u = 0.5 m
          expect force(a) = 2.0001 [N/m^3]
          expect force(a) = 2.0001 [N/m^3] within 1e-4
          expect force(a) = 2.1 [N/m^3] within 0.11 [N/m^3]
        } }";
    let holds: Vec<bool> = outcomes(text).iter().map(Outcome::holds).collect();
    assert_eq!(holds, [false, true, true]);
}

/// The laws of the catalogue were worked out by hand.
#[test]
fn laws_of_the_catalogue() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../models/laws");
    let mut wrong = String::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let text = std::fs::read_to_string(entry.path()).unwrap();
        let checked = front::file(&text);
        let found = checked.laws.iter().flat_map(findings);
        for finding in checked.diagnostics.iter().cloned().chain(found) {
            wrong += &finding.render(&text, &entry.path().display().to_string(), false);
            wrong += "\n";
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
