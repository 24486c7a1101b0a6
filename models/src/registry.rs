//! The catalogue: every law by its name, as text and, where it is compiled in, as machine code.

use pdlang::diag::Diagnostic;
use pdlang::{front, ir};
use pdlang_runtime::engine::Law;
use pdlang_runtime::kernel::CompiledLaw;

/// The catalogue's kernels: a module per law.
pub mod laws {
    pdlang_macros::include_model!(
        "laws/pmb.pd",
        "laws/pmb_compression.pd",
        "laws/gpmb.pd",
        "laws/lps.pd",
        "laws/lps_frozen.pd",
        "laws/heat.pd",
        "laws/heat_state.pd",
        "laws/thermo_pmb.pd",
        "laws/thermo_lps.pd",
        "laws/lps_plastic.pd",
        "laws/lps_viscoelastic.pd",
        "laws/correspondence.pd",
        "laws/correspondence_stabilised.pd",
        "laws/correspondence_svk.pd",
        "laws/absorbing.pd",
        "laws/lamina.pd",
        "laws/laminate.pd",
        "laws/solid.pd"
    );

    /// Those that are used most for small displacements, linearised.
    pub mod linearised {
        pdlang_macros::include_model!(linearised "laws/pmb.pd", "laws/lps.pd");
    }
}

/// A law of the catalogue.
#[derive(Clone, Copy)]
pub struct Entry {
    pub name: &'static str,
    /// The law in the language.
    pub text: &'static str,
    /// Its kernels.
    pub kernels: &'static CompiledLaw,
    /// Those for small displacements, where they are compiled in.
    pub linearised: Option<&'static CompiledLaw>,
}

macro_rules! catalogue {
    ($($name:ident $(and $form:ident)?),* $(,)?) => {
        &[$(Entry {
            name: stringify!($name),
            text: include_str!(concat!("../laws/", stringify!($name), ".pd")),
            kernels: &laws::$name::LAW,
            linearised: form!($name $($form)?),
        }),*]
    };
}

macro_rules! form {
    ($name:ident) => {
        None
    };
    ($name:ident linearised) => {
        Some(&laws::linearised::$name::LAW)
    };
}

/// In the order in which the tables list them.
pub const CATALOGUE: &[Entry] = catalogue![
    pmb and linearised,
    pmb_compression,
    gpmb,
    lps and linearised,
    lps_frozen,
    heat,
    heat_state,
    thermo_pmb,
    thermo_lps,
    lps_plastic,
    lps_viscoelastic,
    correspondence,
    correspondence_stabilised,
    correspondence_svk,
    absorbing,
    lamina,
    laminate,
    solid,
];

/// The law of this name.
pub fn find(name: &str) -> Option<&'static Entry> {
    CATALOGUE.iter().find(|e| e.name == name)
}

/// All names.
pub fn names() -> Vec<&'static str> {
    CATALOGUE.iter().map(|e| e.name).collect()
}

impl Entry {
    /// The law as the checks leave it.
    ///
    /// # Errors
    /// The diagnostics of a text that does not hold exactly one correct law.
    pub fn law(&self) -> Result<ir::Law, Vec<Diagnostic>> {
        let checked = front::file(self.text);
        match checked.laws.into_iter().next() {
            Some(law) if !checked.diagnostics.iter().any(Diagnostic::is_error) => Ok(law),
            _ => Err(checked.diagnostics),
        }
    }

    /// The law's file, as its page in `docs/laws` links to it.
    pub fn link(&self) -> String {
        format!("../../models/laws/{}.pd", self.name)
    }

    /// The drawing of its waves, as its page links to it.
    pub fn picture(&self) -> String {
        format!("../img/laws/{}.svg", self.name)
    }

    /// Which of its kernels are compiled in, as a sentence.
    pub fn kernels_said(&self) -> String {
        let general = dims(self.kernels);
        match self.linearised {
            Some(small) => format!(
                "Kernels are compiled in {general}, and for small displacements in {}.",
                dims(small)
            ),
            None => format!(
                "Kernels are compiled in {general}, none of them for small displacements: without one, a law runs interpreted."
            ),
        }
    }

    /// The law at a dimension, with its machine code.
    pub fn compiled(&self, dim: usize) -> Option<Law> {
        Law::compiled(self.kernels, dim).ok()
    }

    /// The same for small displacements.
    pub fn compiled_linearised(&self, dim: usize) -> Option<Law> {
        Law::compiled(self.linearised?, dim).ok()
    }
}

fn dims(law: &CompiledLaw) -> String {
    let dims: Vec<String> = law.kernels.iter().map(|k| format!("{}D", k.dim)).collect();
    dims.join(", ")
}
