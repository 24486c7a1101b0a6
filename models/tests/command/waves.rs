//! `pdlang dispersion`.

use super::{bytes, command, folder, mentions, pdlang, shown, write};

#[test]
fn dispersion_shows_branches_moduli_and_modes_without_energy() {
    let line = [
        "dispersion",
        "correspondence_stabilised",
        "--flavour",
        "bar",
        "--param",
        "E = 1 Pa",
        "--param",
        "Gs=0,1",
        "--horizon",
        "1",
        "--spacing",
        "1 m",
        "--density",
        "1",
        "--points",
        "4",
    ];
    let text = pdlang(&line, 0);
    // Omega = |sin k| without stabilisation, and nothing at k = pi; 2 sqrt(2) at Gs = 1 there.
    let says = [
        "correspondence_stabilised, bar, E = 1, Gs = 0, influence constant, horizon 1 dx",
        "modes without energy in this direction, k dx/pi: (1)",
        "largest frequency in the Brillouin zone: 1.000000e0 rad/s at k dx/pi = (0.5)",
        "largest frequency in the Brillouin zone: 2.828427e0 rad/s at k dx/pi = (1)",
        "modes without energy: none",
    ];
    mentions(&text, &says);
    let soft = [
        "dispersion",
        "gpmb",
        "--influence",
        "softened(p = 10, eps = 0.5 mm)",
        "--points",
        "2",
    ];
    mentions(
        &pdlang(&soft, 0),
        &[
            "warning: constants of this lattice over the declared ones: K 0.40, G 0.20",
            "gpmb, 3d",
            "T2",
        ],
    );
    let mended = [&soft[..], &["--constants", "lattice"]].concat();
    // The sum over the lattice mends K, not what a cubic lattice makes of G.
    let text = pdlang(&mended, 0);
    assert!(
        text.contains("ones: G 0.50, G along diagonals 1.75") && !text.contains("K 0."),
        "{text}"
    );
    mentions(
        &pdlang(&["dispersion", "heat", "--dim", "2", "--points", "2"], 0),
        &["decay [1/s]"],
    );
}

#[test]
fn dispersion_as_json_and_as_pictures() {
    let dir = folder("dispersion");
    let [svg, png] = ["a.svg", "a.png"].map(|name| shown(&dir.join(name)));
    let line = |plot: &str| {
        let arguments = [
            "dispersion",
            "lps",
            "pmb",
            "--flavour",
            "plane_strain",
            "--param",
            "K = 3 GPa",
            "--horizon",
            "2,3",
            "--direction",
            "30 deg",
            "--points",
            "3",
            "--json",
            "--plot",
            plot,
        ];
        let done = command(&arguments).output().expect("the command starts");
        assert_eq!(
            done.status.code(),
            Some(0),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        serde_json::from_slice::<serde_json::Value>(&done.stdout).expect("JSON")
    };
    let pages = line(&svg);
    assert_eq!(line(&png), pages);
    let pages = pages.as_array().expect("pages");
    assert_eq!(pages.len(), 4);
    for page in pages {
        assert_eq!(page["parameters"]["K"], 3e9);
        let rows = page["rows"].as_array().expect("rows");
        assert_eq!(
            (
                rows.len(),
                rows[2]["lattice"].as_array().expect("branches").len()
            ),
            (3, 2)
        );
        let n: Vec<f64> = serde_json::from_value(page["direction"].clone()).expect("a direction");
        assert!((n[1] / n[0] - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12, "{n:?}");
        let (own, free) = (
            &page["largest"]["frequency"],
            &page["free_block"]["frequency"],
        );
        assert!(free.as_f64().unwrap() > 0.9 * own.as_f64().unwrap());
    }
    let drawn = String::from_utf8(bytes(&svg)).expect("SVG");
    mentions(
        &drawn,
        &["<svg", "horizon 2 dx", "horizon 3 dx", "lps", "pmb"],
    );
    assert!(bytes(&png).starts_with(b"\x89PNG") && bytes(&png).len() > 10_000);
}

#[test]
fn dispersion_refuses_what_makes_no_waves() {
    let file = write(folder("no-waves").join("none.pd"), "fn square(a) = a^2");
    for (arguments, says) in [
        (&["nothing"][..], &["there is no law `nothing`"][..]),
        (&[&file], &["holds no law"]),
        (&["pmb", "--direction", "0,0,0"], &["has no length"]),
        (
            &["pmb", "--direction", "1,0,0,1"],
            &["is not one of 3 dimensions"],
        ),
        (
            &["pmb", "--dim", "2", "--direction", "0,0,1"],
            &["is not one of 2 dimensions"],
        ),
        (
            &["pmb", "--direction", "30 deg"],
            &["the direction is `30 deg`"],
        ),
        (
            &["pmb", "--dim", "2", "--direction", "30 mm"],
            &["the angle is `30 mm`"],
        ),
        (
            &["pmb", "--horizon", "0.5"],
            &["0.5 spacings", "no neighbours"],
        ),
        (&["pmb", "--horizon", "-3"], &["no neighbours"]),
        (&["pmb", "--horizon", "3 mm"], &["a number of spacings"]),
        (&["pmb", "--horizon", "nan"], &["a number of spacings"]),
        (
            &["pmb", "--horizon", "300"],
            &["too large for a stencil in 3 dimensions"],
        ),
        (
            &["lamina", "--flavour", "3d"],
            &["`lamina` is not for 3d", "it is for plane_stress"],
        ),
        (
            &["lps_plastic", "--dim", "1"],
            &["is not for 1 dimensions", "plane_strain, 3d"],
        ),
        (&["pmb", "--param", "Q=1"], &["has no parameter `Q`"]),
        (&["pmb", "--param", "K=1,-1"], &["outside of the bounds"]),
        (
            &["pmb", "--param", "K = 3 mm"],
            &["K has another unit than m", "`K` of `pmb` is in Pa"],
        ),
        (
            &["pmb", "--spacing", "0"],
            &["the spacing is 0", "a length above 0"],
        ),
        (&["pmb", "--spacing", "1 kg"], &["a length above 0"]),
        (&["pmb", "--density", "-1"], &["the density is -1"]),
        (&["gpmb", "--influence", "nope"], &["nope"]),
        (&["absorbing"], &["its waves have no real frequency"]),
        (
            &["pmb", "--plot", "a.gif"],
            &["cannot be a `.gif`", ".svg or .png"],
        ),
        (
            &[
                "lps",
                "--param",
                "K=1,2,3,4,5,6,7",
                "--param",
                "G=1,2,3,4,5,6,7",
            ],
            &["49 series"],
        ),
    ] {
        let line = [&["dispersion"], arguments].concat();
        mentions(&pdlang(&line, 1), says);
    }
    for wrong in [
        ["pmb", "--points", "0"],
        ["pmb", "--curves", "all"],
        ["pmb", "--flavour", "4d"],
    ] {
        pdlang(&[&["dispersion"], &wrong[..]].concat(), 2);
    }
    pdlang(&["dispersion"], 2);
}
