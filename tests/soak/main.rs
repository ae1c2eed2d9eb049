//! The long run: `cargo xtask soak`. What the short tests of `tests/it/hard` do, as often as asked; prints what was done and what was found.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    clippy::disallowed_methods,
    dead_code,
    reason = "a harness may stop where it meets what it does not expect; its short tests use more of what it shares with them"
)]

#[path = "../it/hard/mod.rs"]
mod hard;
#[path = "../it/mutation.rs"]
mod mutation;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::Ordering;
use std::time::Instant;

use hard::fuzzing::{HELD, PEAK};
use hard::{cycles, degenerate, fuzzing, sequences};

/// The system's allocator, which says how much it was asked for.
struct Counting;

fn took(bytes: usize) {
    let held = HELD.fetch_add(bytes, Ordering::Relaxed) + bytes;
    PEAK.fetch_max(held, Ordering::Relaxed);
}

#[allow(unsafe_code, reason = "an allocator can only be counted by one that stands in front of it")]
// SAFETY: every call is handed on as it came; only numbers are counted beside it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        took(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        took(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        took(size);
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What is asked for on the command line.
struct Asked {
    /// Damaged files, over all readers.
    executions: u64,
    /// Sequences of commands.
    sequences: u64,
    /// Loads, runs and resets.
    cycles: usize,
    seed: u64,
    /// One sequence, by the number that a finding has.
    sequence: Option<u64>,
    only: Option<String>,
}

fn asked() -> Asked {
    let mut asked = Asked {
        executions: 10_000_000,
        sequences: 10_000,
        cycles: 1000,
        seed: 1,
        sequence: None,
        only: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().unwrap_or_else(|| panic!("{word} needs a value after it"));
        match word.as_str() {
            "--executions" => asked.executions = value().parse().expect("a whole number"),
            "--sequences" => asked.sequences = value().parse().expect("a whole number"),
            "--cycles" => asked.cycles = value().parse().expect("a whole number"),
            "--seed" => asked.seed = value().parse().expect("a whole number"),
            "--sequence" => asked.sequence = Some(value().parse().expect("a whole number")),
            "--only" => asked.only = Some(value()),
            // Cargo says this to everything that it runs.
            "--bench" => {}
            _ => panic!("unknown argument {word}"),
        }
    }
    asked
}

/// Actions of a sequence.
const ACTIONS: usize = 25;

/// Findings are told at once and counted.
#[derive(Default)]
struct Findings(usize);

impl Findings {
    fn put(&mut self, result: Result<(), String>) {
        if let Err(what) = result {
            self.0 += 1;
            println!("FOUND {}: {what}\n", self.0);
        }
    }

    /// Says how many there are; ends with 1 if there are any.
    fn tell(&self, start: Instant) {
        println!("findings: {} in {:.0} s", self.0, start.elapsed().as_secs_f64());
        if self.0 > 0 {
            std::process::exit(1);
        }
    }
}

fn main() {
    let asked = asked();
    // Panics are findings, told with what led to them.
    std::panic::set_hook(Box::new(|info| {
        if let Some(place) = info.location() {
            println!("panic at {place}");
        }
    }));
    let wants = |name: &str| asked.only.as_deref().is_none_or(|only| only == name);
    let mut findings = Findings::default();
    let start = Instant::now();
    let Asked { executions, sequences, cycles, seed, .. } = asked;
    if let Some(number) = asked.sequence {
        findings.put(sequences::run(number, ACTIONS, &mut sequences::Counts::default()));
        return findings.tell(start);
    }
    println!("soak: {executions} executions, {sequences} sequences, {cycles} cycles, seed {seed}");
    if wants("degenerate") {
        table(&mut findings);
    }
    if wants("cycles") {
        memory(cycles, &mut findings);
    }
    if wants("fuzzing") {
        fuzz(executions, seed, &mut findings);
    }
    if wants("sequences") {
        orders(sequences, seed, &mut findings);
    }
    findings.tell(start);
}

/// Surfaces that hardly are any, through every method.
fn table(findings: &mut Findings) {
    let (all, cases) = (Instant::now(), degenerate::cases(true));
    for case in &cases {
        let start = Instant::now();
        findings.put(degenerate::run(case).map(|ends| {
            println!("{:<36} {:>6.1} s  {ends}", case.name, start.elapsed().as_secs_f64());
        }));
    }
    println!("degenerate: {} cases in {:.0} s", cases.len(), all.elapsed().as_secs_f64());
}

/// All targets in turn, each with its share of the executions.
fn fuzz(executions: u64, seed: u64, findings: &mut Findings) {
    let start = Instant::now();
    let mut targets = fuzzing::targets();
    let shares: u64 = targets.iter().map(|target| target.share).sum();
    for target in &mut targets {
        findings.put(target.prove());
        let (begin, before) = (Instant::now(), findings.0);
        let first = seed.wrapping_mul(1 << 40);
        for number in 0..(executions * target.share).div_ceil(shares) {
            findings.put(target.run(first.wrapping_add(number)));
            // One fault is found again and again.
            if findings.0 >= before + 5 {
                break;
            }
        }
        let seconds = begin.elapsed().as_secs_f64();
        let (n, loaded) = (target.executions, target.loaded);
        let part = 100.0 * loaded as f64 / n as f64;
        println!(
            "fuzz {:<14} {n:>10} executions, {:>8.0} /s, {part:.0} % read, {seconds:.0} s",
            target.name,
            n as f64 / seconds
        );
    }
    let all: u64 = targets.iter().map(|target| target.executions).sum();
    println!("fuzz all            {all:>10} executions in {:.0} s", start.elapsed().as_secs_f64());
}

fn orders(sequences: u64, seed: u64, findings: &mut Findings) {
    let start = Instant::now();
    let mut counts = sequences::Counts::default();
    let first = seed.wrapping_mul(1 << 40);
    let (mut slowest, before) = ((0.0, 0), findings.0);
    for number in 0..sequences {
        let number = first.wrapping_add(number);
        let begin = Instant::now();
        findings.put(sequences::run(number, ACTIONS, &mut counts));
        let seconds = begin.elapsed().as_secs_f64();
        if seconds > slowest.0 {
            slowest = (seconds, number);
        }
        if findings.0 >= before + 40 {
            break;
        }
    }
    println!("{counts:#?}\nslowest sequence: {} in {:.1} s", slowest.1, slowest.0);
    println!("sequences: {} in {:.0} s", counts.sequences, start.elapsed().as_secs_f64());
}

/// Many cycles; the memory after the first tenth is what it may go on with.
fn memory(cycles: usize, findings: &mut Findings) {
    let start = Instant::now();
    let mut session = cutflow::session::Session::new();
    let mut marks = Vec::new();
    let tenth = cycles.div_ceil(10).max(1);
    for number in 1..=cycles {
        cycles::cycle(&mut session, number);
        if number % tenth == 0 {
            let resident = cycles::resident().unwrap_or(0);
            let held = HELD.load(Ordering::Relaxed);
            println!(
                "cycle {number:>5}: {:.1} MB resident, {:.1} MB held",
                resident as f64 / 1e6,
                held as f64 / 1e6
            );
            marks.push(resident);
        }
    }
    let [Some(&first), Some(&last)] = [marks.first(), marks.last()] else { return };
    let growth = 100.0 * (last as f64 / first as f64 - 1.0);
    println!("memory grew by {growth:.1} % in {:.0} s", start.elapsed().as_secs_f64());
    if growth > 5.0 {
        findings.put(Err(format!("memory grew from {first} to {last} bytes")));
    }
}
