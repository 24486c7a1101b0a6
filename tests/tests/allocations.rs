//! A step allocates nothing, also while bonds break.
use pdlang_models::bench::scene;
use pdlang_models::registry;
use pdlang_runtime::engine::{Breaking, Isa, Traversal};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: the system's allocator, with a counter beside it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, p: *mut u8, layout: Layout) {
        unsafe { System.dealloc(p, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_step_allocates_nothing() {
    let body = scene::body(13);
    // More threads than one hand tasks to each other through queues that grow now and then.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("one thread");
    pool.install(|| {
        for traversal in [Traversal::Lattice, Traversal::Cloud] {
            for (name, params) in [
                ("pmb", vec![scene::K, 2e-3]),
                ("lps", vec![scene::K, scene::G, 2e-3]),
            ] {
                let law = registry::find(name)
                    .and_then(|e| e.compiled(3))
                    .expect("a law of the catalogue");
                let mut e = scene::engine(&body, law, params, traversal, Isa::best())
                    .expect("a valid scene");
                let mut s = scene::displaced(&e, &body);
                let du = s.u.clone();
                let before = COUNT.get();
                assert!(
                    e.forces(&mut s, Breaking::Armed) > 0,
                    "the test wants broken bonds"
                );
                e.energy(&s);
                e.tangent(&s, &du);
                e.commit(&mut s);
                assert_eq!(COUNT.get() - before, 0, "{name} {traversal:?}");
            }
        }
    });
}
