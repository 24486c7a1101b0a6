//! Generated kernels against their hand-written twins: ns per directed bond and thread, minimum of many
//! interleaved runs, CPU time. `cargo bench --bench kernels -- [--isa avx512] [--n 50] [--threads 1] [--repeats 15]`
//!
//! `generated` and `intact` are the catalogue's kernel when bonds may break and when they are held; `body` is a
//! body written by hand for the same traversal; `twin` is the same sum written with intrinsics from end to end
//! (AVX-512, one thread). `equal` says that body and twin, and generated and interpreted, agree to the bit;
//! `apart` is the largest difference of generated and twin, relative to the largest force.
use pdlang_models::registry;
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Breaking, Engine, Isa, Law, State, Traversal};
use pdlang_tests::twins::{bodies, scene, tapes};
use std::time::Duration;

struct Options {
    isas: Vec<Isa>,
    n: u32,
    threads: usize,
    repeats: usize,
}

fn main() {
    let options = match options() {
        Ok(o) => o,
        Err(message) => {
            eprintln!("{message}");
            std::process::exit(2);
        }
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build();
    pool.expect("threads can be started")
        .install(|| run(&options));
}

fn options() -> Result<Options, String> {
    let mut o = Options {
        isas: Isa::ALL.into_iter().filter(|i| i.available()).collect(),
        n: 50,
        threads: 1,
        repeats: 15,
    };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || {
            value
                .parse::<usize>()
                .map_err(|_| format!("{name} {value}: not a number"))
        };
        match name.as_str() {
            "--isa" => o.isas.retain(|i| i.name() == value),
            "--n" => o.n = number()? as u32,
            "--threads" => o.threads = number()?,
            "--repeats" => o.repeats = number()?.max(1),
            _ => {
                return Err(format!(
                    "unknown option {name}: --isa, --n, --threads, --repeats"
                ));
            }
        }
    }
    match o.isas.is_empty() {
        true => Err("this processor does not have that instruction set".into()),
        false => Ok(o),
    }
}

/// A law of the catalogue and the same law by hand.
struct Case {
    name: &'static str,
    params: Vec<f64>,
    body: fn() -> Law,
    body_params: Vec<f64>,
}

/// Far above any stretch of the scene: bonds are tested, none breaks.
const S0: f64 = 0.5;

fn cases() -> Vec<Case> {
    let pmb = || Law {
        spec: tapes::pmb(),
        kernel: Some(&bodies::PMB),
    };
    let lps = || Law {
        spec: tapes::lps(),
        kernel: Some(&bodies::LPS),
    };
    let case = |name, params: &[f64], body: fn() -> Law, body_params| Case {
        name,
        params: params.to_vec(),
        body,
        body_params,
    };
    vec![
        case("pmb", &[scene::K, S0], pmb, scene::pmb_params(S0)),
        case(
            "lps_frozen",
            &[scene::K, scene::G, S0],
            lps,
            scene::lps_params(S0),
        ),
        case("lps", &[scene::K, scene::G, S0], lps, scene::lps_params(S0)),
    ]
}

fn run(o: &Options) {
    let body = scene::body(o.n);
    let (n, threads, repeats) = (o.n, o.threads, o.repeats);
    println!(
        "{n}^3 nodes, horizon 3.015 dx, {threads} threads; ns per directed bond per thread, minimum of {repeats}"
    );
    println!(
        "law        traversal isa     generated intact   body   twin generated/twin interpreted equal apart"
    );
    for traversal in [Traversal::Lattice, Traversal::Cloud] {
        for case in cases() {
            for &isa in &o.isas {
                measure(o, &body, &case, traversal, isa);
            }
        }
    }
}

fn catalogue(name: &str) -> Law {
    let entry = registry::find(name).expect("the catalogue has the law");
    entry
        .compiled(3)
        .expect("it is compiled for three dimensions")
}

fn measure(o: &Options, body: &Body, case: &Case, traversal: Traversal, isa: Isa) {
    let engine = |law, params: &[f64]| scene::engine(body, law, params.to_vec(), traversal, isa);
    let mut generated = engine(catalogue(case.name), &case.params);
    let mut interpreted = engine(Law::interpreted(generated.spec().clone()), &case.params);
    let mut by_hand = engine((case.body)(), &case.body_params);
    let mut s = scene::displaced(&generated, body);
    let vector = isa == Isa::Avx512 && o.threads == 1;
    let mut twin = if vector {
        twin::Twin::new(o.n, case, traversal, &by_hand, &s)
    } else {
        None
    };
    let mut best = [f64::INFINITY; 5];
    for repeat in 0..o.repeats {
        best[0] = best[0].min(time(&mut generated, &mut s, Breaking::Armed));
        best[1] = best[1].min(time(&mut generated, &mut s, Breaking::Held));
        best[2] = best[2].min(time(&mut by_hand, &mut s, Breaking::Armed));
        if let Some(twin) = &mut twin {
            let start = cpu();
            twin.run();
            best[3] = best[3].min((cpu() - start).as_nanos() as f64);
        }
        if repeat < 3 {
            best[4] = best[4].min(time(&mut interpreted, &mut s, Breaking::Armed));
        }
    }
    let mut equal = generated.force() == interpreted.force();
    let mut apart = String::from("-");
    if let Some(twin) = &twin {
        equal &= twin.distance(&by_hand, body) == 0.0;
        apart = format!("{:.0e}", twin.distance(&generated, body));
    }
    let bonds = generated.report().bonds as f64;
    let column = |ns: f64| {
        if ns.is_finite() {
            format!("{:.3}", ns / bonds)
        } else {
            "-".into()
        }
    };
    let [all, intact, hand, own, tape] = best.map(column);
    let ratio = if best[3].is_finite() {
        format!("{:.2}", best[0] / best[3])
    } else {
        "-".into()
    };
    let traversal = format!("{traversal:?}").to_lowercase();
    println!(
        "{:10} {traversal:9} {:7} {all:>9} {intact:>6} {hand:>6} {own:>6} {ratio:>14} {tape:>11} {equal:5} {apart:>5}",
        case.name,
        isa.name()
    );
}

fn time(e: &mut Engine, s: &mut State, breaking: Breaking) -> f64 {
    let start = cpu();
    e.forces(s, breaking);
    (cpu() - start).as_nanos() as f64
}

/// CPU time of the process: other programs on the machine do not count.
#[cfg(target_os = "linux")]
fn cpu() -> Duration {
    #[repr(C)]
    struct Time {
        seconds: i64,
        nanoseconds: i64,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut Time) -> i32;
    }
    const PROCESS: i32 = 2;
    let mut t = Time {
        seconds: 0,
        nanoseconds: 0,
    };
    // SAFETY: the C library's function fills the two numbers.
    unsafe { clock_gettime(PROCESS, &mut t) };
    Duration::new(t.seconds as u64, t.nanoseconds as u32)
}

#[cfg(not(target_os = "linux"))]
fn cpu() -> Duration {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}

#[cfg(target_arch = "x86_64")]
mod twin {
    use super::*;
    use pdlang_tests::twins::{cloud, lattice};

    pub enum Twin {
        Lattice(bool, Box<lattice::Twin>),
        Cloud(bool, Box<cloud::Twin>),
    }

    impl Twin {
        pub fn new(
            n: u32,
            case: &Case,
            traversal: Traversal,
            e: &Engine,
            s: &State,
        ) -> Option<Twin> {
            let (pmb, n) = (case.name == "pmb", n as usize);
            let c = if pmb { case.body_params[0] } else { 0.0 };
            // Values of the reference stage, so that only the two timed sweeps differ.
            let start = e.named("reference");
            let fill = |a: &mut [Vec<f64>; 3],
                        b: &mut Vec<f64>,
                        q: &mut Vec<f64>,
                        to: &dyn Fn(usize) -> usize| {
                for node in 0..n * n * n {
                    for k in 0..3 {
                        a[k][to(node)] = s.u[k][e.slot(node)];
                    }
                    if let Some(start) = &start {
                        b[to(node)] = start[0][node];
                        q[to(node)] = start[1][node];
                    }
                }
            };
            Some(match traversal {
                Traversal::Cloud => {
                    let mut t = cloud::Twin::new(n, e.slots(), e.len(), c, S0);
                    fill(&mut t.u, &mut t.b, &mut t.q, &|node| e.slot(node));
                    Twin::Cloud(pmb, Box::new(t))
                }
                _ => {
                    let mut t = lattice::Twin::new(n, c, S0);
                    let slots: Vec<usize> = (0..n * n * n)
                        .map(|i| t.slot([i % n, i / n % n, i / n / n]))
                        .collect();
                    fill(&mut t.u, &mut t.b, &mut t.q, &|node| slots[node]);
                    Twin::Lattice(pmb, Box::new(t))
                }
            })
        }

        pub fn run(&mut self) {
            match self {
                Twin::Lattice(true, t) => t.pmb(),
                Twin::Lattice(false, t) => t.lps(),
                Twin::Cloud(true, t) => t.pmb(),
                Twin::Cloud(false, t) => t.lps(),
            }
        }

        /// Largest difference to the forces of an engine, relative to the largest force.
        pub fn distance(&self, e: &Engine, body: &Body) -> f64 {
            let n = (body.x.len() as f64).cbrt().round() as usize;
            let (mut miss, mut size) = (0.0f64, 0.0f64);
            for node in 0..body.x.len() {
                for a in 0..3 {
                    let f = match self {
                        Twin::Lattice(_, t) => {
                            t.f[a][t.slot([node % n, node / n % n, node / n / n])]
                        }
                        Twin::Cloud(_, t) => t.f[a][e.slot(node)],
                    };
                    miss = miss.max((f - e.force()[a][e.slot(node)]).abs());
                    size = size.max(f.abs());
                }
            }
            miss / size
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod twin {
    use super::*;

    /// No twin on this processor.
    pub enum Twin {}

    impl Twin {
        pub fn new(_: u32, _: &Case, _: Traversal, _: &Engine, _: &State) -> Option<Twin> {
            None
        }
        pub fn run(&mut self) {}
        pub fn distance(&self, _: &Engine, _: &Body) -> f64 {
            0.0
        }
    }
}
