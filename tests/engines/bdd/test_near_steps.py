"""Steps near some variables are the steps of the loop that leave all else idle."""

from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.engines.bdd.near_steps import BUSY, NearSteps
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.semantics import Reference
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

SEEDS = (*range(10), 11, 12, 14, 15)


def test_near_steps_are_those_of_the_loop_that_leave_all_else_idle() -> None:
    idle_elsewhere, compared = 0, 0
    for seed in SEEDS:
        made = compiled(model_of(small_spec_of(seed)))
        analysis = Analysis(made, Reference(made.model), lambda what: None)
        try:
            stepper, space = analysis.stepper, analysis.space
        except TooLarge:
            continue
        for request, waits in enumerate(analysis.loop.may_wait):
            if not waits:
                continue
            backwards = BackwardReachability(stepper, stepper.universe, None)
            looked_at = analysis.loop.body[analysis.loop.settling(request)].reads
            mark = ("left", made.model.requests[request].name)
            near = NearSteps(stepper, backwards, looked_at).avoiding(mark)
            idle = stepper.universe
            for number, variable in enumerate(analysis.loop.variables):
                if variable.key[0] in BUSY and number not in looked_at:
                    idle_elsewhere += 1
                    idle &= space.is_value(number, 0)
            for number in near.events:
                for var in sorted(looked_at):
                    states = space.is_value(var, 0)
                    whole = stepper.pre(states & idle, number, avoid=mark)
                    assert near.pre(states, number) & idle == whole & idle, (seed, request, number, var)
                    compared += whole & idle != space.none
    assert compared > 100
    assert idle_elsewhere > 10
