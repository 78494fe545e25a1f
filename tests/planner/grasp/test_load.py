import numpy as np
import pytest
from moving import FLIP, Way, at, down, straight
from on_table import on_table
from trimesh.transformations import euler_matrix

from topple.planner.grasp import grasp_candidates
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.load import chance_to_hold, jaw_load, weight_of
from topple.planner.grasp.suction import cup_load, cup_shape
from topple.planner.grasp.surroundings import Dropped
from topple.robots.arm.cup import vacuum_load
from topple.robots.catalog import robot
from topple.robots.poses import angle_between
from topple.robots.shapes.boxes import box
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.scene.scene import Scene
from topple.topology.statics.tolerances import DENSITY

HAND, CUP = hand_shape(robot("panda")), cup_shape(robot("panda-suction")).cup
DOWN = np.array([[0.0, 0.0, 1.0]])  # a hand from above comes in along gravity
SIZE = (0.24, 0.05, 0.06)


def load(arm: tuple[float, float, float], weight: float, friction: float = 0.5) -> float:
    width, depth = np.array([SIZE[1]]), np.array([0.018])
    return float(jaw_load(np.array([arm]), DOWN, weight, width, depth, HAND, friction)[0])


def test_what_hangs_below_the_pads_does_not_turn():
    weight = 2.0 * 0.5 * HAND.force  # all that friction carries
    assert load((0.0, 0.0, 0.05), weight) == pytest.approx(1.0)


def test_pads_hold_a_moment_of_their_friction_times_its_lever():
    held = 2.0 * 0.5 * HAND.force * HAND.give
    assert load((0.04, 0.0, 0.0), 0.9 * held / 0.04) < 1.0
    assert load((0.04, 0.0, 0.0), 1.1 * held / 0.04) > 1.0
    assert load((0.0, 0.02, 0.0), 1.1 * held / 0.04) < 1.0, "between the pads it hangs on both of them"


def test_a_cup_peels_off_with_its_force_or_its_moment():
    assert CUP.max_force == pytest.approx(42.4, abs=0.1)
    assert cup_load(0.0, CUP.max_force, CUP) == pytest.approx(1.0)
    assert cup_load(CUP.radius, CUP.max_force / 2.0, CUP) == pytest.approx(1.0)


def test_a_cup_holds_across_its_axis_what_friction_bears():
    """The load cases of a cup: lifting, moving aside, and holding a wall."""
    weight = 8.0
    assert cup_load(0.0, weight, CUP) == pytest.approx(weight / CUP.max_force)
    assert cup_load(0.0, weight, CUP, np.pi / 2) == pytest.approx(weight / 0.5 / CUP.max_force)
    for pull, shear in ((8.0, 0.0), (8.0, 4.0), (-10.0, 15.0)):
        held = vacuum_load(pull, shear, 0.0, 0.0, force=42.0, radius=0.015, friction=0.5)
        assert held == pytest.approx((pull + shear / 0.5) / 42.0)
    assert vacuum_load(0.0, 0.0, 0.0, 0.1, force=42.0, radius=0.015, friction=0.5) > 0.3, (
        "turning shears the lip"
    )


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [0.0, 12.0, 50.0, 90.0])
def test_a_cup_drops_in_simulation_what_the_planner_says_it_does_not_hold(tilt):
    """A slab of 2 kg, lifted level and then turned."""
    arm, mass, thick = robot("panda-suction"), 2.0, 0.02
    turn = np.radians(tilt)
    load = cup_load(thick / 2.0 * np.sin(turn), 9.81 * mass, CUP, turn)
    assert not 0.85 < load < 1.15, "neither is sure"
    with World() as world:
        world.add_table()
        world.add(box("slab", (0.08, 0.08, thick), mass=mass), at(0.5, 0.0, 0.0))
        world.settle()
        hand = SimulatedArm(world, arm, np.eye(4), q=arm.inverse(down(0.5, 0.0, 0.15), "suction")[0][0])
        assert arm.cup is not None
        hand.extend(arm.cup.stroke)
        straight(hand, down(0.5, 0.0, 0.15), down(0.5, 0.0, thick), "suction")
        assert hand.suck()
        gently(hand, [down(0.5, 0.0, z) for z in np.linspace(thick, 0.4, 20)])
        assert hand.holding, "level it holds"
        tilts = np.linspace(0.0, turn, 20)
        gently(hand, [at(0.5, 0.0, 0.4) @ euler_matrix(0.0, -angle, 0.0) @ FLIP for angle in tilts])
        hand.wait(0.5)
        assert hand.holding == (load < 1.0)


def gently(hand: SimulatedArm, poses: list[np.ndarray]) -> None:
    """Lead the cup through poses in three seconds, without a jerk."""
    states = [hand.q_target]
    for pose in poses:
        states.append(hand.arm.inverse(pose, "suction", near=states[-1])[0][0])
    u = np.linspace(0.0, 1.0, 60)
    where = (3.0 - 2.0 * u) * u * u * (len(states) - 1)
    hand.follow(Way(np.array([np.interp(where, range(len(states)), q) for q in np.array(states).T]).T, 3.0))


def test_what_cannot_hold_scores_below_what_can():
    assert chance_to_hold(0.0) == 1.0
    assert chance_to_hold(0.5) == pytest.approx(0.95, abs=0.01), "half of it by the guess"
    assert chance_to_hold(1.0) == pytest.approx(0.5), "as likely too heavy as not"
    assert chance_to_hold(2.0) == pytest.approx(0.05, abs=0.01), "if it is half as heavy as guessed"
    assert np.all(np.diff(chance_to_hold(np.linspace(0.3, 5.0, 20))) < 0.0)


def bar() -> Scene:
    return on_table((box("bar", SIZE), (0.0, 0.0, 0.0)), points=6000, half=0.4)


def test_grasps_that_a_heavy_bar_would_turn_in_come_last_and_say_so():
    weight = weight_of(float(np.prod(SIZE)))
    assert weight == pytest.approx(9.81 * DENSITY * 0.24 * 0.05 * 0.06)
    grasps = grasp_candidates("bar", bar(), robot("panda"), limit=300)
    aside = np.array([abs(float(grasp.pose_tool_to_world[0, 3])) for grasp in grasps])
    holding = np.array(["its weight takes" not in grasp.reason for grasp in grasps])
    surely = 2.0 * 0.5 * HAND.force * HAND.give / weight
    assert aside[0] < 0.01
    assert aside[holding].max() < surely + 0.005
    assert aside[~holding].min() > surely - 0.005
    rank = np.arange(len(grasps))
    assert rank[holding].max() < rank[aside > 2.0 * surely].min()


def turned(share: float) -> float:
    """By how many degrees a bar turns, lifted 10 cm beside its middle, at a share of what pads hold."""
    arm, aside = robot("panda"), 0.10
    low, high = down(0.5 + aside, 0.0, 0.045), down(0.5 + aside, 0.0, 0.15)
    weight = share / load((aside, 0.0, 0.0), 1.0)
    with World() as world:
        world.add_table()
        world.add(box("bar", SIZE, mass=weight / 9.81), at(0.5, 0.0, 0.0))
        world.settle()
        hand = SimulatedArm(world, arm, np.eye(4), q=arm.inverse(high, "fingers")[0][0])
        straight(hand, high, low)
        hand.close(HAND.force)
        before = world.pose("bar")
        straight(hand, low, high)
        hand.wait(0.3)
        assert hand.holding
        return float(np.degrees(angle_between(before, world.pose("bar"))))


@pytest.mark.slow
def test_a_bar_turns_between_the_pads_where_the_load_says_so():
    assert turned(0.9) < 1.0
    # flat faces hold several times as much as the round ones that are reckoned with
    assert turned(6.0) > 10.0


def test_a_given_mass_decides_what_holds():
    light, heavy = (bar().weighed({"bar": mass}) for mass in (0.05, 1.0))
    best = [grasp_candidates("bar", scene, robot("panda"), limit=300) for scene in (light, heavy)]
    assert not any("its weight takes" in grasp.reason for grasp in best[0])
    turning = [grasp for grasp in best[1] if "its weight takes" in grasp.reason]
    assert turning
    assert abs(float(best[1][0].pose_tool_to_world[0, 3])) < 0.01
    assert max(grasp.score for grasp in turning) < best[1][0].score


@pytest.mark.parametrize("arm", ["panda", "panda-suction"])
def test_what_is_heavier_than_the_hand_holds_has_no_grasp_and_the_search_says_why(arm):
    dropped = Dropped()
    assert grasp_candidates("bar", bar().weighed({"bar": 60.0}), robot(arm), dropped=dropped) == []
    assert any(reason.startswith("60 kg are more than the") for reason in dropped.reasons)
    assert grasp_candidates("bar", bar(), robot(arm))


def test_a_slippery_thing_is_held_less_than_a_rough_one():
    mass = 0.9 * 2.0 * 0.3 * HAND.force / 9.81
    rough, slippery = (bar().weighed({"bar": mass}, {"bar": mu}) for mu in (0.8, 0.2))
    assert grasp_candidates("bar", rough, robot("panda"))
    assert grasp_candidates("bar", slippery, robot("panda")) == []
