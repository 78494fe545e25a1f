"""Every way to spoil a plan is noticed: a catalogue, tried on plans of three scenes for two hands."""

import json
import math

import numpy as np
import pytest
from sabotages import OTHER_SCENES, SPOILT, UNREADABLE

from topple.planner.formats.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.planning.plan import plan
from topple.planner.verify import Verification, verify
from topple.robots.shapes.boxes import box
from topple.robots.shapes.fruit import lemon
from topple.robots.shapes.tableware import bowl
from topple.robots.world.bodies import Body
from topple.topology.arrays import FloatArray
from topple.topology.errors import InvalidInput
from topple.topology.scene import Scene
from topple.topology.situation import Situation

BASE = np.eye(4)
BASE[0, 3] = -0.5
ROUGH = 0.06  # [rad]: what is broken here is broken everywhere


def on_table(**bodies: tuple[Body, tuple[float, float, float]]) -> Scene:
    """A table, a tall box that stands aside, and some bodies."""
    axis = np.arange(-0.45, 0.45, 0.008)
    x, y = np.meshgrid(axis, axis)
    clouds: dict[str, FloatArray] = {"table": np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])}
    tall = box("tall", (0.08, 0.08, 0.25)), (0.05, 0.3, 0.0)
    for number, (name, (body, place)) in enumerate({**bodies, "tall": tall}.items()):
        clouds[name] = body.surface(2000, np.random.default_rng(number)) + np.array(place)
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


def block(name: str, size: float) -> Body:
    return box(name, (size, size, size))


SCENES = {
    "free lower": on_table(
        lower=(block("lower", 0.06), (0.0, 0.0, 0.0)), upper=(block("upper", 0.05), (0.0, 0.0, 0.0605))
    ),
    "red on green": on_table(
        green=(block("green", 0.06), (0.0, 0.0, 0.0)),
        red=(block("red", 0.05), (0.1, -0.15, 0.0)),
        other=(block("other", 0.05), (0.1, -0.15, 0.0505)),
    ),
    "lemon within bowl": on_table(
        bowl=(bowl("bowl"), (0.05, -0.05, 0.0)), lemon=(lemon("lemon"), (0.0, 0.15, 0.0))
    ),
}
_PLANS: dict[tuple[str, str], Plan] = {}


def planned(goal: str, arm: str) -> Plan:
    if (goal, arm) not in _PLANS:
        _PLANS[goal, arm] = plan(SCENES[goal], goal, arm, base=BASE, check=False)
    return _PLANS[goal, arm]


def beyond(checked: Verification) -> list[str]:
    return [f"{each.name}: {each.value:.3g} {each.unit}, {each.witness}" for each in checked.failed]


CASES = [(goal, arm) for goal in SCENES for arm in ("panda", "panda-suction")]
BOTH = [pytest.param(*case, marks=() if case == CASES[0] else pytest.mark.slow) for case in CASES]


@pytest.mark.parametrize(("goal", "arm"), BOTH)
def test_an_honest_plan_holds(goal: str, arm: str) -> None:
    checked = verify(planned(goal, arm), SCENES[goal], step=ROUGH)
    assert checked.ok, beyond(checked)


@pytest.mark.parametrize(("goal", "arm"), BOTH)
def test_every_sabotage_is_caught_and_told_of(goal: str, arm: str) -> None:
    made, escaped, tried = planned(goal, arm), list[str](), 0
    situation = Situation(SCENES[goal])
    for spoil in SPOILT:
        document = json.loads(plan_to_json(made))
        if spoil(document) is False:
            continue
        tried += 1
        try:
            checked = verify(plan_from_json(json.dumps(document)), situation, step=ROUGH)
        except InvalidInput as error:
            assert str(error), spoil.__name__
            continue
        if checked.ok or not all(math.isfinite(each.value) and each.witness for each in checked.failed):
            escaped.append(spoil.__name__)
    assert tried > len(SPOILT) - 12
    assert not escaped


@pytest.mark.parametrize("spoil", UNREADABLE, ids=lambda spoil: str(spoil.__name__))
def test_what_is_no_plan_is_refused_by_path(spoil: object) -> None:
    document = json.loads(plan_to_json(planned(*CASES[0])))
    spoil(document)  # type: ignore[operator]
    with pytest.raises(InvalidInput, match=r"`\$\.steps\[\d\]"):
        plan_from_json(json.dumps(document))


@pytest.mark.parametrize(("goal", "arm"), BOTH)
def test_a_plan_of_another_scene_is_refuted(goal: str, arm: str) -> None:
    made = planned(goal, arm)
    target = made.steps[-1].object
    for other in OTHER_SCENES:
        checked = verify(made, other(SCENES[goal], target), step=ROUGH)
        assert checked.failed, other.__name__
