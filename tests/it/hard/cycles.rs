//! Load, run, reset, again and again: memory stays flat.

use cutflow::session::{Command, Session, Value};

use super::documents;
use super::sound::KINDS;

/// Memory that this process holds, in bytes; `None` where the system does not tell.
pub fn resident() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.split_whitespace().next()?.parse::<usize>().ok()? * 1024)
}

/// One cycle in a session that lives on: a mesh, some steps of a method, files, back to the start.
pub fn cycle(session: &mut Session, number: usize) {
    let shapes = [documents::ball(4), documents::torus(12, 8), documents::plate(2)];
    session.open("thing.obj", &shapes[number % shapes.len()].obj());
    let method = ["cutflow", "cones", "phasefield", "developable"][number % 4];
    session.handle(Command::SetMethod { id: method.into() });
    session.handle(Command::Run);
    let mut left = 12;
    while session.is_running() && left > 0 {
        left -= 1;
        session.advance(&mut || false);
        session.scene();
    }
    session.handle(Command::Pause);
    session.handle(Command::SetParameter { id: "size".into(), value: Value::Number(250.0) });
    for kind in &KINDS[..KINDS.len() - 1] {
        // Not every method writes every kind.
        let _ = session.export(kind);
    }
    session.handle(Command::Undo);
    session.handle(Command::Reset);
    session.scene();
}

#[test]
fn fifty_cycles_of_load_run_and_reset_do_not_hold_more_and_more_memory() {
    let Some(_) = resident() else {
        println!("SKIPPED: this system does not tell how much memory a process holds");
        return;
    };
    let mut session = Session::new();
    let cycles = |session: &mut Session, numbers: std::ops::Range<usize>| {
        numbers.for_each(|number| cycle(session, number));
        resident().unwrap()
    };
    // Undo is full after a few, and the allocator has what it needs.
    let before = cycles(&mut session, 0..14);
    let after = cycles(&mut session, 14..50);
    println!("{before} {after}");
    // Other tests run beside this one in the same process: what they hold comes on top. The long run measures to 5 %.
    assert!(after < before + (256 << 20), "{before} bytes, then {after}");
}
