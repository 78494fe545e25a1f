"""A vacuum on MuJoCo seals, holds and lets go by the same rule as on PyBullet."""

from collections.abc import Iterator

import numpy as np
import pytest
from cup_down import FLAT, LOADS, RAMP, loaded, lowered
from moving import at

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install '.[mujoco]'")

from topple.robots import scenario
from topple.robots.mujoco.world import MujocoWorld
from topple.robots.shapes import block, plate
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.bodies import Body
from topple.robots.world.clamps import Clamps
from topple.topology import UnknownObject


@pytest.fixture
def lifted() -> Iterator[ActingArm]:
    """An arm whose cup holds a plate 5 cm above a table."""
    with MujocoWorld() as world:
        arm, up = lowered(world, plate("plate"), FLAT)
        assert arm.suck() and arm.sealed
        arm.follow(up)
        arm.wait(0.3)
        assert arm.holding
        assert world.pose("plate")[2, 3] == pytest.approx(0.05, abs=0.002)
        yield arm


def test_a_held_plate_weighs_what_it_weighs_and_falls_when_let_go(lifted):
    assert lifted.vacuum is not None
    force, moment = lifted.vacuum.load()
    weight = lifted.world.body("plate").mass * 9.81
    assert force == pytest.approx([0.0, 0.0, -weight], abs=0.02 * weight)
    assert np.abs(moment).max() < 0.01
    lifted.release()
    lifted.wait(0.5)
    assert not lifted.holding and lifted.sealed is None
    assert lifted.world.pose("plate")[2, 3] < 0.001


@pytest.mark.parametrize(("pull", "shear", "twist", "held"), LOADS)
def test_a_cup_holds_up_to_its_force_and_its_moment(lifted, pull, shear, twist, held):
    """Loads in shares of the cup's force, across it and about it of what friction bears of that."""
    world, (force, moment) = lifted.world, loaded(lifted, pull, shear, twist)
    assert isinstance(world, MujocoWorld)
    lip = lifted.tool_pose("suction")[:3, 3]
    for step in range(2 * RAMP):
        share = min(1.0, (step + 1) / RAMP)
        body = world.state[1].body("plate")
        turning = np.cross(lip - body.xipos, force)
        turning[2] += moment
        body.xfrc_applied[:] = share * np.concatenate([force, turning])
        lifted.step()
    assert lifted.holding is held


@pytest.mark.parametrize(("aside", "seals"), [(0.0, True), (0.02, False), (0.06, False)])
def test_a_cup_seals_on_what_its_whole_lip_meets(aside, seals):
    with MujocoWorld() as world:
        corners = np.array([[x, y, z] for x in (-0.02, 0.02) for y in (-0.02, 0.02) for z in (0.0, FLAT)])
        corners[:, 0] += aside
        small = Body.of("small", [corners], mass=0.1)
        arm, _ = lowered(world, small, FLAT)
        assert arm.suck() is seals
        assert arm.holding is seals


def test_what_never_moves_is_not_taken():
    with MujocoWorld() as world:
        arm, _ = lowered(world, plate("plate"), 0.0)
        world.remove("plate")
        assert not arm.suck() and arm.sealed is None


@pytest.mark.parametrize(("seed", "kept", "gone"), [(0, "left", "right"), (1, "plank", "load")])
def test_clamps_keep_what_would_fall_until_they_let_go_of_it(seed, kept, gone):
    with scenario("hold", seed, "mujoco") as stage:
        world = stage.world
        assert isinstance(world, MujocoWorld)
        before, clamps = world.pose(kept), Clamps(world, [kept])
        world.remove(gone)
        world.step(480)
        assert clamps.clamped == {kept}
        assert np.allclose(world.pose(kept), before, atol=3e-3)
        clamps.release(kept)
        world.step(480)
        assert not clamps.clamped
        assert not np.allclose(world.pose(kept), before, atol=0.01)
        clamps.release(kept)


def test_clamps_are_for_what_is_there_and_moves():
    with MujocoWorld() as world:
        world.add_table()
        world.add(block("block"), at(0.0, 0.0, 0.0))
        for name in ("shelf", "table"):
            with pytest.raises(UnknownObject, match=name):
                Clamps(world, [name])
