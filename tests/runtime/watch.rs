//! Watches what a checker in Rust decides on random events, beside the rules read a second time. For tests: hosted.
//!
//! Input (32 bits each, of this machine): the number of requests, the number of rules, then of each rule, in the order of
//! the text, the two requests that it keeps apart and the reason it gives. Nothing else is asked of the rules: they reject.
//!
//! `decisions N` prints how many asks of N were launched and rejected, and how many slots were reported; a decision that
//! is not that of the rules ends the program. `flips` flips every bit of the tables before they are loaded, every bit of
//! them while a checker runs, and every bit of the checker; of each it prints the bits, those that were not found in
//! time, the unsafe launches, and what was found. `faults` goes through what a faulty checker still does.

use std::alloc::{alloc, Layout};
use std::collections::BTreeSet;
use std::env::args;
use std::io::{stdin, Read};
use std::mem::size_of;
use watched::{Action, Checker, Invalid, Outcome, Request, Status, Tables, Why, RECORD_BYTES, SCRUB_STEPS, TABLES};

/// What a faulty checker answers to the first request.
const DENIED: &[Action] = &[Action::Reject { request: Some(Request::ALL[0]), why: Why::Faulty, launch_rule: None }];

struct Rules {
    apart: Vec<[usize; 3]>,
}

impl Rules {
    fn read() -> Rules {
        let mut bytes = Vec::new();
        stdin().read_to_end(&mut bytes).unwrap();
        let numbers: Vec<usize> =
            bytes.chunks(4).map(|four| u32::from_ne_bytes(four.try_into().unwrap()) as usize).collect();
        assert_eq!(numbers[0], Request::ALL.len());
        let apart: Vec<[usize; 3]> = numbers[2..].chunks(3).map(|three| three.try_into().unwrap()).collect();
        assert_eq!(numbers[1], apart.len());
        Rules { apart }
    }

    /// The reason for which a request is rejected, 0 for busy; none if it is launched.
    fn due(&self, active: &[bool], request: usize) -> Option<usize> {
        let excluded = |[a, b, _]: &&[usize; 3]| (*a == request && active[*b]) || (*b == request && active[*a]);
        if active[request] { Some(0) } else { self.apart.iter().find(excluded).map(|rule| rule[2]) }
    }
}

struct Lot(u64);

impl Lot {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % end
    }
}

fn decisions(rules: &Rules, todo: u64) {
    let (mut lot, mut active) = (Lot(20261121), vec![false; Request::ALL.len()]);
    let (mut launched, mut rejected, mut reported) = (0, 0, 0);
    let mut checker = Checker::new(&TABLES);
    assert_eq!(checker.load_stopped(), Status::Ready);
    while launched + rejected < todo {
        let number = lot.below(active.len());
        let request = Request::ALL[number];
        if active[number] && lot.below(2) == 1 {
            assert_eq!(checker.report(request, 0, Outcome::Ok(&[])), &[]);
            active[number] = false;
            reported += 1;
            continue;
        }
        match (checker.ask(request, &[]), rules.due(&active, number)) {
            (&[Action::Launch { request: its, slot: 0, reason: None, launch_rule: None }], None) if its == request => {
                active[number] = true;
                launched += 1;
            }
            (&[Action::Reject { request: Some(its), why: Why::Rule(reason), launch_rule: None }], Some(due))
                if its == request && reason.index() == due =>
            {
                rejected += 1;
            }
            (given, due) => panic!("request {number} is due {due:?}, got {given:?}"),
        }
    }
    println!("{launched} {rejected} {reported}");
}

/// One random event; how many launches were unsafe.
fn event(rules: &Rules, checker: &mut Checker, active: &mut [bool], lot: &mut Lot) -> usize {
    let number = lot.below(active.len());
    let request = Request::ALL[number];
    let answers = if active[number] && lot.below(2) == 1 {
        active[number] = false;
        checker.report(request, 0, Outcome::Ok(&[]))
    } else if active[number] && lot.below(4) == 0 {
        checker.abort(request, 0)
    } else {
        checker.ask(request, &[])
    };
    let mut bad = 0;
    for answer in answers {
        if let Action::Launch { request, .. } = answer {
            bad += usize::from(rules.due(active, request.index()).is_some());
            active[request.index()] = true;
        }
    }
    bad
}

/// Flip each of so many bits from an address on while a checker runs on these tables; print what came of it.
///
/// # Safety
///
/// The bits belong to the tables or to the checker, and no reference to them is used meanwhile.
unsafe fn flip(rules: &Rules, title: &str, bytes: *mut u8, length: usize, checker: *mut Checker<'_>) {
    let (mut lot, mut warm) = (Lot(1), vec![false; Request::ALL.len()]);
    for _ in 0..200 {
        assert_eq!(event(rules, &mut *checker, &mut warm, &mut lot), 0);
    }
    let before = checker.read();
    let (mut missed, mut wrong, mut found) = (0, 0, BTreeSet::new());
    for bit in 0..8 * length {
        let mut active = warm.clone();
        checker.cast::<u8>().copy_from((&raw const before).cast(), size_of::<Checker>());
        let byte = bytes.add(bit / 8);
        let whole = byte.read_volatile();
        byte.write_volatile(whole ^ 1 << (bit % 8));
        let mut steps = 0;
        while steps < SCRUB_STEPS && (*checker).fault() == Status::Ready {
            wrong += event(rules, &mut *checker, &mut active, &mut lot);
            steps += 1;
        }
        missed += usize::from((*checker).fault() == Status::Ready);
        found.insert((*checker).fault() as u32);
        for _ in 0..20 {
            wrong += event(rules, &mut *checker, &mut active, &mut lot);
        }
        byte.write_volatile(whole);
    }
    println!("{title} {} {missed} {wrong} {found:?}", 8 * length);
}

fn flips(rules: &Rules) {
    let size = size_of::<Tables>();
    // SAFETY: a copy of the tables, to which a checker has a reference while this changes them: for the compiler they
    // are behind calls of another crate, and nothing is read here but what these calls return.
    unsafe {
        let bytes = alloc(Layout::new::<Tables>());
        bytes.copy_from((&raw const TABLES).cast(), size);
        let tables = &*bytes.cast::<Tables>();
        let (mut refused, mut wrong, mut found) = (0, 0, BTreeSet::new());
        for bit in 0..8 * size {
            *bytes.add(bit / 8) ^= 1 << (bit % 8);
            let mut checker = Checker::new(tables);
            found.insert(checker.load_stopped() as u32);
            if checker.fault() != Status::Ready {
                refused += 1;
                wrong += usize::from(checker.ask(Request::ALL[0], &[]) != DENIED);
            }
            *bytes.add(bit / 8) ^= 1 << (bit % 8);
        }
        println!("load {} {} {wrong} {found:?}", 8 * size, 8 * size - refused);
        let mut checker = Checker::new(tables);
        assert_eq!(checker.load_stopped(), Status::Ready);
        flip(rules, "tables", bytes, size, &raw mut checker);
        assert_eq!(checker.load_stopped(), Status::Ready);
        flip(rules, "checker", (&raw mut checker).cast(), size_of::<Checker>(), &raw mut checker);
    }
}

/// A checker denies before it is loaded, and after a fault; then what runs can be aborted and reported, until a load.
fn faults() {
    let first = Request::ALL[0];
    let kill = [Action::Kill { request: first, slot: 0, why: Why::Aborted }];
    let launch = [Action::Launch { request: first, slot: 0, reason: None, launch_rule: None }];
    let idle = [Action::Invalid(Invalid::NotActive)];
    // SAFETY: as in `flips`.
    unsafe {
        let bytes = alloc(Layout::new::<Tables>());
        bytes.copy_from((&raw const TABLES).cast(), size_of::<Tables>());
        let mut checker = Checker::new(&*bytes.cast::<Tables>());
        assert_eq!((checker.fault(), checker.args(first, 0)), (Status::NotLoaded, None));
        assert_eq!(checker.ask(first, &[]), DENIED);
        assert_eq!(checker.abort(first, 0), kill);
        assert_eq!(checker.report(first, 0, Outcome::Interrupted), DENIED);
        assert_eq!(checker.load_stopped(), Status::Ready);
        assert_eq!(checker.ask(first, &[]), launch);
        assert_eq!(checker.args(first, 0), Some(&[][..]));
        let digest = (0..size_of::<Tables>()).find(|at| bytes.add(*at).cast::<[u8; 4]>().read() == *b"EXOV").unwrap() + 20;
        assert_eq!(checker.scrub(4 * SCRUB_STEPS as u32), Status::Ready);
        *bytes.add(digest) ^= 1;
        assert_eq!(checker.scrub(4 * SCRUB_STEPS as u32), Status::FaultTables);
        assert_eq!(checker.ask(first, &[]), DENIED);
        *bytes.add(digest) ^= 1;
        assert_eq!(checker.load_stopped(), Status::Ready);
        assert_eq!(checker.ask(first, &[]), launch);
        *bytes.add(digest) ^= 1;
        while checker.fault() == Status::Ready {
            assert_ne!(checker.ask(first, &[]), launch);
        }
        assert_eq!(checker.fault(), Status::FaultTables);
        assert_eq!(checker.ask(first, &[]), DENIED);
        assert_eq!(checker.abort(first, 0), kill);
        assert_eq!(checker.report(first, 1, Outcome::Interrupted), [Action::Invalid(Invalid::OutOfRange)]);
        assert_eq!(checker.report(first, 0, Outcome::Failed(None)), DENIED);
        assert_eq!(checker.report(first, 0, Outcome::Failed(None)), idle);
        assert_eq!(checker.load_stopped(), Status::BadChecksum);
        *bytes.add(digest) ^= 1;
        assert_eq!(checker.ask(first, &[]), DENIED);
        assert_eq!(checker.load_stopped(), Status::Ready);
        assert_eq!(checker.ask(first, &[]), launch);
        let (mut record, flags) = ([0; RECORD_BYTES], digest - 12);
        assert_eq!(checker.export(&mut record), Some(RECORD_BYTES));
        *bytes.add(flags) ^= 2;
        let mut exports = 0;
        while checker.export(&mut [0; RECORD_BYTES]).is_some() {
            exports += 1;
        }
        assert!(exports <= SCRUB_STEPS);
        assert_eq!(checker.fault(), Status::FaultTables);
        assert_eq!(checker.resume(&record), Status::BadChecksum);
        *bytes.add(flags) ^= 2;
        assert_eq!(checker.load(), Status::Live);
        assert_eq!(checker.resume(&record), Status::Ready);
        assert_ne!(checker.ask(first, &[]), launch);
    }
}

fn main() {
    let rules = Rules::read();
    match args().nth(1).as_deref() {
        Some("flips") => flips(&rules),
        Some("faults") => faults(),
        _ => decisions(&rules, args().nth(2).unwrap().parse().unwrap()),
    }
}
