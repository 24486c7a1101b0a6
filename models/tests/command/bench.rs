//! `pdlang bench`.

use super::{bytes, folder, mentions, pdlang, shown};

/// Rows of `pdlang bench kernels` on a small cube.
fn kernels(more: &[&str]) -> Vec<serde_json::Value> {
    let line = [
        &[
            "bench",
            "kernels",
            "--size",
            "7",
            "--repeats",
            "2",
            "--json",
        ],
        more,
    ]
    .concat();
    serde_json::from_str(&pdlang(&line, 0)).expect("an array")
}

#[test]
fn kernels_are_timed_beside_their_twins() {
    let rows = kernels(&[]);
    let named: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {} {}", row["law"], row["body"], row["traversal"]).replace('"', ""))
        .collect();
    let bodies = ["lattice lattice", "cloud cloud", "jittered cloud"];
    let laws = [
        "pmb",
        "pmb linearised",
        "lps",
        "lps linearised",
        "heat",
        "correspondence_stabilised",
    ];
    let all = laws.map(|law| bodies.map(|body| format!("{law} {body}")));
    assert_eq!(named, all.concat());
    for row in &rows {
        let number = |key: &str| row[key].as_f64();
        for key in ["ns_per_bond", "wall_ns_per_bond", "bytes_per_bond"] {
            assert!(number(key).is_some_and(|n| n > 0.0), "{key} of {row}");
        }
        assert_eq!(
            (&row["dimension"], &row["precision"]),
            (&3.into(), &"f64".into())
        );
        assert_eq!(row["threads"], 1);
        let linearised = row["law"]
            .as_str()
            .is_some_and(|l| l.ends_with("linearised"));
        let twin = row["isa"] == "avx512" && !linearised;
        assert_eq!(
            number("twin_ns_per_bond").is_some_and(|n| n > 0.0),
            twin,
            "{row}"
        );
        assert_eq!(row["twin_ns_per_bond"].is_null(), !twin, "{row}");
    }
    // Twins are for one thread and for one instruction set.
    for more in [["--threads", "2"], ["--isa", "scalar"]] {
        assert!(
            kernels(&more)
                .iter()
                .all(|row| row["twin_ns_per_bond"].is_null())
        );
    }
    let table = pdlang(&["bench", "kernels", "--size", "5", "--repeats", "1"], 0);
    mentions(
        &table,
        &["twin_ns_per_bond", "correspondence_stabilised", "jittered"],
    );
}

#[test]
fn scenes_are_timed_with_and_without_what_they_may_leave_out() {
    let line = [
        "bench",
        "scenes",
        "--size",
        "6",
        "--steps",
        "2",
        "--repeats",
        "1",
    ];
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&pdlang(&[&line[..], &["--json"]].concat(), 0)).expect("an array");
    let named: Vec<(&str, &str)> = rows
        .iter()
        .filter_map(|row| Some((row["what"].as_str()?, row["law"].as_str()?)))
        .collect();
    let both = [
        "breaking, with masks",
        "neighbour lists",
        "general kinematics",
        "general kinematics of a cloud",
        "loops over bonds",
        "nodes at rest",
        "energy at every step",
        "volume correction",
        "contact",
        "interpreter",
        "a second material",
        "eight horizons",
    ];
    let expected: Vec<(&str, &str)> = ["pmb", "lps"]
        .iter()
        .flat_map(|law| both.iter().map(move |what| (*what, *law)))
        .chain([
            ("heat", "thermo_pmb"),
            ("heat", "thermo_lps"),
            ("general kinematics, interpreted", "thermo_pmb"),
            ("general kinematics, interpreted", "thermo_lps"),
            ("gradient and stress", "correspondence_stabilised"),
            ("history", "lps_viscoelastic"),
            ("history", "lps_plastic"),
            ("surface correction", "solid"),
        ])
        .collect();
    assert_eq!(named, expected);
    for row in &rows {
        for key in ["nodes", "with_ns_per_bond", "without_ns_per_bond", "ratio"] {
            let number = row[key].as_f64();
            assert!(number.is_some_and(|n| n > 0.0), "{key} of {row}");
        }
    }
}

#[test]
fn growth_is_timed_and_drawn() {
    let plot = shown(&folder("growth").join("growth.svg"));
    let line = "bench growth --nodes 1000 --seconds 0 --json --plot";
    let words: Vec<&str> = line.split(' ').chain([plot.as_str()]).collect();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&pdlang(&words, 0)).expect("an array");
    for row in &rows {
        for key in ["nodes", "bonds", "ns_per_bond", "to_median"] {
            assert!(row[key].as_f64().is_some_and(|n| n > 0.0), "{key} of {row}");
        }
    }
    let cube = |row: &&serde_json::Value| {
        row["law"] == "lps" && row["case"] == "cube" && row["nodes"] == 1000
    };
    let horizons: Vec<f64> = rows
        .iter()
        .filter(cube)
        .filter_map(|row| row["horizon_dx"].as_f64())
        .collect();
    assert_eq!(horizons, [3.015, 1.5, 2.0, 3.015, 4.0, 5.0, 6.0, 8.0]);
    let bonds = |case: &str| {
        let row = rows.iter().find(|row| row["case"] == case);
        row.and_then(|row| row["bonds"].as_u64())
    };
    assert!(bonds("ball") > bonds("rod") && bonds("rod") > bonds("sheet"));
    mentions(
        &String::from_utf8_lossy(&bytes(&plot)),
        &["<svg", "ns per directed bond", "lps, jittered"],
    );
    let wrong = ["bench", "growth", "--seconds", "nan"];
    mentions(&pdlang(&wrong, 1), &["--seconds"]);
}

#[test]
fn convolutions_are_timed_beside_bonds() {
    let line = "bench convolution --size 6 --repeats 1 --json";
    let words: Vec<&str> = line.split(' ').collect();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&pdlang(&words, 0)).expect("an array");
    assert_eq!(rows.len(), 4 * 7);
    for row in &rows {
        for key in [
            "bonds_per_node",
            "lattice_ns_per_node",
            "convolution_ns_per_node",
            "wall_ratio",
            "lattice_bytes_per_node",
        ] {
            assert!(row[key].as_f64().is_some_and(|n| n > 0.0), "{key} of {row}");
        }
    }
    // PMB: three transforms of the displacement and three back.
    assert_eq!(rows[0]["transforms"], 6);
}

#[test]
fn studies_are_named() {
    let unknown = ["bench", "accuracy", "--only", "paper-pml-3a-all"];
    let said = pdlang(&unknown, 1);
    mentions(
        &said,
        &[
            "there is no study `paper-pml-3a-all`",
            "paper-pml-3a-energy",
        ],
    );
}

/// One length of wave, as it stands in docs/waves.md.
#[test]
fn ends_are_compared_on_packets_of_waves() {
    let line = "bench waves --json --only";
    let words = |case| line.split(' ').chain([case]).collect::<Vec<&str>>();
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&pdlang(&words("straight on, 6"), 0)).expect("an array");
    let page = include_str!("../../../docs/waves.md");
    let cells = |start: &str| -> Vec<&str> {
        let line = page.lines().find(|line| line.starts_with(start));
        let line = line.expect("the table").trim_matches('|');
        line.split('|').map(str::trim).collect()
    };
    let (ends, known) = (cells("| length in spacings |"), cells("| 6 |"));
    assert_eq!(rows.len(), known.len() - 1, "{rows:?}");
    for row in &rows {
        assert_eq!(row["case"], "longitudinal, straight on, 6");
        let column = ends.iter().position(|end| row["end"] == *end);
        let known = known[column.expect("a column of the end")];
        let known: f64 = match known.strip_suffix(" %") {
            Some(percent) => percent.parse::<f64>().expect("a number") / 100.0,
            None => known.parse().expect("a number"),
        };
        let left = row["left"].as_f64().expect("a number");
        // Two digits.
        assert!((left / known - 1.0).abs() < 0.05, "{row}: {known}");
    }
    mentions(
        &pdlang(&words("sideways"), 1),
        &[
            "there is no case `sideways`",
            "all angles",
            "transverse, 45",
        ],
    );
}
