// One script of runs, for two targets: natively it is compared with (or writes) the stored numbers, in the browser the
// same numbers must come out to tolerance. Included by `tests/it/golden.rs` and `tests/wasm.rs`.

use cutflow::session::{Command, Session, Value};

/// Energies of a few runs: name, step, J.
pub fn runs() -> Vec<(String, usize, f64)> {
    let mut rows = Vec::new();
    for (sample, changes, steps) in [
        // Off the middle: a plane through vertices leaves their side to rounding.
        ("ball", vec![("dirichlet", 10.0), ("offset", 3.0)], 8),
        ("rounded_box", vec![("angle", 50.0)], 6),
        ("ball", vec![("hencky", 3000.0), ("dirichlet", 0.0), ("offset", -11.0)], 8),
    ] {
        let mut session = Session::new();
        session.handle(Command::OpenSample { name: sample.into() });
        // Decimation has ties on surfaces as even as these, and rounding breaks them differently on different targets.
        session.handle(Command::SetParameter { id: "coarse".into(), value: Value::Truth(false) });
        for (id, value) in changes {
            let value = Value::Number(value);
            session.handle(Command::SetParameter { id: id.into(), value });
        }
        for _ in 0..steps {
            session.handle(Command::Step);
        }
        for row in session.history() {
            rows.push((sample.to_owned(), row.step, row.total));
        }
    }
    rows
}

/// Reads the stored numbers.
pub fn stored(text: &str) -> Vec<(String, usize, f64)> {
    text.lines()
        .map(|line| {
            let mut words = line.split_whitespace();
            let mut next = || words.next().unwrap();
            (next().to_owned(), next().parse().unwrap(), next().parse().unwrap())
        })
        .collect()
}

/// Largest relative difference between two lists of rows of the same names and steps.
pub fn difference(a: &[(String, usize, f64)], b: &[(String, usize, f64)]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest: f64, (a, b)| {
        assert_eq!((&a.0, a.1), (&b.0, b.1));
        largest.max((a.2 - b.2).abs() / b.2.abs())
    })
}
