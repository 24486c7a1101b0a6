//! Every law of the catalogue says what it gives in a case that can be worked out by hand, and gives it.

use pdlang::probe;
use pdlang_models::registry::CATALOGUE;

#[test]
fn every_law_of_the_catalogue_is_probed_and_right() {
    for entry in CATALOGUE {
        let law = entry
            .law()
            .unwrap_or_else(|e| panic!("{}: {e:?}", entry.name));
        assert!(!law.probes.is_empty(), "{} has no probe", entry.name);
        let forces = law.probes.iter().flat_map(|p| &p.expectations);
        let answers = forces.filter(|e| e.text.starts_with("force") || e.text.starts_with("rate"));
        assert!(
            answers.count() > 0,
            "no probe of {} expects a force",
            entry.name
        );
        let findings = probe::findings(&law);
        let shown: Vec<String> = findings
            .iter()
            .map(|d| d.render(entry.text, entry.name, false))
            .collect();
        assert!(findings.is_empty(), "{}", shown.join("\n"));
    }
}
