"""No document contradicts itself: orders and plans keep to their own dependencies, and say what is moved."""

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace

import pytest
from documents import contradictions
from msgspec import to_builtins

from topple.planner.decide.arrange import Order
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.decide.goal import Goal
from topple.planner.decide.hold import Hold
from topple.planner.decide.words import order_in_words, places
from topple.planner.errors import NoSafePlan
from topple.planner.execution.demo import loop_in
from topple.planner.planning.order import cautious
from topple.planner.planning.plan import plan
from topple.planner.planning.step import Chooser, Context, NextStep, Task
from topple.planner.planning.two_handed import plan_two_handed
from topple.robots import scenario
from topple.robots.scenarios import SCENARIOS
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

SEEDS, WHOLE = 10, 2
"""Seeds of each scene, and how many of them are planned to the end: of the others the first step is."""


@dataclass
class Watched:
    """A task whose steps are kept as they are chosen, and which is done after so many."""

    task: Task
    most: float = math.inf
    steps: list[NextStep] = field(default_factory=list[NextStep])
    _chooser: Chooser | None = None

    def in_frame(self, pose: FloatArray, up: FloatArray, /) -> Task:
        return self.task.in_frame(pose, up)

    def goal(self, scene: Scene) -> Goal:
        return self.task.goal(scene)

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        self._chooser = self.task.chooser(situation, goal, context)
        return self

    def unmet(self) -> tuple[str, ...]:
        assert self._chooser is not None
        return () if len(self.steps) >= self.most else self._chooser.unmet()

    def choose(self) -> NextStep | None:
        assert self._chooser is not None
        step = None if len(self.steps) >= self.most else self._chooser.choose()
        self.steps += [] if step is None else [step, *step.then]
        return step


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(SEEDS))
@pytest.mark.parametrize("name", list(SCENARIOS))
def test_the_orders_and_the_plan_of_a_demo_do_not_contradict_themselves(name, seed):
    with scenario(name, seed) as stage:
        loop = loop_in(stage, seed=seed)
        scene, watched = loop.look().scene, Watched(loop.task, math.inf if seed < WHOLE else 1)
        base, second = stage.pose_base_to_world, stage.pose_second_to_world
        with suppress(NoSafePlan):  # what the first look hides, later ones may show; what was chosen is kept
            if second is not None:
                both = {"pose_base_to_world": base, "pose_second_to_world": second}
                plan_two_handed(scene, watched, stage.robot, **both, allow_drop=True)
            else:
                made = plan(scene, watched, stage.robot, pose_base_to_world=base, orderer=cautious, seed=seed)
                document = {"order": made.order, "dependencies": to_builtins(made.dependencies)}
                assert contradictions(document, [step.object for step in made.steps]) == []
    assert watched.steps or name == "hold"
    for step in watched.steps:
        assert contradictions(step.order.to_json(), [step.transfer.object]) == []


EDGES = (Dependency("top", "low", "supported", 1.0), Dependency("left", "low", "leaning", 0.3))
FOUND = Order(
    ("low",),
    ("top", "left", "low"),
    DependencyGraph(("top", "left", "low"), EDGES),
    (), (), (), {"top": 0.1, "left": 0.2, "low": 0.3},
    holds=(Hold("low", "left", "low", "it leans"),),
)  # fmt: skip


def test_what_the_arm_takes_first_is_the_first_of_its_order_and_told_so():
    found = FOUND.as_taken(("left", "top", "low"))
    assert contradictions(found.to_json(), ["left"]) == []
    assert [line.partition(":")[0] for line in found.explanation] == ["1. left", "2. top", "3. low"]
    assert [name for name, _ in order_in_words(found.to_json())] == ["left", "top", "low"]


def test_what_is_taken_is_no_longer_in_what_is_left():
    left = FOUND.as_taken(("low",)).to_json()
    assert left["order"] == ["low"] and left["dependencies"] == left["holds"] == []
    assert left["risk"] == {"low": 0.3}


def test_what_is_left_of_a_group_is_one_while_it_holds_itself():
    pairs = (("weight", "plank"), ("plank", "weight"), ("load", "plank"), ("plank", "load"))
    graph = DependencyGraph(("weight", "load", "plank"), tuple(Dependency(*p, "leaning", 0.8) for p in pairs))
    found = replace(FOUND, order=graph.names, graph=graph, groups=(graph.names,), holds=())
    left = found.as_taken(("load", "plank")).to_json()
    assert left["groups"] == [["load", "plank"]] and contradictions(left, ["load"]) == []
    assert found.as_taken(("plank",)).to_json()["groups"] == []


def test_badges_count_the_moves_of_what_makes_room():
    assert places({"order": ["cup", "plate", "cup", "fork"]}) == {"cup": 1, "plate": 2, "fork": 4}


def test_a_document_against_itself_is_found():
    edge = {"first": "top", "then": "low"}
    assert contradictions({"order": ["low", "top"], "dependencies": [edge]}, ["low"])
    assert contradictions({"order": ["low"], "dependencies": [edge]}, ["low"])
    assert contradictions({"order": ["top", "low"], "dependencies": [edge]}, ["low"])
    held = {"order": ["low", "top"], "dependencies": [edge], "groups": [["low", "top"]]}
    assert contradictions(held, ["low"]) == []
