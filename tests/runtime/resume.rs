// A checker whose state goes out in records and comes back; see resume.c. It stands behind runner.rs, whose events it reads.

use native::RECORD_BYTES;

fn trip(words: &mut Words) {
    let events: Vec<Event> = std::iter::from_fn(|| words.event()).collect();
    let mut checker = Checker::new(&TABLES);
    start(&mut checker);
    let first: Vec<Vec<Action>> = events.iter().map(|event| { run(&mut checker, event); checker.actions().to_vec() }).collect();
    start(&mut checker);
    let (mut refused, mut differ) = (0, 0);
    for (event, due) in events.iter().zip(&first) {
        let mut record = vec![0; RECORD_BYTES];
        let length = checker.export(&mut record);
        checker = Checker::new(&TABLES);
        refused += usize::from(length != Some(RECORD_BYTES) || checker.resume(&record) != Status::Ready);
        run(&mut checker, event);
        differ += usize::from(checker.actions() != due);
    }
    println!("{} {refused} {differ} {}", events.len(), checker.steps() as usize - events.len());
}

fn show(words: &mut Words) {
    let mut checker = Checker::new(&TABLES);
    start(&mut checker);
    while let Some(event) = words.event() {
        run(&mut checker, &event);
    }
    let mut record = vec![0; RECORD_BYTES];
    checker.export(&mut record).unwrap();
    println!("{}", record.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
    let short = checker.export(&mut record[1..]);
    println!("{short:?} {:?}", (checker.load() as u32, checker.resume(&record) as u32));
}

fn try_all(paths: impl Iterator<Item = String>) {
    for path in paths {
        let mut checker = Checker::new(&TABLES);
        let status = checker.resume(&std::fs::read(path).unwrap());
        let denied = matches!(checker.ask(Request::ALL[0], &[]), [Action::Reject { why: Why::Faulty, .. }]);
        println!("{} {}", status as u32, u32::from(denied));
    }
}

/// The files are a record and a map to these tables; what the swap answers, and the answers to the events that follow.
fn swap(words: &mut Words, mut paths: impl Iterator<Item = String>) {
    let (record, map) = (paths.next().unwrap(), paths.next().unwrap());
    let (record, mut map) = (std::fs::read(record).unwrap(), std::fs::read(map).unwrap());
    let mut checker = Checker::new(&TABLES);
    for bit in 0..8 * map.len() {
        map[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(checker.swap(&record, &map), Err(Status::BadMap));
        map[bit / 8] ^= 1 << (bit % 8);
    }
    match checker.swap(&record, &map) {
        Ok(actions) => println!("0 {}", actions.len()),
        Err(status) => return println!("{}", status as u32),
    }
    let mut out = io::stdout();
    print(&checker, &mut out).unwrap();
    while let Some(event) = words.event() {
        run(&mut checker, &event);
        print(&checker, &mut out).unwrap();
    }
    println!("{:?}", checker.swap(&record, &map).err().map(|status| status as u32));
}

fn main() {
    let mut words = Words { bytes: io::stdin().lock().bytes() };
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("trip") => trip(&mut words),
        Some("show") => show(&mut words),
        Some("swap") => swap(&mut words, arguments),
        _ => try_all(arguments),
    }
}
