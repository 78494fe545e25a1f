"""Every way to spoil a plan is noticed: a catalogue, tried on plans of three scenes for two hands."""

import json

import pytest

from topple.benchmarks.sabotages.catalogue import SPOILT, UNREADABLE
from topple.benchmarks.sabotages.caught import CASES, ROUGH, catch, planned, scene_for
from topple.planner.planning.plan_format import plan_from_json, plan_to_json
from topple.planner.verify import Verification, verify
from topple.topology.base.errors import InvalidInput


def beyond(checked: Verification) -> list[str]:
    return [f"{each.name}: {each.value:.3g} {each.unit}, {each.witness}" for each in checked.failed]


BOTH = [pytest.param(*case, marks=() if case == CASES[0] else pytest.mark.slow) for case in CASES]


@pytest.mark.parametrize(("goal", "arm"), BOTH)
def test_an_honest_plan_holds(goal, arm):
    checked = verify(planned(goal, arm), scene_for(goal), step=ROUGH)
    assert checked.ok, beyond(checked)


def test_some_sabotages_are_caught_and_told_of():
    found = catch(CASES[0], every=12)
    assert found.tried > len(SPOILT) // 12 - 3
    assert not found.escaped


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_every_sabotage_is_caught_and_told_of(case):
    # Each on two plans, of different scenes and hands; `topple bench reliability` tries each on all six.
    found = catch(case, every=3, first=CASES.index(case) % 3)
    assert found.tried > len(SPOILT) // 3 - 6
    assert not found.escaped


@pytest.mark.parametrize("spoil", UNREADABLE, ids=lambda spoil: str(spoil.__name__))
def test_what_is_no_plan_is_refused_by_path(spoil):
    document = json.loads(plan_to_json(planned(*CASES[0])))
    spoil(document)  # type: ignore[operator]
    with pytest.raises(InvalidInput, match=r"`\$\.steps\[\d\]"):
        plan_from_json(json.dumps(document))
