"""A scene acted out: the tower comes apart in the safe order, nothing else moves, and nothing is faked."""

from pathlib import Path

import numpy as np
import pytest

from topple.planner import run
from topple.planner.execution.judge import hits, violations
from topple.planner.execution.loop import ClosedLoop
from topple.planner.formats.run_record import RunRecord
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.touch import Touch
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.scene.scene import Scene


def block(x: float, y: float, z: float, side: float) -> FloatArray:
    """Points on all faces of a cube that stands on height z."""
    line = np.linspace(-side / 2, side / 2, 21)
    u, v = (grid.ravel() for grid in np.meshgrid(line, line))
    faces = [
        np.insert(np.column_stack([u, v]), axis, np.full(len(u), end), axis=1)
        for axis in range(3)
        for end in (-side / 2, side / 2)
    ]
    return np.concatenate(faces) + np.array([x, y, z + side / 2])


@pytest.fixture(scope="module")
def tower() -> Scene:
    ground = np.mgrid[-0.6:0.6:0.01, -0.5:0.5:0.01].reshape(2, -1).T
    table = np.column_stack([ground, np.zeros(len(ground))])
    clouds = {
        "table": table,
        "base": block(0.0, 0.0, 0.0, 0.055),
        "top": block(0.0, 0.0, 0.055, 0.045),
        "aside": block(0.0, 0.2, 0.0, 0.05),
    }
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


@pytest.fixture(scope="module")
def record(tower: Scene) -> RunRecord:
    return run(tower, ["base"], "panda", seed=1)


@pytest.mark.slow
def test_what_stands_on_the_target_goes_first_and_nothing_else_is_touched(record):
    assert record.success, record.violations
    done = [(step.object, step.action) for step in record.steps if step.success]  # fingers may miss once
    assert done == [("top", "remove"), ("base", "free")]
    assert all(step.disturbed for step in record.steps)
    assert all(distance < 0.01 for step in record.steps for distance, _ in step.disturbed.values())


@pytest.mark.slow
def test_a_run_is_told_in_the_contracts_words(record):
    told = record.to_json()
    assert told["format"] == "topple.run" and told["format_version"] == 1 and told["success"] is True
    assert {
        "object",
        "action",
        "success",
        "attempts",
        "disturbed",
        "relations_as_predicted",
        "seconds",
    } <= set(told["steps"][0])
    assert any("base stands at" in note for note in record.notes)


def test_unknown_targets_and_scenes_without_a_table_are_refused(tower):
    with pytest.raises(UnknownObject, match="'plate'"):
        run(tower, ["plate"], "panda")
    with pytest.raises(InvalidInput, match="fixed=NAME"):
        run(Scene({"a": tower.clouds["aside"]}, up=[0, 0, 1]), ["a"], "panda")


def test_a_target_no_camera_sees_is_refused():
    with World() as world:
        world.add_table()
        pose = np.eye(4)
        pose[0, 3] = 0.4
        world.add(shapes.can("can"), pose)
        arm = SimulatedArm(world, robot("panda"), np.eye(4))
        from topple.robots.world.camera import Camera

        away = Camera.looking_at((1.0, 0.0, 0.5), (2.0, 0.0, 0.0))
        with pytest.raises(InvalidInput):
            ClosedLoop.simulated(world, arm, [away], "free can").run()


def test_a_step_is_judged_by_what_moved_fell_or_was_hit():
    still, moved, fallen = (np.eye(4) for _ in range(3))
    moved[0, 3], fallen[:3, 3] = 0.02, (0.02, 0.0, -0.1)
    before = {"a": still, "b": still, "c": still, "held": still}
    after = {"a": still, "b": moved, "c": fallen, "held": fallen}
    found = [*violations(before, after, ["held"]), *hits({"a": Touch(9.0, 1.0, {"hand"}, 0.9)})]
    assert len(found) == 3
    assert "b moved 20 mm" in found[0] and "c fell by 10 cm" in found[1] and "a was hit by hand" in found[2]


def test_nothing_in_the_loop_places_objects_or_switches_collisions_off():
    import topple.planner.execution.execute
    import topple.robots.world.simulated_arm
    import topple.robots.world.vacuum

    for module in (topple.robots.world.simulated_arm, topple.robots.world.vacuum):
        text = Path(str(module.__file__)).read_text(encoding="utf-8")
        assert "resetBasePositionAndOrientation" not in text and "setCollisionFilter" not in text
    loop = Path(str(topple.planner.execution.execute.__file__)).read_text(encoding="utf-8")
    assert ".place(" not in loop and "pybullet" not in loop
