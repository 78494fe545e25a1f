"""Pinching between two fingers: where pads can reach an object's sides past everything around it."""

from collections.abc import Mapping

import numpy as np

from topple.planner.grasp.frames import Frames
from topple.planner.grasp.grasp import PINCH, RIM, Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.load import HOLD, chance_to_hold, in_words, jaw_load, weight_of
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.surroundings import ITSELF
from topple.planner.grasp.windows import State, Windows, windows
from topple.topology.base.values import decimal

WEIGHTS = {"antipodality": 0.3, "balance": 0.3, "clearance": 0.15, "depth": 0.15, "upright": 0.1}
"""Exponents of a pinch's terms: one that is nil spoils the grasp alone."""
NOTHING = "nothing between the pads"
BELOW = "the hand would go below the ground"
SLIDES = "pads would slide off"


def score_of(terms: Mapping[str, float]) -> float:
    """Put the terms (0..1) of a pinch together, to 0..1."""
    return float(np.prod([terms[name] ** power for name, power in WEIGHTS.items()])) * terms.get(HOLD, 1.0)


def pinches(frames: Frames, sought: Sought, hand: HandShape) -> list[Grasp]:
    """Find how deep the fingers can go at one point of an object, and what they would hold.

    Args:
        frames: The point and the directions of the hand.
        sought: The object, and what is around it; nothing of the hand may go below the ground.
        hand: The hand.

    Returns:
        At most two grasps for each direction: the best-scored one and the deepest free one.
    """
    found = windows(frames, sought, hand)
    _note(found, sought, hand)
    return _best_and_deepest(frames, found, sought, hand)


def _note(found: Windows, sought: Sought, hand: HandShape) -> None:
    """Take down what is left out and why."""
    dropped, spare = sought.dropped, 2.0 * sought.tolerances.least_side_clearance
    dropped.note(NOTHING, int(np.count_nonzero(found.states[:, 0] == State.EMPTY)))
    _, low, high, _, _ = found.values[found.states == State.WIDE].T
    dropped.too_wide(high - low, spare, hand.max_opening)
    for state, reason in ((State.LOW, BELOW), (State.SLIDES, SLIDES)):
        dropped.note(reason, int(np.count_nonzero(found.states == state)))
    names = (*sought.around.names, ITSELF)
    for part, what in ((State.PADS, "pads"), (State.FINGERS, "fingers"), (State.PALM, "hand")):
        for owner, count in enumerate(np.bincount(found.barring[found.states == part]).tolist()):
            dropped.no_room(what, names[owner], count)


def _best_and_deepest(frames: Frames, windows: Windows, sought: Sought, hand: HandShape) -> list[Grasp]:
    """The best-scored and the deepest pinch of each direction."""
    surface, tolerances = sought.surface, sought.tolerances
    row, column = np.nonzero(windows.states == State.HOLDS)
    tip, low, high, clearance, held = windows.values[row, column].T
    depth, middle, width = np.array(tolerances.depths)[column], (low + high) / 2.0, high - low
    opening = np.minimum(hand.max_opening, width + 2.0 * tolerances.side_clearance)
    com = ((surface.centre - frames.origin) @ frames.rotations)[row]
    arm = com - np.column_stack([np.zeros(len(com)), middle, tip - hand.tip])
    down, weight = -(sought.up @ frames.rotations)[row], weight_of(surface.volume, surface.mass)
    load = jaw_load(arm, down, weight, width, depth, hand, tolerances.friction)
    rim = np.abs(arm[:, 1]) > width / 2.0 + 0.01
    terms = {
        "antipodality": held,
        "balance": 1.0 / (1.0 + ((arm[:, 0] ** 2 + arm[:, 1] ** 2) / tolerances.lever**2)),
        "clearance": clearance,
        "depth": np.minimum(1.0, depth / (0.5 * hand.pad_length)),
        "upright": 1.0 - 0.5 * frames.tilts[row],
    }
    chance = chance_to_hold(load, surface.mass is not None)
    total = np.sum(list(terms.values()), axis=0) * chance
    found: list[Grasp] = []
    for way in np.unique(row):
        here = np.flatnonzero(row == way)
        best, deepest = int(here[np.argmax(total[here])]), int(here[-1])
        for k in (best, deepest) if best != deepest else (best,):
            pose = np.eye(4)
            pose[:3, :3] = frames.rotations[way]
            shift = np.array([0.0, middle[k], tip[k] - hand.tip])
            pose[:3, 3] = frames.origin + frames.rotations[way] @ shift
            parts = {name: float(values[k]) for name, values in terms.items()}
            said = ", ".join(f"{term} {value:.2f}" for term, value in parts.items())
            reason = (
                f"{1e3 * float(width[k]):.0f} mm between the pads, tips {decimal(1e3 * float(depth[k]))}"
                f" mm deep; {said}{in_words(float(load[k]))}"
            )
            parts[HOLD] = float(chance[k])
            kind, size = RIM if rim[k] else PINCH, (float(width[k]), float(opening[k]))
            found.append(Grasp(sought.name, kind, pose, *size, score_of(parts), reason, parts))
    return found
