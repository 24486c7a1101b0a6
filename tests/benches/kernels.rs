//! Generated kernels against their hand-written twins: ns per directed bond and thread, minimum of many
//! interleaved runs, CPU time. `cargo bench --bench kernels -- [--isa avx512] [--n 50] [--threads 1] [--repeats 15]`
//!
//! The kernels of [`pdlang_tests::twins::bodies`] stand for generated code. The twins exist for AVX-512 only;
//! where they can run, the results are compared bit by bit first.
use pdlang_runtime::engine::{Breaking, Engine, Isa, State, Traversal};
use pdlang_runtime::kernel::CompiledKernel;
use pdlang_runtime::spec::Spec;
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

/// A law with its hand-made kernel.
struct Case {
    name: &'static str,
    spec: Spec,
    kernel: &'static CompiledKernel,
    params: Vec<f64>,
}

fn run(o: &Options) {
    let body = scene::body(o.n);
    println!(
        "{}^3 nodes, horizon 3.015 dx, {} threads; ns per directed bond per thread, minimum of {}",
        o.n, o.threads, o.repeats
    );
    println!("law  traversal  isa      breaking   held   twin  ratio  interpreted  bit-equal");
    for traversal in [Traversal::Lattice, Traversal::Cloud] {
        for case in [
            Case {
                name: "pmb",
                spec: tapes::pmb(),
                kernel: &bodies::PMB,
                params: scene::pmb_params(0.5),
            },
            Case {
                name: "lps",
                spec: tapes::lps(),
                kernel: &bodies::LPS,
                params: scene::lps_params(0.5),
            },
        ] {
            for &isa in &o.isas {
                measure(o, &body, &case, traversal, isa);
            }
        }
    }
}

fn measure(
    o: &Options,
    body: &pdlang_runtime::body::Body,
    case: &Case,
    traversal: Traversal,
    isa: Isa,
) {
    let engine = |kernel| {
        scene::engine(
            body,
            case.spec.clone(),
            kernel,
            case.params.clone(),
            traversal,
            isa,
        )
    };
    let (mut compiled, mut interpreted) = (engine(Some(case.kernel)), engine(None));
    let mut s = scene::displaced(&compiled, body);
    let mut twin = if isa == Isa::Avx512 && o.threads == 1 {
        twin::Twin::new(o.n, case, traversal, &compiled, &s)
    } else {
        None
    };
    let bonds = compiled.report().bonds as f64;
    let mut best = [f64::INFINITY; 4];
    for repeat in 0..o.repeats {
        best[0] = best[0].min(time(&mut compiled, &mut s, Breaking::Armed));
        best[1] = best[1].min(time(&mut compiled, &mut s, Breaking::Held));
        if let Some(twin) = &mut twin {
            let start = cpu();
            twin.run();
            best[2] = best[2].min((cpu() - start).as_nanos() as f64);
        }
        if repeat < 3 {
            best[3] = best[3].min(time(&mut interpreted, &mut s, Breaking::Held));
        }
    }
    let mut equal = compiled.force() == interpreted.force();
    if let Some(twin) = &twin {
        equal &= twin.equals(&compiled, body);
    }
    let [armed, held, hand, tape] = best.map(|ns| ns / bonds);
    let (hand, ratio) = match hand.is_finite() {
        true => (format!("{hand:6.3}"), format!("{:6.3}", armed / hand)),
        false => ("     -".into(), "     -".into()),
    };
    let traversal = format!("{traversal:?}").to_lowercase();
    println!(
        "{:4} {traversal:9}  {:7} {armed:9.3} {held:6.3} {hand} {ratio} {tape:12.2}  {equal}",
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
    use pdlang_runtime::body::Body;
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
            let c = if pmb { case.params[0] } else { 0.0 };
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
                    let mut t = cloud::Twin::new(n, e.slots(), e.len(), c, 0.5);
                    fill(&mut t.u, &mut t.b, &mut t.q, &|node| e.slot(node));
                    Twin::Cloud(pmb, Box::new(t))
                }
                _ => {
                    let mut t = lattice::Twin::new(n, c, 0.5);
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

        pub fn equals(&self, e: &Engine, body: &Body) -> bool {
            let n = (body.x.len() as f64).cbrt().round() as usize;
            (0..body.x.len()).all(|node| {
                (0..3).all(|a| {
                    let f = match self {
                        Twin::Lattice(_, t) => {
                            t.f[a][t.slot([node % n, node / n % n, node / n / n])]
                        }
                        Twin::Cloud(_, t) => t.f[a][e.slot(node)],
                    };
                    f == e.force()[a][e.slot(node)]
                })
            })
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod twin {
    use super::*;
    use pdlang_runtime::body::Body;

    /// No twin on this processor.
    pub enum Twin {}

    impl Twin {
        pub fn new(_: u32, _: &Case, _: Traversal, _: &Engine, _: &State) -> Option<Twin> {
            None
        }
        pub fn run(&mut self) {}
        pub fn equals(&self, _: &Engine, _: &Body) -> bool {
            true
        }
    }
}
