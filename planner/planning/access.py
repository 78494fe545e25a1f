"""What only bars the gripper's way: what stays put when another is taken, but leaves the hand no room."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from topple.planner.decide.dependency import DependencyGraph
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.judge import reachable
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.planning.tolerances import TOGETHER
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.situation.situation import Situation


@dataclass(frozen=True)
class Access:
    """What leaves the hand no room.

    Attributes:
        bars: (first, then, reason) for each object that has to go before another can be grasped.
        graspless: Objects the hand cannot grasp even where nothing stands around them.
    """

    bars: tuple[Mapping[str, str], ...]
    graspless: tuple[str, ...]


def access(situation: Situation, names: Sequence[str], graph: DependencyGraph, arm: Arm) -> Access:
    """Find what bars every grasp of some objects.

    Each object is looked at as it is when its turn comes: what must go before it is gone. Where no grasp is
    left, the fewest others are looked for without which there is one. Reach is asked where the scene says
    where the arm stands; the way of the arm itself is a matter for `plan`.

    Args:
        situation: What is seen.
        names: The objects that are to be taken.
        graph: What must go before what.
        arm: The arm.

    Returns:
        What bars the way.
    """
    hand = _Hand(situation, arm)
    bars: list[Mapping[str, str]] = []
    graspless: list[str] = []
    for name in names:
        gone = graph.before(name)
        if hand.holds(name, gone):
            continue
        around = [other for other in hand.near(name) if other not in gone and name not in graph.before(other)]
        freeing = _fewest(name, gone, around, hand)
        if freeing is None:
            graspless.append(name)
            continue
        for other in freeing:
            words = f"{other} leaves the hand no room at {name}"
            bars.append({"first": other, "then": name, "reason": words})
    return Access(tuple(bars), tuple(graspless))


def _fewest(name: str, gone: Collection[str], around: Sequence[str], hand: "_Hand") -> tuple[str, ...] | None:
    """The fewest neighbours without which an object can be grasped, None where that does not help."""
    if not hand.holds(name, {*gone, *around}):
        return None
    for count in range(1, TOGETHER + 1):
        for some in combinations(around, count):
            if hand.holds(name, {*gone, *some}):
                return some
    return tuple(around)


class _Hand:
    """An arm's tools in a scene from which objects are taken."""

    def __init__(self, situation: Situation, arm: Arm) -> None:
        self._situation, self._scene, self._arm = situation, situation.scene, arm

    def near(self, name: str) -> list[str]:
        """Movable objects a hand at an object could meet, the nearest first."""
        own = self._scene.clouds[name]
        gaps = {other: _gap(own, self._scene.clouds[other]) for other in self._scene.movable if other != name}
        return sorted((o for o in gaps if gaps[o] < GRASP_TOLERANCES.reach), key=lambda o: (gaps[o], o))

    def holds(self, name: str, gone: Collection[str]) -> bool:
        """Whether an object can be grasped once others are gone."""
        grasps = grasp_candidates(name, self._situation.without(*gone), self._arm)
        if self._scene.robot_base is None:
            return bool(grasps)
        return any(reachable(grasps, self._arm, self._scene.robot_base))


def _gap(a: FloatArray, b: FloatArray) -> float:
    """Distance of two boxes around clouds [m]."""
    apart = np.maximum(a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0))
    return float(np.linalg.norm(np.maximum(apart, 0.0)))
