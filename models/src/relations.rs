//! Laws that are others in a special case. Pages name them, and the tests compare their forces.

use pdlang::ir::Flavour;

/// Values of parameters, by name [SI].
pub type Values = &'static [(&'static str, f64)];

/// `law` is `of` in a special case.
pub struct Relation {
    pub law: &'static str,
    pub of: &'static str,
    /// When: the end of the sentence, with the paper that says so.
    pub when: &'static str,
    /// The values of `law`, and of `of`, in that case; `None` where a flavour has no such case. What both have and neither
    /// names is the same in both.
    pub case: fn(Flavour) -> Option<(Values, Values)>,
    /// Influence functions of both, as a scene writes them; `None`: what the law says.
    pub influences: (Option<&'static str>, Option<&'static str>),
    /// Only where families are whole and constants are sums over the lattice.
    pub whole: bool,
    /// Only to first order in the displacements.
    pub small: bool,
}

impl Relation {
    /// One sentence, in which laws are links to their pages.
    pub fn sentence(&self) -> String {
        let name = |law: &str| format!("[`{law}`]({law}.md)");
        format!("{} is {} {}.", name(self.law), name(self.of), self.when)
    }
}

const PLAIN: Relation = Relation {
    law: "",
    of: "",
    when: "",
    case: |_| Some((&[], &[])),
    influences: (None, None),
    whole: false,
    small: false,
};

pub const RELATIONS: &[Relation] = &[
    Relation {
        law: "gpmb",
        of: "pmb",
        when: "with `omega_g = constant`",
        influences: (Some("constant"), None),
        ..PLAIN
    },
    Relation {
        law: "pmb_compression",
        of: "gpmb",
        when: "with the same influence function, and breaks like it at `alpha = 0`",
        influences: (Some("gaussian(l = 1 mm)"), Some("gaussian(l = 1 mm)")),
        ..PLAIN
    },
    // The moduli of the tests: K = 14.9 GPa, so that G is 3 K/5, and 3 K/8 in plane stress.
    Relation {
        law: "lps",
        of: "gpmb",
        when: "at a Poisson's ratio of 1/4 (1/3 in plane stress) with `omega = omega_g/x`, where families are whole; not in bars under uniaxial stress (Seleson and Parks 2011, section 3.2)",
        case: |flavour| match flavour {
            Flavour::Bar => None,
            Flavour::PlaneStress => Some((&[("K", 1e10), ("G", 3.75e9)], &[("K", 1e10)])),
            _ => Some((&[("K", 1e10), ("G", 6e9)], &[("K", 1e10)])),
        },
        influences: (Some("inverse"), Some("constant")),
        whole: true,
        ..PLAIN
    },
    Relation {
        law: "lps_frozen",
        of: "lps",
        when: "until a bond breaks",
        ..PLAIN
    },
    Relation {
        law: "lps_plastic",
        of: "lps",
        when: "within the yield surface",
        case: |_| Some((&[("tauy", 1e30)], &[])),
        ..PLAIN
    },
    Relation {
        law: "lps_viscoelastic",
        of: "lps",
        when: "where nothing relaxes, `share = 0`",
        case: |_| Some((&[("share", 0.0)], &[])),
        ..PLAIN
    },
    Relation {
        law: "thermo_pmb",
        of: "pmb",
        when: "with `omega = constant`, where nothing expands, `alpha = 0`",
        case: |_| Some((&[("alpha", 0.0)], &[])),
        ..PLAIN
    },
    Relation {
        law: "thermo_lps",
        of: "lps",
        when: "where nothing expands, `alpha = 0`",
        case: |_| Some((&[("alpha", 0.0)], &[])),
        ..PLAIN
    },
    Relation {
        law: "correspondence_stabilised",
        of: "correspondence",
        when: "without stabilisation, `Gs = 0`",
        case: |_| Some((&[("Gs", 0.0)], &[])),
        ..PLAIN
    },
    Relation {
        law: "correspondence_svk",
        of: "correspondence",
        when: "to first order in the displacements",
        small: true,
        ..PLAIN
    },
    Relation {
        law: "absorbing",
        of: "correspondence",
        when: "where nothing is damped, `phi = 0`",
        ..PLAIN
    },
    Relation {
        law: "heat_state",
        of: "heat",
        when: "at `Gs = 1`, where families are whole",
        case: |_| Some((&[("Gs", 1.0)], &[])),
        whole: true,
        ..PLAIN
    },
];

/// Those that a law has a part in, as what is special first.
pub fn of(law: &str) -> impl Iterator<Item = &'static Relation> {
    let special = RELATIONS.iter().filter(move |r| r.law == law);
    special.chain(RELATIONS.iter().filter(move |r| r.of == law))
}
