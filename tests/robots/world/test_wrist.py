"""What a wrist feels through noisy joint torques: the load less its weight, whatever the sensors' offset."""

from collections.abc import Callable, Iterator

import numpy as np
import pybullet
import pytest
from moving import at, down, go, way_to

from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.robots.world.wrist import TorqueNoise

Arms = Callable[..., SimulatedArm]
HEIGHT = 0.25  # [m] of the hand above the table


@pytest.fixture
def arms() -> Iterator[Arms]:
    """Makes arms that hold their hands still above a table, each in its own world."""
    made: list[World] = []

    def arm(
        noise: TorqueNoise | None = None, seed: int = 0, name: str = "panda", mass: float = 0.0
    ) -> SimulatedArm:
        world = World()
        made.append(world)
        world.add_table()
        if mass:
            world.add(shapes.box("thing", (0.05, 0.04, 0.1), mass=mass), at(0.5, 0.0, 0.0))
            world.settle()
        found = SimulatedArm(world, robot(name), np.eye(4), noise=noise, rng=np.random.default_rng(seed))
        go(found, down(0.5, 0.0, HEIGHT))
        if mass:
            go(found, down(0.5, 0.0, 0.07))
            found.close(60.0)
            go(found, down(0.5, 0.0, HEIGHT))
        found.wait(0.5)
        return found

    yield arm
    for world in made:
        world.close()


def forces(arm: SimulatedArm, steps: int, pull: float = 0.0) -> list[float]:
    """Forces [N] that the wrist tells after each step in which the hand is pulled down by `pull` [N]."""
    client, hand = arm.world.client, arm.arm.tool("fingers").link
    every = range(pybullet.getNumJoints(arm.id, physicsClientId=client))
    links = [pybullet.getJointInfo(arm.id, j, physicsClientId=client)[12].decode() for j in every]
    found: list[float] = []
    for _ in range(steps):
        where = arm.link_pose(hand)[:3, 3].tolist()
        pybullet.applyExternalForce(
            arm.id, links.index(hand), [0.0, 0.0, -pull], where, pybullet.WORLD_FRAME, physicsClientId=client
        )
        arm.step()
        found.append(arm.wrist.force())
    return found


def test_the_offset_of_the_sensors_is_felt_until_the_wrist_is_tared(arms):
    arm = arms()
    before = forces(arm, 24)
    assert np.mean(before) > 0.5, "an offset of 0.2 N m at each joint comes to about a newton"
    arm.tare()
    assert np.max(forces(arm, 240)) < 0.7, "less than what counts as a touch"


def test_noise_is_what_it_is_said_to_be(arms):
    """Of one second of readings at rest: their spread is that of the joints through the Jacobian."""
    arm, noise = arms(), TorqueNoise()
    readings = np.array([arm.wrist.reading() for _ in range(1000)])
    frames = arm.arm.chain.frames(arm.q[None])
    jacobian = arm.arm.chain.jacobian(frames, frames[:, -1, :3, 3])[0]
    lever = np.linalg.norm(np.linalg.pinv(jacobian.T, rcond=1e-2)[:3], axis=1)
    assert readings.std(axis=0) == pytest.approx(noise.deviation * lever, rel=0.1)


def test_the_same_seed_feels_the_same_and_another_does_not(arms):
    one, same, other = (forces(arms(seed=seed), 5) for seed in (3, 3, 4))
    assert one == same
    assert one != other


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_pull_is_told_by_its_size_whatever_the_hand_carries(arms, seed):
    arm = arms(seed=seed, mass=0.5)
    assert arm.holding
    arm.tare()
    assert np.max(forces(arm, 120)) < 0.5, "the weight of half a kilogram is no touch"
    assert np.median(forces(arm, 120, pull=4.0)[60:]) == pytest.approx(4.0, abs=0.5)


def test_sensors_without_faults_feel_a_pull_at_once(arms):
    arm = arms(TorqueNoise.none())
    arm.tare()
    assert np.max(forces(arm, 24)) < 0.02
    assert forces(arm, 24, pull=4.0)[-1] == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_noise_does_not_stop_a_guarded_motion_and_a_table_does(arms, seed):
    arm = arms(seed=seed, mass=0.3)
    free = way_to(arm, down(0.5, 0.0, 0.12), seconds=2.0)
    arm.follow_until(free, 1.0)
    assert arm.q_target == pytest.approx(free.positions[-1]), "nothing is in the way"
    begun = way_to(arm, down(0.5, 0.0, 0.05), seconds=2.0)
    arm.follow_until(begun, 1.0)
    assert np.abs(arm.q_target - begun.positions[-1]).max() > 0.005, "the box it holds came to stand"
    foot = min(part[:, 2].min() for part in arm.world.parts("thing"))
    assert abs(foot) < 0.002
