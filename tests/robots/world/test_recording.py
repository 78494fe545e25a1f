"""Samples of a world while an arm acts in it."""

import numpy as np

from topple.robots.catalog import robot
from topple.robots.poses import inverse
from topple.robots.shapes import box
from topple.robots.world.recording import Recording
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World


def test_links_are_recorded_where_the_kinematics_say():
    with World() as world:
        world.add_table()
        world.add(box("box", (0.1, 0.1, 0.1)), np.eye(4))
        arm = SimulatedArm(world, robot("panda"), np.eye(4))
        recording = Recording(arm, 20.0)
        arm.q_target = np.add(arm.q_target, [0.8, 0, 0, 0, 0, 0, 0])
        arm.wait(1.0)
        recording.stop()
        (expected,) = arm.arm.forward(arm.q)
    assert len(recording.times) == len(recording.poses) == len(recording.links) >= 20
    for link in ("panda_link0", "panda_link4", "panda_hand"):
        pose = inverse(arm.pose_base_to_world) @ recording.links[-1][link]
        assert np.allclose(pose, expected[arm.arm.links.index(link)], atol=5e-3)
