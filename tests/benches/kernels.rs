//! Generated kernels against their hand-written twins: ns per directed bond and thread, minimum of many
//! interleaved runs, CPU time. `cargo bench --bench kernels -- [--isa avx512] [--n 50] [--threads 1] [--repeats 15]`
//!
//! `generated` and `intact` are the catalogue's kernel when bonds may break and when they are held; `body` is a
//! body written by hand for the same traversal; `twin` is the same sum written with intrinsics from end to end
//! (AVX-512, one thread). `equal` says that body and twin, and generated and interpreted, agree to the bit;
//! `apart` is the largest difference of generated and twin, relative to the largest force.
use pdlang_models::bench::clock::cpu;
use pdlang_models::bench::scene;
use pdlang_models::bench::twin::{Sums, Twin};
use pdlang_models::registry;
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Breaking, Engine, Isa, Law, State, Traversal};
use pdlang_tests::twins::{bodies, tapes};

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
    let engine = |law, params: &[f64]| {
        scene::engine(body, law, params.to_vec(), traversal, isa).expect("the scene is valid")
    };
    let mut generated = engine(catalogue(case.name), &case.params);
    let mut interpreted = engine(Law::interpreted(generated.spec().clone()), &case.params);
    let mut by_hand = engine((case.body)(), &case.body_params);
    let mut s = scene::displaced(&generated, body);
    let vector = isa == Isa::Avx512 && o.threads == 1;
    // Values of the reference stage, so that only the two timed sweeps differ.
    let sums = match by_hand.named("reference") {
        Some(values) => Sums::Lps([values[0].clone(), values[1].clone()]),
        None => Sums::Pmb(case.body_params[0]),
    };
    let mut twin = match vector {
        true => Twin::new(body, &sums, S0, &by_hand, &s),
        false => None,
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
        equal &= twin.distance(&by_hand) == 0.0;
        apart = format!("{:.0e}", twin.distance(&generated));
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
