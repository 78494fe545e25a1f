"""Two arms in one world: what one holds counts as well, and what two cannot do is refused."""

from dataclasses import replace

import numpy as np
import pytest
from handled import Handled

from topple.planner.decide.arrange import Order
from topple.planner.execution.demo import demo, loop_in
from topple.planner.execution.judge import Judge
from topple.planner.planning.holding import check_second
from topple.robots import robot as robot_named
from topple.robots import scenario, shapes
from topple.robots.arm.gripper import SUCTION
from topple.robots.engines import MUJOCO, arm_in
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.touch import Touch
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

UP = np.array([0.0, 0.0, 1.0])
BLOCK = Scene(
    {"table": np.array([[x, y, 0.0] for x in (0, 1) for y in (0, 1)]), "block": np.eye(3)},
    fixed=["table"],
    up=UP,
)


def test_what_is_held_may_be_touched_by_the_hand_that_holds_it_and_may_not_move():
    with World() as world:
        world.add_table()
        world.add(shapes.block("taken"), pose_at(0.1, 0.0, 0.0))
        world.add(shapes.block("held"), pose_at(0.0, 0.0, 0.0))
        first = SimulatedArm(world, robot_named("panda"), pose_at(-0.5, 0.0, 0.0))
        second = SimulatedArm(world, robot_named("panda"), pose_at(0.0, 0.6, 0.0), beside=first)
        judge = Judge(first, ["table"], UP, second=second)
        press = Touch(50.0, 1.0, {"panda_hand"}, 0.9)

        judge.begin(Handled("taken"), held="held")
        second.touched["held"] = first.touched["taken"] = press
        assert judge.verdict().violations == ()

        judge.begin(Handled("taken"), held="held")
        second.touched["taken"] = first.touched["held"] = press
        assert sorted(said.split(" by ")[0] for said in judge.verdict().violations) == [
            "held was hit",
            "taken was hit",
        ]

        judge.begin(Handled("taken"), held="held")
        world.place("held", pose_at(0.0, 0.02, 0.0))
        assert judge.verdict().violations == ("held moved 20 mm and turned 0 degrees",)
        assert first.on_step is second.on_step and first.on_step == []


def test_one_arm_keeps_its_place_while_the_other_acts_and_what_it_touches_is_noted():
    with World() as world:
        world.add_table()
        first = SimulatedArm(world, robot_named("panda"), pose_at(-0.5, 0.0, 0.0))
        second = SimulatedArm(world, robot_named("panda"), pose_at(0.5, 0.0, 0.0), beside=first)
        first.wait(0.5)
        assert np.abs(second.q - second.q_target).max() < 0.01
        x, y, z = second.link_pose("panda_hand")[:3, 3].tolist()
        world.add(shapes.block("block"), pose_at(x, y, z))
        first.step()
        assert "block" in second.touched and first.touched == {}


def test_what_two_arms_cannot_do_is_refused_in_a_line():
    with scenario("hold", 1) as stage:
        with pytest.raises(InvalidInput, match="leave out the other arm"):
            loop_in(stage, wrist_camera=True)
    cup = robot_named("panda-suction")
    with pytest.raises(InvalidInput, match="holds with a parallel jaw"):
        check_second(replace(cup, tools={SUCTION: cup.tools[SUCTION]}))


def test_two_arms_take_a_world_on_bullet():
    pytest.importorskip("mujoco")
    from topple.robots.mujoco.world import MujocoWorld

    with World() as world, MujocoWorld() as other:
        arm = robot_named("panda")
        first = arm_in(world, arm, np.eye(4))
        with pytest.raises(InvalidInput, match=f"found one on {MUJOCO}"):
            arm_in(other, arm, pose_at(1.0, 0.0, 0.0), first)


def test_an_orderer_is_told_of_the_second_arm_and_of_no_second_hand_otherwise():
    told: list[dict[str, object]] = []

    def orderer(situation: object, targets: object, /, **asked: object) -> Order:
        told.append(asked)
        raise InvalidInput("enough")

    with scenario("hold", 1) as stage:
        for arms in (1, 2):
            record = loop_in(stage, orderer=orderer, alone=arms == 1).run()
            assert "enough" in record.violations[0]
    assert "hands" not in told[0]
    assert told[1]["hands"] == 2


@pytest.mark.slow
def test_what_leans_on_each_other_comes_apart_by_two_arms(tmp_path):
    record = demo("hold", folder=tmp_path)
    assert record.success, record.violations
    held = [step for step in record.steps if "the other arm holds" in step.reason]
    assert held
    assert not (tmp_path / "plan.json").exists() and (tmp_path / "report.html").exists()
