"""Runs in which what is taken goes into a bin, onto an area, out to somebody, or only clear of everything."""

from functools import partial

import numpy as np
import pytest
from on_table import BASE

from topple.benchmarks.sabotages.caught import CASES, scene_for
from topple.planner import run
from topple.planner.execution.loop import ClosedLoop
from topple.planner.execution.rehearsal import Rehearsal
from topple.planner.placement.away import BODIES, Away, Destination
from topple.robots.catalog import robot
from topple.robots.engines import arm_in
from topple.robots.poses import inverse
from topple.topology.situation.situation import Situation

SCENE = scene_for(CASES[0][0])  # a block on a block


SLOW = [
    pytest.param(each, marks=pytest.mark.slow)
    for each in ("lift", ("zone", 0.0, 0.25, 0.5, 0.55), ("hand-over", 0.35, -0.35, 0.45))
]


@pytest.mark.parametrize("away", ["bin", *SLOW], ids=str)
def test_both_blocks_go_there_and_nothing_else_moves(away):
    record = run(SCENE, ["lower"], "panda", pose_base_to_world=BASE, away=away)
    assert record.success, record.violations
    assert [step.object for step in record.steps if step.success] == ["upper", "lower"]
    assert all(step.relations_as_predicted for step in record.steps)
    assert record.scene is not None
    assert {"upper", "lower"}.isdisjoint(record.scene.names) == (away[0] != "zone")


def test_a_bin_that_is_not_there_is_told_by_where_things_truly_are():
    arm = robot("panda")
    with Rehearsal.of(SCENE, arm, BASE) as stage:
        base = inverse(stage.pose_scene_to_world) @ stage.pose_base_to_world
        receiver = Destination.of("bin").at(Situation(SCENE), base).move(stage.pose_scene_to_world)
        acting = arm_in(stage.world, arm, stage.pose_base_to_world)
        loop = ClosedLoop.simulated(
            stage.world,
            acting,
            stage.cameras,
            ["upper"],
            fixed=tuple(sorted(stage.world.fixed)),
            away=receiver,
        )
        name = BODIES[Away.BIN]
        body, far = stage.world.body(name), np.eye(4)
        far[0, 3] = 30.0
        look = loop.look()  # it was there, and somebody takes it away
        stage.world.remove(name)
        stage.world.add(body, far, fixed=True)
        record = loop.run(look)
    assert not record.success
    assert any("it is not in the bin" in text for text in record.violations)


def test_what_is_lifted_is_left_to_a_skill_of_ones_own():
    arm, handed = robot("panda"), list[tuple[str, float]]()
    with Rehearsal.of(SCENE, arm, BASE) as stage:
        base = inverse(stage.pose_scene_to_world) @ stage.pose_base_to_world
        receiver = Destination.of("lift").at(Situation(SCENE), base).move(stage.pose_scene_to_world)
        acting = arm_in(stage.world, arm, stage.pose_base_to_world)
        fixed = tuple(sorted(stage.world.fixed))
        loop = ClosedLoop.simulated(stage.world, acting, stage.cameras, ["upper"], fixed=fixed, away=receiver)
        usual = loop.hand_on
        assert usual is not None

        def note(skill: partial[None], name: str) -> None:
            handed.append((name, float(stage.world.pose(name)[2, 3])))
            skill(name)

        low = float(stage.world.pose("upper")[2, 3])
        loop.hand_on = partial(note, usual)  # type: ignore[arg-type]
        assert loop.run().success
    ((name, high),) = handed
    assert name == "upper" and high > low + 0.15
