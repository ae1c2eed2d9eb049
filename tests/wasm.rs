//! The engine as the browser runs it.

#![cfg(target_arch = "wasm32")]

#[allow(clippy::unwrap_used, reason = "a test that meets what it does not expect fails")]
mod runs;

use wasm_bindgen_test::{wasm_bindgen_test, wasm_bindgen_test_configure};

wasm_bindgen_test_configure!(run_in_dedicated_worker);

#[wasm_bindgen_test]
fn runs_are_those_of_the_native_engine() {
    let stored = runs::stored(include_str!("golden/runs.txt"));
    // Sums are grouped differently by 128-bit SIMD; eight steps of descent do not spread that far.
    let difference = runs::difference(&runs::runs(), &stored);
    assert!(difference < 1e-6, "{difference:e}");
}

#[wasm_bindgen_test]
fn a_bad_file_is_an_error_with_three_parts_and_no_panic() {
    let mut session = cutflow::session::Session::new();
    for bytes in ["", "v 1 2", "f 1 2 3", "v nan 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n"] {
        let events = session.open("bad.obj", bytes.as_bytes());
        let texts = events.iter().find_map(|event| match event {
            cutflow::session::Event::Error { what, place, what_to_do, .. } => {
                Some([what, place, what_to_do])
            }
            _ => None,
        });
        assert!(texts.is_some_and(|texts| texts.iter().all(|text| !text.is_empty())));
    }
}
