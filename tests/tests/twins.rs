//! The same sums four ways, bit by bit: tapes, bodies in the runtime's traversals, intrinsics from end to end.
use pdlang_models::bench::scene;
use pdlang_runtime::engine::{Breaking, Engine, Isa, Law, State, Traversal};
use pdlang_runtime::kernel::CompiledKernel;
use pdlang_runtime::spec::Spec;
use pdlang_tests::twins::{bodies, tapes};

/// Not a multiple of eight, so that chunks have empty lanes.
const N: u32 = 13;
const BOTH: [Traversal; 2] = [Traversal::Lattice, Traversal::Cloud];

fn run(e: &mut Engine, s: &mut State) -> (usize, Vec<Vec<f64>>) {
    let broken = e.forces(s, Breaking::Armed);
    (broken, e.force().to_vec())
}

/// Compiled and interpreted, and after some bonds broke.
fn agree(spec: Spec, kernel: &'static CompiledKernel, params: Vec<f64>) {
    let body = scene::body(N);
    for traversal in BOTH {
        for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
            let make = |kernel| {
                let law = Law {
                    spec: spec.clone(),
                    kernel,
                };
                scene::engine(&body, law, params.clone(), traversal, isa).expect("a valid scene")
            };
            let (mut compiled, mut interpreted) = (make(Some(kernel)), make(None));
            let (mut s, mut t) = (
                scene::displaced(&compiled, &body),
                scene::displaced(&interpreted, &body),
            );
            let (broken, f) = run(&mut compiled, &mut s);
            assert!(
                broken > 100 && broken < compiled.report().bonds / 2,
                "{broken}"
            );
            assert!(
                (broken, f) == run(&mut interpreted, &mut t) && s == t,
                "{traversal:?} {isa:?}"
            );
            assert_eq!(run(&mut compiled, &mut s).0, 0);
        }
    }
}

#[test]
fn pmb_compiled_is_pmb_interpreted() {
    agree(tapes::pmb(), &bodies::PMB, scene::pmb_params(2e-3));
}

#[test]
fn lps_compiled_is_lps_interpreted() {
    agree(tapes::lps(), &bodies::LPS, scene::lps_params(2e-3));
}

#[cfg(target_arch = "x86_64")]
#[test]
fn intrinsics_give_the_same_bits() {
    use pdlang_models::bench::{cloud, lattice};
    if !Isa::Avx512.available() {
        return;
    }
    let body = scene::body(N);
    let n = N as usize;
    let params = scene::pmb_params(2e-3);
    for traversal in BOTH {
        let law = Law {
            spec: tapes::pmb(),
            kernel: Some(&bodies::PMB),
        };
        let mut e = scene::engine(&body, law, params.clone(), traversal, Isa::Avx512)
            .expect("a valid scene");
        let mut s = scene::displaced(&e, &body);
        let (_, f) = run(&mut e, &mut s);
        let own = |node: usize, a: usize| f[a][e.slot(node)];
        let u = |node: usize, a: usize| s.u[a][e.slot(node)];
        let mut on_lattice = lattice::Twin::new(n, params[0], params[1]);
        let mut in_cloud = cloud::Twin::new(&body.x, e.slots(), e.len(), params[0], params[1]);
        let slots: Vec<usize> = (0..n * n * n)
            .map(|i| match traversal {
                Traversal::Cloud => e.slot(i),
                _ => on_lattice.slot([i % n, i / n % n, i / n / n]),
            })
            .collect();
        let twin = match traversal {
            Traversal::Cloud => &mut in_cloud.u,
            _ => &mut on_lattice.u,
        };
        for (node, &slot) in slots.iter().enumerate() {
            (0..3).for_each(|a| twin[a][slot] = u(node, a));
        }
        let found = match traversal {
            Traversal::Cloud => {
                in_cloud.pmb();
                &in_cloud.f
            }
            _ => {
                on_lattice.pmb();
                &on_lattice.f
            }
        };
        for (node, &slot) in slots.iter().enumerate() {
            for a in 0..3 {
                assert_eq!(
                    found[a][slot].to_bits(),
                    own(node, a).to_bits(),
                    "{traversal:?} {node}"
                );
            }
        }
    }
}
