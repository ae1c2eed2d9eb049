//! The long run: `cargo xtask soak`. What the short tests of `tests/it/hard` do, for as long as asked; prints what was done and what was found.

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
use std::time::{Duration, Instant};

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
    minutes: f64,
    seed: u64,
    only: Option<String>,
}

fn asked() -> Asked {
    let mut asked = Asked { minutes: 60.0, seed: 1, only: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().unwrap_or_else(|| panic!("{word} needs a value after it"));
        match word.as_str() {
            "--minutes" => asked.minutes = value().parse().expect("a number of minutes"),
            "--seed" => asked.seed = value().parse().expect("a whole number"),
            "--only" => asked.only = Some(value()),
            // Cargo says this to everything that it runs.
            "--bench" => {}
            _ => panic!("unknown argument {word}"),
        }
    }
    asked
}

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
    let whole = Duration::from_secs_f64(60.0 * asked.minutes);
    let mut findings = Findings::default();
    println!("soak: {} min, seed {}", asked.minutes, asked.seed);
    if wants("degenerate") {
        for case in degenerate::cases(true) {
            let start = Instant::now();
            findings.put(degenerate::run(&case).map(|ends| {
                println!("{:<24} {:>6.1} s  {ends}", case.name, start.elapsed().as_secs_f64());
            }));
        }
    }
    if wants("cycles") {
        memory(&mut findings);
    }
    let start = Instant::now();
    let left = whole.mul_f64(if asked.only.is_some() { 1.0 } else { 0.5 });
    if wants("fuzzing") {
        fuzz(start, left, asked.seed, &mut findings);
    }
    if wants("sequences") {
        orders(Instant::now(), left, asked.seed, &mut findings);
    }
    println!("findings: {}", findings.0);
    if findings.0 > 0 {
        std::process::exit(1);
    }
}

/// All targets in turn, each for the same time.
fn fuzz(start: Instant, time: Duration, seed: u64, findings: &mut Findings) {
    let mut targets = fuzzing::targets();
    let slice = time.div_f64(targets.len() as f64);
    for target in &mut targets {
        findings.put(target.prove());
        let (begin, before) = (Instant::now(), findings.0);
        let mut number = seed.wrapping_mul(1 << 40);
        // One fault is found again and again.
        while begin.elapsed() < slice && findings.0 < before + 5 {
            for _ in 0..if target.executions == 0 { 1 } else { 16 } {
                findings.put(target.run(number));
                number += 1;
            }
        }
        let seconds = begin.elapsed().as_secs_f64();
        let (n, loaded) = (target.executions, target.loaded);
        let part = 100.0 * loaded as f64 / n as f64;
        println!(
            "fuzz {:<14} {n:>10} executions, {:>8.0} /s, {part:.0} % read",
            target.name,
            n as f64 / seconds
        );
    }
    let all: u64 = targets.iter().map(|target| target.executions).sum();
    println!("fuzz all            {all:>10} executions in {:.0} s", start.elapsed().as_secs_f64());
}

fn orders(start: Instant, time: Duration, seed: u64, findings: &mut Findings) {
    let mut counts = sequences::Counts::default();
    let mut number = seed.wrapping_mul(1 << 40);
    let (mut slowest, before) = ((0.0, 0), findings.0);
    while start.elapsed() < time && findings.0 < before + 40 {
        let begin = Instant::now();
        findings.put(sequences::run(number, 25, &mut counts));
        let seconds = begin.elapsed().as_secs_f64();
        if seconds > slowest.0 {
            slowest = (seconds, number);
        }
        number += 1;
    }
    println!("{counts:#?}\nslowest sequence: {} in {:.1} s", slowest.1, slowest.0);
}

/// A thousand cycles; the memory after the first hundred is what it may go on with.
fn memory(findings: &mut Findings) {
    let mut session = cutflow::session::Session::new();
    let mut marks = Vec::new();
    for number in 0..=1000 {
        cycles::cycle(&mut session, number);
        if number % 100 == 0 && number > 0 {
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
    let (first, last) = (marks[0] as f64, marks[marks.len() - 1] as f64);
    println!("memory grew by {:.1} %", 100.0 * (last / first - 1.0));
    if last > 1.05 * first {
        findings.put(Err(format!("memory grew from {first} to {last} bytes")));
    }
}
