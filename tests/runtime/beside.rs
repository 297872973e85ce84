// Flips single bits of tables and checker while one of any spec runs, beside one that is sound; see beside.c. It stands
// behind runner.rs, whose events it reads.

use std::alloc::{alloc, Layout};
use std::mem::size_of;

const MOMENTS: usize = 6;
const HORIZON: usize = 60;

type Taken = (Vec<Action>, Vec<u64>);

fn take(checker: &mut Checker, event: &Event) -> Taken {
    run(checker, event);
    let actions = checker.actions().to_vec();
    let args = actions.iter().flat_map(|action| match *action {
        Action::Launch { request, slot, .. } => checker.args(request, slot).unwrap_or(&[]).to_vec(),
        _ => Vec::new(),
    });
    let bits = args.map(Value::bits).collect();
    (actions, bits)
}

fn launches(taken: &Taken) -> usize {
    taken.0.iter().filter(|action| matches!(action, Action::Launch { .. })).count()
}

/// The launches that are not among the sound ones; all of them if arguments differ.
fn beyond(taken: &Taken, sound: &Taken) -> usize {
    if taken.1 != sound.1 {
        return launches(taken);
    }
    taken.0.iter().filter(|action| matches!(action, Action::Launch { .. }) && !sound.0.contains(action)).count()
}

struct Trial<'a> {
    events: &'a [Event],
    sound: &'a [Taken],
    moments: &'a [Vec<u8>],
    stride: usize,
}

impl Trial<'_> {
    /// # Safety
    ///
    /// The bits belong to the tables or to the checker, and no reference to them is used meanwhile.
    unsafe fn flip(&self, title: &str, bytes: *mut u8, length: usize, checker: *mut Checker<'_>) {
        let (mut flips, mut missed, mut wrong, mut differ) = (0, 0, 0, 0);
        for bit in (0..8 * length).step_by(self.stride) {
            for (moment, before) in self.moments.iter().enumerate() {
                checker.cast::<u8>().copy_from(before.as_ptr(), before.len());
                let byte = bytes.add(bit / 8);
                let whole = byte.read_volatile();
                byte.write_volatile(whole ^ 1 << (bit % 8));
                let (mut at, end) = (moment * HORIZON, (moment + 1) * HORIZON);
                while at < end && (*checker).fault() == Status::Ready {
                    let taken = take(&mut *checker, &self.events[at]);
                    at += 1;
                    if taken != self.sound[at - 1] {
                        wrong += beyond(&taken, &self.sound[at - 1]);
                        differ += usize::from((*checker).fault() == Status::Ready);
                        break;
                    }
                }
                if (*checker).fault() == Status::Ready {
                    (*checker).scrub(8 * native::SCRUB_STEPS as u32);
                }
                missed += usize::from((*checker).fault() == Status::Ready);
                while at < end && (*checker).fault() != Status::Ready {
                    wrong += launches(&take(&mut *checker, &self.events[at]));
                    at += 1;
                }
                byte.write_volatile(whole);
                flips += 1;
            }
        }
        println!("{title} {flips} {missed} {wrong} {differ}");
    }
}

fn main() {
    let stride = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(1);
    let mut words = Words { bytes: io::stdin().lock().bytes() };
    let events: Vec<Event> = (0..MOMENTS * HORIZON).map(|_| words.event().unwrap()).collect();
    let size = size_of::<native::Tables>();
    // SAFETY: a copy of the tables, to which a checker has a reference while this changes them: for the compiler they are
    // behind calls of another crate, and nothing is read here but what these calls return.
    unsafe {
        let bytes = alloc(Layout::new::<native::Tables>());
        bytes.copy_from((&raw const TABLES).cast(), size);
        let mut checker = Checker::new(&*bytes.cast::<native::Tables>());
        assert_eq!(checker.load(), Status::Ready);
        let (mut sound, mut moments) = (Vec::new(), Vec::new());
        for (number, event) in events.iter().enumerate() {
            if number % HORIZON == 0 {
                moments.push(std::slice::from_raw_parts((&raw const checker).cast(), size_of::<Checker>()).to_vec());
            }
            sound.push(take(&mut checker, event));
            assert_eq!(checker.fault(), Status::Ready);
        }
        let trial = Trial { events: &events, sound: &sound, moments: &moments, stride };
        let running = &raw mut checker;
        trial.flip("tables", bytes, size, running);
        trial.flip("checker", running.cast(), size_of::<Checker>(), running);
    }
}
