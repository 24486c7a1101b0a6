//! The catalogue is what it says.

use pdlang_models::registry::CATALOGUE;

#[test]
fn every_law_is_correct_and_bears_the_name_of_its_file() {
    for entry in CATALOGUE {
        let law = entry
            .law()
            .unwrap_or_else(|e| panic!("{}: {e:?}", entry.name));
        assert_eq!(law.name, entry.name);
        assert!(
            !law.title.is_empty() && !law.cites.is_empty(),
            "{} lacks its paper",
            law.name
        );
    }
}
