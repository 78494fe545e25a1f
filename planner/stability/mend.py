"""The least shifts that make a scene stand: down to what is below, out of what is in it, over its support."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.planner.stability.footing import Footing
from topple.planner.stability.margins import beyond_support
from topple.planner.stability.tolerances import LEAST_MOVE, MENDING_ROUNDS, MENDS_BY, SINKS
from topple.planner.stability.verdicts import STANDING, Finding, Verdict, find_verdicts
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.scene.frame import shift_objects
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True)
class Mended:
    """A scene after small shifts.

    Attributes:
        shifts: name -> (3,) how far each object that was moved is from where it was, in the world [m].
        left: name -> verdict, of what does not stand then either.
        scene: The scene with everything there.
    """

    shifts: Mapping[str, FloatArray]
    left: Mapping[str, Verdict]
    scene: Scene

    def to_json(self) -> dict[str, Any]:
        """The JSON of `topple check --mend`: poses of where objects were to where they shall be."""
        return {
            "format": "topple.mended",
            "format_version": 1,
            "stands": not self.left,
            "poses": {name: _pose(shift).tolist() for name, shift in self.shifts.items()},
            "millimetres": {n: round(1e3 * float(np.linalg.norm(s)), 3) for n, s in self.shifts.items()},
            "left": {name: str(verdict) for name, verdict in self.left.items()},
        }


def _pose(shift: FloatArray) -> FloatArray:
    pose = np.eye(4)
    pose[:3, 3] = shift
    return pose


@checked_arguments
def mend(scene: AnyScene) -> Mended:
    """Move what does not stand as little as makes it stand, at most 5 mm, with what is on it.

    Args:
        scene: A scene of whole surfaces that knows where up is, or the path of one.

    Returns:
        The shifts, and what they do not help: what slides, and what would have to go further.

    Raises:
        InvalidInput: The scene has no `up`, or cameras saw it: what is hidden cannot be mended.
    """
    found = as_scene(scene)
    if len(found.viewpoints):
        raise InvalidInput(
            "a scene that cameras saw cannot be mended: give meshes, or clouds without viewpoints"
        )
    shifts, best = dict[str, FloatArray](), found
    for _ in range(MENDING_ROUNDS):
        situation = Situation.of(best)
        footing = Footing.of(situation)
        verdicts = find_verdicts(footing)
        wanted = _wanted_moves(verdicts, footing)
        added = {name: shifts.get(name, np.zeros(3)) + shift for name, shift in wanted.items()}
        added = {name: shift for name, shift in added.items() if np.linalg.norm(shift) <= LEAST_MOVE}
        if not added:
            break
        shifts |= added
        best = shift_objects(found, shifts)
    left = {n: each.verdict for n, each in find_verdicts(Footing.of(Situation.of(best))).items()}
    return Mended(shifts, {n: verdict for n, verdict in left.items() if verdict not in STANDING}, best)


def _wanted_moves(verdicts: Mapping[str, Finding], footing: Footing) -> dict[str, FloatArray]:
    """How far what does not stand by itself should go, in the world [m], and with it what is on it."""
    found: dict[str, FloatArray] = {}
    height = {name: float(weight.centre[2]) for name, weight in footing.weights.items()}
    for name in sorted(verdicts, key=height.__getitem__):
        finding, shift = verdicts[name], np.zeros(3)
        if name in found:
            continue
        if finding.verdict is Verdict.PENETRATES:
            higher = [n for n in finding.others if height.get(n, -np.inf) < height[name]]
            shift[2] = max((footing.depths[name, n] for n in higher), default=0.0)
            shift[2] -= 0.0 if footing.exact else SINKS  # of clouds depth is told to noise
        elif finding.verdict is Verdict.FLOATS and finding.others:
            shift[2] = -footing.drops[name][finding.others[0]]
        elif finding.verdict is Verdict.TIPS:
            beyond = beyond_support(footing, name, footing.contacts)
            shift[:2] = 0.0 if beyond is None else beyond[0] * (beyond[1] + MENDS_BY)
        if shift.any():
            found |= {each: footing.rotation.T @ shift for each in _with_load(name, footing)}
    return found


def _with_load(name: str, footing: Footing) -> list[str]:
    """An object and all that it carries."""
    found = [name]
    for low in found:
        carried = (n for n in footing.weights if low in footing.carriers(n, footing.contacts))
        found += [each for each in carried if each not in found]
    return found
