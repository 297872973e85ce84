//! The checker as a process of its own: events come on standard input, answers go to standard output.
//!
//! Hosted, unlike the checker; it is what `exover simulate --engine rust` talks to. `runner.c` describes the lines.

#![allow(unreachable_code)] // where a spec has no posters or no stocks

use native::{Action, Checker, Outcome, Poster, Reason, Request, Status, Stock, Value, Why, TABLES};
use std::io::{self, BufWriter, Read, Write};
use std::process::exit;
use std::sync::Mutex;
use std::time::Instant;

enum Event {
    Ask(Request, Vec<Value>),
    Report(Request, u32, u32, Option<u32>, Vec<Value>),
    Observe(Poster, Value),
    Level(Stock, i64),
    Abort(Request, u32),
    AbortWaiting(Request),
    Again,
    Flush,
}

fn give_up(why: &str) -> ! {
    eprintln!("runner: {why}");
    exit(1)
}

/// The words of standard input, one after another, each as soon as it has come.
struct Words {
    bytes: io::Bytes<io::StdinLock<'static>>,
}

impl Words {
    fn next(&mut self) -> Option<String> {
        let mut word = String::new();
        for byte in self.bytes.by_ref() {
            match byte {
                Ok(byte) if !byte.is_ascii_whitespace() => word.push(char::from(byte)),
                Ok(_) if word.is_empty() => {}
                Ok(_) => return Some(word),
                Err(error) => give_up(&error.to_string()),
            }
        }
        if word.is_empty() { None } else { Some(word) }
    }

    fn number<T: TryFrom<i64>>(&mut self) -> T {
        let word = self.next().and_then(|word| word.parse::<i64>().ok());
        word.and_then(|number| T::try_from(number).ok()).unwrap_or_else(|| give_up("a number is missing"))
    }

    fn value(&mut self) -> Value {
        let bits = self.next().and_then(|word| u64::from_str_radix(&word, 16).ok());
        Value::from_bits(bits.unwrap_or_else(|| give_up("a value is missing")))
    }

    fn values(&mut self) -> Vec<Value> {
        (0..self.number::<usize>()).map(|_| self.value()).collect()
    }

    fn one<T: Copy>(&mut self, all: &[T], index: fn(T) -> usize) -> T {
        let number = self.number();
        all.iter().copied().find(|each| index(*each) == number).unwrap_or_else(|| give_up("no such index"))
    }

    fn request(&mut self) -> Request {
        self.one(&Request::ALL, Request::index)
    }

    fn event(&mut self) -> Option<Event> {
        Some(match self.next()?.as_str() {
            "a" => Event::Ask(self.request(), self.values()),
            "r" => {
                let (request, slot, outcome) = (self.request(), self.number(), self.number());
                Event::Report(request, slot, outcome, u32::try_from(self.number::<i64>()).ok(), self.values())
            }
            "o" => Event::Observe(self.one(&Poster::ALL, Poster::index), self.value()),
            "l" => Event::Level(self.one(&Stock::ALL, Stock::index), self.value().integer()),
            "k" => Event::Abort(self.request(), self.number()),
            "w" => Event::AbortWaiting(self.request()),
            "z" => Event::Again,
            "f" => Event::Flush,
            _ => give_up("no such event"),
        })
    }
}

fn start(checker: &mut Checker) {
    let status = checker.load_stopped();
    if status != Status::Ready {
        give_up(&format!("the tables were refused: {}", status as u32));
    }
}

fn run(checker: &mut Checker, event: &Event) -> usize {
    match event {
        Event::Ask(request, args) => checker.ask(*request, args),
        Event::Report(request, slot, 1, _, results) => checker.report(*request, *slot, Outcome::Ok(results)),
        Event::Report(request, slot, 2, status, _) => checker.report(*request, *slot, Outcome::Failed(*status)),
        Event::Report(request, slot, ..) => checker.report(*request, *slot, Outcome::Interrupted),
        Event::Observe(poster, value) => checker.observe(*poster, *value),
        Event::Level(stock, level) => checker.observe_level(*stock, *level),
        Event::Abort(request, slot) => checker.abort(*request, *slot),
        Event::AbortWaiting(request) => checker.abort_waiting(*request),
        Event::Again | Event::Flush => &[],
    }
    .len()
}

/// The number of a reason in the protocol, if there is one.
fn number(reason: Option<Reason>) -> i64 {
    reason.map_or(-1, |reason| reason.index() as i64)
}

/// The number of what is refused or stopped for in the protocol.
fn code(why: Why) -> i64 {
    match why {
        Why::Rule(reason) => reason.index() as i64,
        Why::Superseded => -2,
        Why::Aborted => -3,
        Why::Faulty => -4,
    }
}

fn print(checker: &Checker, out: &mut impl Write) -> io::Result<()> {
    for action in checker.actions() {
        match *action {
            Action::Launch { request, slot, reason, launch_rule } => {
                write!(out, "7798 {} {slot} {} {}", request.index(), number(reason), number(launch_rule))?;
                for value in checker.args(request, slot).unwrap_or(&[]) {
                    write!(out, " {:016x}", value.bits())?;
                }
            }
            Action::Wait { request, reason, launch_rule } => {
                write!(out, "19420 {} -1 {} {}", request.index(), reason.index(), number(launch_rule))?;
            }
            Action::Reject { request, why, launch_rule } => {
                let index = request.map_or(-1, |request| request.index() as i64);
                write!(out, "17834 {index} -1 {} {}", code(why), number(launch_rule))?;
            }
            Action::Kill { request, slot, why } => write!(out, "12123 {} {slot} {} -1", request.index(), code(why))?,
            Action::Violation { reason } => write!(out, "29781 -1 -1 {} -1", reason.index())?,
            Action::Invalid(what) => write!(out, "4969 -1 -1 {} -1", what as i32)?,
        }
        write!(out, ";")?;
    }
    writeln!(out)
}

fn answer_all(checker: &mut Checker, words: &mut Words) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    writeln!(out, "ready")?;
    out.flush()?;
    while let Some(event) = words.event() {
        match event {
            Event::Again => start(checker),
            Event::Flush => out.flush()?,
            _ => {
                run(checker, &event);
                print(checker, &mut out)?;
            }
        }
    }
    out.flush()
}

/// Seconds of the processor where Linux tells them, else of the clock.
fn seconds(begin: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| begin.elapsed().as_secs_f64(), |found| found / 1e9)
}

/// Read all events, run them so many times, and print the seconds that took.
fn measure(checker: &mut Checker, words: &mut Words, repeats: &str) {
    let events: Vec<Event> = std::iter::from_fn(|| words.event()).collect();
    let mut answers = 0;
    let begin = Instant::now();
    let before = seconds(begin);
    for _ in 0..repeats.parse().unwrap_or_else(|_| give_up("no such number of times")) {
        for event in &events {
            answers += run(checker, event);
        }
    }
    println!("{:.9} {answers}", seconds(begin) - before);
}

/// A checker of many slots is larger than a stack.
static CHECKER: Mutex<Checker> = Mutex::new(Checker::new(&TABLES));

fn main() -> io::Result<()> {
    let mut held = CHECKER.lock().unwrap_or_else(|_| give_up("the checker is not free"));
    let checker = &mut *held;
    let mut words = Words { bytes: io::stdin().lock().bytes() };
    start(checker);
    match std::env::args().nth(1) {
        Some(repeats) => measure(checker, &mut words, &repeats),
        None => answer_all(checker, &mut words)?,
    }
    Ok(())
}
