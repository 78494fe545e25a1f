"""Plans of small scenes, spoilt in every way of the catalogue: what verification and reading notice."""

import json
import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from topple.benchmarks.sabotages.catalogue import OTHER_SCENES, SPOILT, UNREADABLE
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.verify import verify
from topple.robots.shapes.boxes import box
from topple.robots.shapes.fruit import lemon
from topple.robots.shapes.tableware import bowl
from topple.robots.world.bodies import Body
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

BASE = np.eye(4)
BASE[0, 3] = -0.5  # [m] an arm there reaches everything
ROUGH = 0.06  # [rad] between two states that are looked at: what is broken here is broken everywhere


@dataclass(frozen=True)
class Caught:
    """What became of the sabotages of one plan.

    Attributes:
        plan: Goal and arm.
        tried: How many could be applied to it.
        escaped: Names of those that nobody noticed.
    """

    plan: str
    tried: int
    escaped: tuple[str, ...]


def on_table(**bodies: tuple[Body, tuple[float, float, float]]) -> Scene:
    """A table, a tall box that stands aside, and some bodies, each with its place [m]."""
    axis = np.arange(-0.45, 0.45, 0.008)
    x, y = np.meshgrid(axis, axis)
    clouds: dict[str, FloatArray] = {"table": np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])}
    tall = box("tall", (0.08, 0.08, 0.25)), (0.05, 0.3, 0.0)
    for number, (name, (body, place)) in enumerate({**bodies, "tall": tall}.items()):
        clouds[name] = body.surface(2000, np.random.default_rng(number)) + np.array(place)
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


def _block(name: str, size: float) -> Body:
    return box(name, (size, size, size))


@cache
def scene_for(goal: str) -> Scene:
    """The scene of a goal of `GOALS`."""
    if goal == "free lower":
        upper = _block("upper", 0.05), (0.0, 0.0, 0.0605)
        return on_table(lower=(_block("lower", 0.06), (0.0, 0.0, 0.0)), upper=upper)
    if goal == "red on green":
        return on_table(
            green=(_block("green", 0.06), (0.0, 0.0, 0.0)),
            red=(_block("red", 0.05), (0.1, -0.15, 0.0)),
            other=(_block("other", 0.05), (0.1, -0.15, 0.0505)),
        )
    return on_table(bowl=(bowl("bowl"), (0.05, -0.05, 0.0)), lemon=(lemon("lemon"), (0.0, 0.15, 0.0)))


GOALS = ("free lower", "red on green", "lemon within bowl")
CASES = tuple((goal, arm) for goal in GOALS for arm in ("panda", "panda-suction"))
"""Goals and arms that plans are made for."""


@cache
def planned(goal: str, arm: str) -> Plan:
    """A plan of one of `CASES`."""
    return plan(scene_for(goal), goal, arm, pose_base_to_world=BASE)


def catch(case: tuple[str, str], every: int = 1, first: int = 0) -> Caught:
    """Spoil a plan in every way, and see what is noticed.

    Args:
        case: One of `CASES`.
        every: Which of the ways are tried: 3 for every third.
        first: The first of them.

    Returns:
        What was noticed.
    """
    goal, arm = case
    made = planned(goal, arm)
    some = slice(first, None, every)
    tried, escaped = _spoilt(made, Situation(scene_for(goal)), some)
    for unreadable in UNREADABLE[some]:
        document = json.loads(plan_to_json(made))
        if unreadable(document) is False:
            continue
        tried += 1
        try:
            plan_from_json(json.dumps(document))
            escaped.append(unreadable.__name__)
        except InvalidInput:
            pass
    for other in OTHER_SCENES[some]:
        tried += 1
        if verify(made, other(scene_for(goal), made.steps[-1].object), step=ROUGH).ok:
            escaped.append(other.__name__)
    return Caught(f"{goal}, {arm}", tried, tuple(escaped))


def _spoilt(made: Plan, situation: Situation, some: slice) -> tuple[int, list[str]]:
    """How many ways to spoil a plan could be tried, and which of them nobody noticed."""
    tried, escaped = 0, list[str]()
    for spoil in SPOILT[some]:
        document = json.loads(plan_to_json(made))
        if spoil(document) is False:
            continue
        tried += 1
        try:
            checked = verify(plan_from_json(json.dumps(document)), situation, step=ROUGH)
        except InvalidInput:
            continue
        told = all(math.isfinite(each.value) and each.witness for each in checked.failed)
        if checked.ok or not checked.refuted or not told:
            escaped.append(spoil.__name__)
    return tried, escaped
