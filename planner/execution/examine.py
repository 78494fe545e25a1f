"""What an arm can do, tried: reach, self-collision, inverse kinematics, and a grasp in simulation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.planner.execution.tolerances import POSES, SOLVED, STATES
from topple.planner.execution.trial import Trial, trial
from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.robots.arm.home import reach_of
from topple.robots.engines import INSTALLED
from topple.topology.base.errors import NotInstalled, ToppleError


@dataclass(frozen=True)
class Grasped:
    """How the grasp in simulation went.

    Attributes:
        trial: What was taken, and where it stood; None where nothing is in reach.
        success: Whether it was taken, lifted and put down elsewhere.
        why: What went wrong, in sentences.
    """

    trial: Trial | None
    success: bool
    why: tuple[str, ...]


@dataclass(frozen=True)
class Examined:
    """What was found of an arm.

    Attributes:
        arm: The arm.
        still: Names of joints that hold still.
        reach: Largest distance of the tool from the first joint [m].
        free: Share of the states within the joint limits in which no link touches another one.
        poses: How many poses of the tool, reached in free states, inverse kinematics was asked for.
        solved: Of how many of them it found a state.
        grasped: How the grasp in simulation went; None where it was not tried.
        untried: Why it was not, empty where it was.
    """

    arm: Arm
    still: tuple[str, ...]
    reach: float
    free: float
    poses: int
    solved: int
    grasped: Grasped | None
    untried: str

    @property
    def ok(self) -> bool:
        """Whether inverse kinematics finds nearly every pose, and the grasp holds if it was tried."""
        found = self.poses > 0 and self.solved >= SOLVED * self.poses
        return found and bool(self.arm.tools) and (self.grasped is None or self.grasped.success)

    def to_json(self) -> dict[str, Any]:
        """The `topple.robot` document, but for how the arm was given."""
        arm, grasped = self.arm, self.grasped
        return {
            "name": arm.name,
            "base": arm.links[0],
            "joints": [
                {
                    "name": name,
                    "kind": arm.model.joint(name).kind,
                    "lower": float(arm.lower[i]),
                    "upper": float(arm.upper[i]),
                    "velocity": float(arm.velocity[i]),
                    "acceleration": float(arm.acceleration[i]),
                }
                for i, name in enumerate(arm.joints)
            ],
            "still": list(self.still),
            "tools": [_tool(arm, name) for name in arm.tools],
            "home": arm.home.tolist(),
            "reach": self.reach,
            "self_collision": {
                "free": self.free,
                "pairs": len(arm.self_pairs),
                "disabled": len(arm.apart),
            },
            "inverse": {
                "poses": self.poses,
                "solved": self.solved,
                "bar": SOLVED,
                "ok": self.poses > 0 and self.solved >= SOLVED * self.poses,
            },
            "grasp": None
            if grasped is None
            else {
                "object": None if grasped.trial is None else grasped.trial.to_json(),
                "success": grasped.success,
                "why": list(grasped.why),
            },
            "untried": self.untried or None,
            "assumptions": list(arm.assumptions),
            "ok": self.ok,
        }


def examine(
    arm: Arm, *, grasp: bool = True, seed: int = 0, progress: Callable[[str], None] | None = None
) -> Examined:
    """Find out what an arm can do.

    Args:
        arm: The arm, with or without a tool.
        grasp: Whether to try a grasp in simulation.
        seed: Of the states drawn and of every search.
        progress: Called with a line before each part.

    Returns:
        What was found.
    """
    say = progress or (lambda _: None)
    say("drawing states")
    rng = np.random.default_rng(seed)
    tool = next(iter(arm.tools), None)
    states = rng.uniform(arm.lower, arm.upper, (STATES, len(arm.joints)))
    free = Checker(arm, np.eye(4), {}).free(states)
    say("asking inverse kinematics")
    solved, reached = 0, states[free][:POSES]
    if tool is not None and len(reached):
        solved = int(arm.reaches(arm.tool_pose(reached, tool)[:, None], tool).sum())
    untried, grasped = "", None
    if tool is None:
        untried = "there is nothing to take hold with"
    elif not grasp:
        untried = "it was not asked for"
    elif not INSTALLED:
        untried = str(NotInstalled("simulation needs an engine", "mujoco"))
    else:
        grasped = _try_grasp(arm, tool, seed, say)
    asked = len(reached) if tool is not None else 0
    still = tuple(_still(arm))
    return Examined(arm, still, reach_of(arm, tool), float(free.mean()), asked, solved, grasped, untried)


def _try_grasp(arm: Arm, tool: str, seed: int, say: Callable[[str], None]) -> Grasped:
    """Take the object of a trial by an engine's contacts and friction alone."""
    from topple.planner.execution.run import run

    tried = trial(arm, tool)
    if tried is None:
        return Grasped(None, False, ("no place in front of the base is reached with the hand pointing down",))
    say("taking a block in simulation")
    try:
        record = run(tried.scene(), [tried.name], arm, pose_base_to_world=np.eye(4), seed=seed)
    except ToppleError as error:
        return Grasped(tried, False, (str(error), *getattr(error, "certificate", ())))
    return Grasped(tried, record.success, tuple(record.violations))


def _still(arm: Arm) -> list[str]:
    """The joints of the file that are neither the arm's nor its hand's: they are fixed in what was read."""
    from topple.robots.arm.tree import Tree
    from topple.robots.arm.urdf import urdf_root

    if arm.catalog:
        return []
    fixed = {joint.name for joint in arm.model.joints.values() if joint.kind == "fixed"}
    tree = Tree(urdf_root(arm.source), arm.source.name)
    return [edge.joint for edge in tree.edges.values() if edge.moves and edge.joint in fixed]


def _tool(arm: Arm, name: str) -> dict[str, Any]:
    tool = arm.tools[name]
    return {
        "name": str(name),
        "link": tool.link,
        "pose_tool_to_link": tool.pose_tool_to_link.tolist(),
        "links": list(tool.links),
        **tool.gripper.facts(),
        "words": str(tool.gripper),
    }
