"""What an audit says, by hand; and that the reference interpreter, the tables and the C say the same of any mission."""

from collections.abc import Sequence

import pytest

from exover.audit.trail import AuditRow
from tests.audit import missions
from tests.audit.missions import CRANE, FREE, LOOSE, ROOT, by_c, by_reference, by_tables, shown

ENGINES = (by_reference, by_tables, by_c)


def audit(lines: Sequence[str], text: str = CRANE) -> tuple[list[tuple[object, ...]], dict[str, int]]:
    """Return the divergences and some counts of a mission, the same by each engine."""
    data = [line.encode() for line in lines]
    found = [shown(engine(text, data)) for engine in ENGINES]
    assert found[0] == found[1] == found[2]
    rows, figures = by_c(text, data)
    counts = {name: getattr(figures, name) for name in ("passed", "undecided", "invalid", "lost", "followed", "told")}
    return [_short(row) for row in rows if row.kind != "ask"], {name: count for name, count in counts.items() if count}


def _short(row: AuditRow) -> tuple[object, ...]:
    return row.line, row.kind, row.request, row.instance, row.answer, row.rule


def test_a_launch_that_the_tables_reject_or_hold() -> None:
    rows, counts = audit(
        [
            '{"observe": "wind", "value": 12}',
            '{"ask": "hoist.lift", "args": {"load": 3.5}}',
            '{"launch": "hoist.lift", "args": {"load": 3.5}}',
            '{"ask": "slew.turn"}',
            '{"launch": "slew.turn"}',
            '{"report": "slew.turn", "outcome": "ok"}',
            '{"report": "hoist.lift", "outcome": "ok"}',
            '{"event": {"ask": "hoist.lift", "args": {"load": 11}}, "actions": [{"launch": "hoist.lift"}]}',
        ]
    )
    assert rows == [
        (5, "launched", "slew.turn", 0, "wait", "one"),
        (8, "launched", "hoist.lift", 0, "reject", "hoist.lift.light"),
    ]
    assert counts == {"passed": 1, "followed": 1, "told": 1}  # the report of what did not run; what waited is given up


def test_what_was_refused_does_not_run_for_what_comes_after() -> None:
    rows, _ = audit(
        [
            '{"observe": "wind", "value": 30}',
            '{"ask": "hoist.lift", "args": {"load": 11}}',
            '{"launch": "hoist.lift"}',
            '{"ask": "slew.turn"}',
            '{"launch": "slew.turn"}',
        ]
    )
    assert rows == [(3, "launched", "hoist.lift", 0, "reject", "hoist.lift.light")]


def test_an_end_of_what_was_never_launched() -> None:
    rows, _ = audit(
        [
            '{"report": "slew.park", "outcome": "ok"}',
            '{"ask": "hoist.lift", "args": {"load": 1}}',
            '{"ask": "slew.turn"}',
            '{"report": "slew.turn", "outcome": "ok"}',
            '{"observe": "wind", "value": 9}',
            '{"ask": "slew.turn"}',
            '{"report": "hoist.lift", "outcome": "ok"}',
            '{"report": "slew.turn", "outcome": "failed"}',
        ]
    )
    assert rows == [(1, "ran", "slew.park", 0, "none", None), (4, "ran", "slew.turn", 0, "wait", "one")]


def test_a_told_event_shows_what_was_withheld_and_ends_it() -> None:
    rows, counts = audit(
        [
            '{"event": {"ask": "slew.turn"}, "actions": [{"reject": "slew.turn", "rule": "old"}]}',
            '{"event": {"ask": "hoist.lift", "args": {"load": 1}}, "actions": [{"launch": "hoist.lift"}]}',
        ]
    )
    assert rows == [(1, "withheld", "slew.turn", None, "launch", None)]
    assert counts == {"followed": 1, "told": 2}


def test_a_launch_rule_that_the_robot_has_not_is_told_once() -> None:
    line = '{"event": {"observe": "wind", "value": 35}, "actions": []}'
    calm = line.replace("35", "1")
    rows, _ = audit([line, line, line, calm, calm, line, line])
    found = ("withheld", "slew.park", None, "launch", None)
    assert rows == [(1, *found), (6, *found)]  # the audit ends it in line 4, so that line 5 is the first without it


def test_what_the_tables_stop_and_the_robot_does_not() -> None:
    hold = '{"ask": "hoist.hold", "args": {"side": "left", "grip": true, "n": 1}}'
    rows, _ = audit(
        [
            f'{{"event": {hold}, "actions": [{{"launch": "hoist.hold", "instance": 1}}]}}',
            '{"event": {"ask": "slew.park"}, "actions": [{"wait": "slew.park"}]}',
            '{"event": {"observe": "calm", "value": 0}, "actions": [{"launch": "slew.park"}]}',
            '{"report": "hoist.hold", "instance": 1, "outcome": "ok", "results": {"height": 3}}',
        ]
    )
    assert rows == [
        (2, "kept", "hoist.hold", 1, "none", "away"),
        (3, "launched", "slew.park", 0, "wait", "away"),
    ]


@pytest.mark.parametrize("told", ("in the line", "behind it"))
def test_an_abort_that_the_robot_does_not_follow(told: str) -> None:
    """What somebody aborts is stopped, like what a rule stops; a kill among the actions shows that the robot did it."""
    ignored = '"actions": []'
    followed = '"actions": [{"kill": "slew.turn", "instance": 0, "rule": "abort"}]'

    def line(event: str, actions: str) -> list[str]:
        return [f'{{"event": {event}, {actions}}}'] if told == "in the line" else [event, f"{{{actions}}}"]

    launch = ['{"ask": "slew.turn"}', '{"launch": "slew.turn"}']
    abort = '{"abort": "slew.turn"}'
    rows, counts = audit([*launch, *line(abort, ignored), *line(abort, ignored)])
    assert rows == [(3 if told == "in the line" else 4, "kept", "slew.turn", 0, "none", "abort")]
    assert counts == {"told": 2}
    assert audit([*launch, *line(abort, followed), *line(abort, ignored)])[0] == []
    assert audit([*launch, abort])[0] == []


def test_what_the_robot_stops_and_the_tables_do_not() -> None:
    rows, counts = audit(
        [
            '{"ask": "slew.turn"}',
            '{"launch": "slew.turn"}',
            '{"kill": "slew.turn"}',
            '{"kill": "slew.turn"}',
            '{"ask": "slew.park"}',
        ]
    )
    assert rows == [(3, "stopped", "slew.turn", 0, "none", None)]
    assert counts == {"followed": 1}


def test_another_answer() -> None:
    lift = '{"ask": "hoist.lift", "args": {"load": 1}}'
    rows, _ = audit(
        [
            '{"observe": "wind", "value": 9}',
            '{"event": {"ask": "hoist.lift", "args": {"load": 9}}, "actions": [{"wait": "hoist.lift"}]}',
            f'{{"event": {lift}, "actions": [{{"launch": "hoist.lift"}}]}}',
            '{"event": {"ask": "slew.turn"}, "actions": [{"reject": "slew.turn"}]}',
            '{"event": {"report": "hoist.lift", "outcome": "ok"}, "actions": []}',
        ]
    )
    assert rows == [
        (2, "otherwise", "hoist.lift", None, "reject", "hoist.lift.light"),
        (4, "otherwise", "slew.turn", None, "wait", "one"),
    ]


@pytest.mark.parametrize("answer", ("wait", "reject"))
def test_a_newcomer_that_is_rejected_beside_what_it_supersedes(answer: str) -> None:
    superseded = '{"reject": "slew.turn", "rule": "superseded"}'
    rows, _ = audit(
        [
            '{"event": {"ask": "hoist.lift", "args": {"load": 1}}, "actions": [{"launch": "hoist.lift"}]}',
            '{"event": {"ask": "slew.turn"}, "actions": [{"wait": "slew.turn"}]}',
            f'{{"event": {{"ask": "slew.turn"}}, "actions": [{superseded}, {{"{answer}": "slew.turn"}}]}}',
            '{"event": {"abort": "slew.turn", "waiting": true}, "actions": [{"reject": "slew.turn"}]}',
        ]
    )
    assert rows == [(3, "otherwise", "slew.turn", None, "wait", "one")] * (answer == "reject")


@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("rejected", [True, False])
def test_what_waits_first_and_is_rejected_in_the_same_step(rejected: bool, told: bool) -> None:
    text = """spec late; module m { request a() { check free: not active(m.b); wait until past(m.b); } request b(); }
    launch go: m.b() when waiting(m.a);"""
    deeds = ['{"wait": "m.a"}', '{"launch": "m.b"}', *['{"reject": "m.a"}'] * rejected]
    ask = f'{{"event": {{"ask": "m.a"}}, "actions": [{", ".join(deeds)}]}}'
    rows, counts = audit([ask] if told else ['{"ask": "m.a"}', *deeds], text)
    assert rows == [(1, "otherwise", "m.a", None, "reject", "m.a.free")] * (told and not rejected)
    assert "followed" not in counts


def test_a_launch_without_its_arguments_is_undecided() -> None:
    rows, counts = audit(
        ['{"launch": "hoist.lift"}', '{"report": "hoist.lift", "outcome": "ok"}', '{"launch": "slew.turn"}']
    )
    assert rows == []
    assert counts == {"passed": 1, "undecided": 1}


def test_what_cannot_be_read_is_refused_and_ends_all_the_same() -> None:
    rows, counts = audit(
        [
            '{"launch": "hoist.lift", "args": {"load": 99}}',
            '{"launch": "slew.turn", "instance": 7}',
            '{"ask": "hoist.hold", "args": {"side": "left", "grip": true, "n": 1}}',
            '{"report": "hoist.hold", "outcome": "ok", "results": {"height": 1e9}}',
            '{"ask": "slew.park"}',
            '{"launch": "slew.park"}',
            '{"lost": 3}',
        ]
    )
    assert rows == [
        (1, "launched", "hoist.lift", 0, "invalid", "out-of-range"),
        (2, "launched", "slew.turn", None, "invalid", "out-of-range"),
    ]
    assert counts == {"invalid": 1, "lost": 3, "followed": 1}


@pytest.mark.parametrize("seed", range(4))
def test_the_log_of_a_gate_does_not_diverge_from_its_own_spec(seed: int) -> None:
    for engine in ENGINES:
        rows, figures = engine(CRANE, missions.told(CRANE, seed, 150))
        assert not figures.diverged, [row for row in rows if row.kind != "ask"]
        assert figures.told and not figures.followed


@pytest.mark.parametrize("event", ('{"report": "slew.turn", "outcome": "ok"}', '{"abort": "slew.turn"}'))
@pytest.mark.parametrize("blank", ([], ["", " "]))
@pytest.mark.parametrize("detail", ("idle", r"\"idle\""))
def test_a_report_or_an_abort_that_the_record_answers_as_invalid(event: str, blank: list[str], detail: str) -> None:
    actions = f'"actions": [{{"invalid": "not-active", "detail": "{detail}"}}]'
    inside = audit([f"{event[:-1]}, {actions}}}"])
    assert inside == ([], {"passed": 1, "told": 1})
    assert audit([event, *blank, f'{{"step": 1, {actions}}}']) == inside
    assert audit([event.replace("t", r"\u0074"), *blank, f'{{"step": 1, {actions}}}']) == inside
    for other in ('{"lost": 1}', '{"launch": "slew.park"}', '{"ask": "slew.park"}', '{"step": 1, "actions": []}'):
        rows, counts = audit([event, other, f"{{{actions}}}"])
        ran = any(row[1] == "ran" for row in rows)
        assert ran == event.startswith('{"report"') and ran != bool(counts.get("invalid")), other


@pytest.mark.parametrize("name", (None, "specs/rover.exo", "tests/specs/lab_automation.exo"))
def test_the_answers_of_a_simulation_do_not_diverge_wherever_they_stand(name: str | None) -> None:
    text = (ROOT / name).read_text(encoding="utf-8") if name else CRANE
    for seed in range(2 if name else 6):
        pairs = missions.simulated(text, seed, 150)
        inside = [b'{"event": %s, %s' % (event, answer[1:]) for event, answer in pairs if b"NaN" not in event]
        between = [line for pair in pairs for line in pair if b"NaN" not in pair[0]]
        assert sum(b'"invalid"' in line for line in between) > 40
        for engine in ENGINES:
            rows, figures = engine(text, between)
            assert not figures.diverged, [row for row in rows if row.kind != "ask"][:3]
            assert figures == engine(text, inside)[1]


@pytest.mark.parametrize("old", (LOOSE, FREE))
@pytest.mark.parametrize("make", (missions.told, missions.mixed))
def test_the_engines_agree_on_missions_under_other_rules(old: str, make: object) -> None:
    kinds = set()
    for seed in range(6):
        lines = make(old, seed, 200)  # type: ignore[operator]
        found = [shown(engine(CRANE, lines)) for engine in ENGINES]
        assert found[0] == found[1] == found[2], f"seed {seed}"
        kinds |= set(found[0][1].diverged)
    assert {"launched", "withheld"} <= kinds


@pytest.mark.parametrize("name", ("specs/rover.exo", "tests/specs/lab_automation.exo"))
def test_the_engines_agree_on_specs_of_teams(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    for seed in range(2):
        lines = missions.mixed(text, seed, 120)
        assert shown(by_reference(text, lines)) == shown(by_c(text, lines)), f"seed {seed}"
