"""A report with findings of every kind."""

from exover.checks.finding import Finding
from exover.diagnostics import Severity
from exover.loop.claim import Verdict
from exover.model.event import Ask, Killed, Launched, Observe, Report, Violated, Waits
from exover.model.model import Location, Model, Parameter, Request, Variable
from exover.model.trace import Moment, Trace
from exover.model.types import Enum, Int, Real
from exover.report.summary import ModelFigures, Summary, TableFigures

HERE = Location("specs/demo.exo", 3, 5)
MODEL = Model(
    "demo",
    (
        Request("nd.goto", (Parameter("x", Real()), Parameter("to", Enum(("base", "dock")))), instances=2),
        Request("nd.stop", results=(Parameter("dist", Real()),)),
    ),
    (Variable("battery", "poster", Int(0, 100), 100, fallback=0),),
    (),
    (),
    (),
    (),
)
LASSO = Trace(
    (
        Moment(Ask("nd.goto", (1.0, "dock")), (Launched("nd.goto", 1, (1.0, "dock")),)),
        Moment(Ask("nd.stop"), (Killed("nd.goto", 1, "drive"), Waits("nd.stop", "drive", "a stop\x1b is a stop"))),
        Moment(Report("nd.stop", 0, "ok", (0.5,)), ()),
        Moment(Observe("battery", 0, broken=True), (Violated("low", "empty"),)),
    ),
    loop_start=1,
)


def finding(check: str, severity: Severity, verdict: Verdict, trace: Trace | None = None) -> Finding:
    return Finding(check, "nd.stop", severity, verdict, "bdd", "reachable set", "it waits for ever", HERE, trace, 0.25)


def summary(*findings: Finding) -> Summary:
    figures = ModelFigures(requests=2, rules=1, state_bits=9)
    return Summary("1.2.3", "specs/demo.exo", MODEL, findings, figures, TableFigures(4, 3, 1, 512, 64, "ab" * 32))


FOUR = summary(
    finding("safety", "error", "holds"),
    finding("deadlock", "error", "violated", LASSO),
    finding("deadlock", "error", "holds"),
    finding("lockout", "warning", "unknown"),
)
