//! Stored numbers of whole runs.

#[path = "../runs.rs"]
mod runs;

#[test]
fn runs_give_their_stored_energies() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/runs.txt");
    let rows = runs::runs();
    assert!(rows.windows(2).all(|w| w[0].0 != w[1].0 || w[1].2 <= w[0].2), "a run rises: {rows:?}");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        let text: String =
            rows.iter().map(|(name, step, total)| format!("{name} {step} {total:?}\n")).collect();
        #[expect(clippy::disallowed_methods, reason = "asked to write the stored numbers")]
        std::fs::write(path, text).unwrap();
        return;
    }
    let stored = runs::stored(include_str!("../golden/runs.txt"));
    // The processor's own instructions may round sums differently; runs of a few steps do not spread that far.
    let difference = runs::difference(&rows, &stored);
    assert!(difference < 1e-7, "{difference:e}: UPDATE_GOLDEN=1 stores new numbers");
}
