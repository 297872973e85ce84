//! What a checker in Rust answers after each single flip of its own bits. For tests: hosted; see faulty.c.
//!
//! Prints how many flips were found to be faults; arguments handed out flipped; aborts without a kill; requests that
//! waited and were told nothing; launches after the fault.

use faulty::{Action, Checker, Outcome, Phase, Request, Status, View, Why, SCRUB_STEPS, TABLES};
use std::mem::size_of;

const A: Request = Request::MA;
const B: Request = Request::MB;
const C: Request = Request::MC;

fn start(checker: &mut Checker) {
    assert_eq!(checker.load_stopped(), Status::Ready);
    assert!(matches!(checker.ask_m_a(3, 0.5), [Action::Launch { .. }]));
    assert!(matches!(checker.ask_m_b(), [Action::Wait { .. }]));
}

fn launches(actions: &[Action], wanted: Request) -> bool {
    actions.iter().any(|action| matches!(action, Action::Launch { request, .. } if *request == wanted))
}

fn denies(actions: &[Action], wanted: Request) -> bool {
    actions.contains(&Action::Reject { request: Some(wanted), why: Why::Faulty, launch_rule: None })
}

/// What slots and waiting places hold, and since which step.
fn views() {
    let mut checker = Checker::new(&TABLES);
    let view = |phase, since| Some(View { phase, since });
    assert_eq!(checker.slot_m_a(), None);
    start(&mut checker);
    assert_eq!((checker.slot_m_a(), checker.place_m_a()), (view(Phase::Running, 1), view(Phase::Idle, 0)));
    assert_eq!((checker.slot_m_b(), checker.place_m_b()), (view(Phase::Idle, 0), view(Phase::Waiting, 2)));
    checker.abort_m_a();
    assert_eq!((checker.slot_m_a(), checker.view(A, 1), checker.steps()), (view(Phase::Stopping, 3), None, 3));
    checker.report_m_a_interrupted();
    assert_eq!((checker.slot_m_a(), checker.slot_m_b()), (view(Phase::Idle, 4), view(Phase::Running, 4)));
    assert_eq!(checker.view_waiting(B), view(Phase::Idle, 4));
}

fn main() {
    views();
    let (mut faults, mut handed, mut unkilled, mut untold, mut launched) = (0, 0, 0, 0, 0);
    let mut place = Checker::new(&TABLES);
    let checker = &raw mut place;
    for bit in 0..8 * size_of::<Checker>() {
        // SAFETY: the bits of a checker that only this function uses; what is no number there is compared before use.
        unsafe {
            checker.write(Checker::new(&TABLES));
            start(&mut *checker);
            let byte = checker.cast::<u8>().add(bit / 8);
            byte.write_volatile(byte.read_volatile() ^ 1 << (bit % 8));
            handed += usize::from((*checker).args_m_a().is_some_and(|args| args.n != 3 || args.x != 0.5));
            let answers = (*checker).report(A, 0, Outcome::Ok(&[]));
            let (started, mut told) = (launches(answers, B), denies(answers, B));
            let mut steps = 0;
            while steps < SCRUB_STEPS && (*checker).fault() == Status::Ready {
                let answers = (*checker).abort(C, 0);
                told |= denies(answers, B);
                steps += 1;
            }
            if (*checker).fault() == Status::Ready {
                continue;
            }
            faults += 1;
            let answers = (*checker).ask(C, &[]);
            launched += usize::from(launches(answers, C));
            untold += usize::from(!started && !told && !denies(answers, B));
            for request in Request::ALL {
                let kill = Action::Kill { request, slot: 0, why: Why::Aborted };
                unkilled += usize::from(!(*checker).abort(request, 0).contains(&kill));
            }
        }
    }
    println!("{faults} {handed} {unkilled} {untold} {launched}");
}
