"""An electromagnet that lifts steel by a flat top: both halves of a gripper, and an arm that has it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pybullet_data

from topple.planner.grasp.cells import Region
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.shape import Shape, body_of
from topple.robots import robot
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.gripper import Gripper, Tool
from topple.robots.arm.gripper_file import Cup


@dataclass(frozen=True, eq=False)
class Magnet(Gripper):  # what an arm, a world and a plan ask
    core: SuctionCup  # what a world plays it as: it holds what all of its rim lies on
    tool, presses = "magnet", True
    cup = property(lambda self: self.core)
    touching = property(lambda self: self.core.touching)
    limits = property(lambda self: self.core.limits)
    stowed = property(lambda self: self.core.stowed)

    def values(self, state):
        return self.core.values(state)

    def take(self, robot, name):
        return None if robot.suck() else f"the magnet does not stick to {name}."

    def data(self):
        return {"more": {"pull": self.core.max_force, "radius": self.core.radius}}

    def facts(self):
        return {"kind": "magnet", **self.data()["more"]}

    def __str__(self):
        return f"a magnet that holds {self.core.max_force:.0f} N"


class Face(Shape):  # what searches, rankings and verdicts ask
    kind, where, holder = "magnet", "under the magnet", "the magnet holds"

    def grasps(self, sought):  # straight down on the middle of the top
        if not sought.name.startswith("steel"):
            sought.dropped.note("no steel, which the magnet wants")
            return []
        heights = sought.cloud @ sought.up
        top = sought.cloud[heights > heights.max() - 0.004]
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[:3, 3] = [*top.mean(axis=0)[:2], np.median(top[:, 2])]
        terms = {"flat": float(np.exp(-top[:, 2].std() / 0.002))}
        return [Grasp(sought.name, self.kind, pose, 0.0, 0.0, self.score(terms), "a flat top", terms)]

    def score(self, terms):
        return terms["flat"]

    def max_weight(self, friction):
        return self.tool.gripper.cup.max_force

    def load(self, weight, *_):
        return weight / self.max_weight(None)

    def holds(self, count):
        bound = np.tile([self.tool.gripper.cup.radius] * 2 + [0.01], (count, 1))
        return Region(-bound, bound)


def face(arm):
    return Face(arm.tools["magnet"], body_of(arm, arm.tools["magnet"]))


def arm():  # an iiwa whose flange carries the magnet, as round and as sprung as a cup
    flange = Cup(link="lbr_iiwa_link_7", offset=[0.0, 0.0, 0.12], radius=0.015, force=60.0)
    iiwa = robot(Path(pybullet_data.getDataPath()) / "kuka_iiwa" / "model.urdf", gripper=flange)
    (lip,) = iiwa.tools.values()
    tool = Tool.of(Magnet(lip.gripper), lip.link, lip.pose_tool_to_link)
    return replace(iiwa, name="magnet-iiwa", tools={"magnet": tool})
