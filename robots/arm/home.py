"""A state for an arm of one's own to rest in: the hand in front, pointing down, free of itself."""

from functools import lru_cache
from itertools import combinations

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.self_collision import colliding_pairs, parts_in_frames
from topple.robots.arm.tolerances import (
    ABOVE,
    ASIDE,
    BELOW,
    CLEAR,
    DRAWN,
    HEIGHTS,
    SEEDS,
    SHARES,
    SMALL_REACH,
    TALL,
    TURNS,
    USUAL_REACH,
)
from topple.robots.collision.separation import Candidates, Frames, gaps
from topple.topology.base.arrays import FloatArray, freeze


def home_of(arm: Arm, tool: str | None) -> FloatArray:
    """Choose a state to rest in.

    Of the states in which the tool is in front of the base (along its x axis), pointing down, and no link
    comes near another or the floor, the one farthest from the joint limits and from where the arm loses a
    direction.

    Args:
        arm: The arm; its own home is not used.
        tool: Its tool; the last frame of the chain where None.

    Returns:
        (n,) joint values. The middle of the limits where nothing was found. Deterministic.
    """
    rng = np.random.default_rng(0)
    for states in (_in_front(arm, tool, rng), _downward(arm, tool, rng)):
        room = _room(arm, states)
        for least in CLEAR:
            if (room > least).any():
                good = states[room > least]
                return good[int(np.argmax(_quality(arm, good)))]
    return (arm.lower + arm.upper) / 2.0


def reach_of(arm: Arm, tool: str | None) -> float:
    """How far the tool gets from the first joint [m]: the largest distance in a thousand states."""
    states = np.random.default_rng(0).uniform(arm.lower, arm.upper, (1000, len(arm.joints)))
    frames = arm.chain.frames(states)
    return float(np.linalg.norm(_pose(arm, tool, states)[:, :3, 3] - frames[:, 1, :3, 3], axis=1).max())


@lru_cache(maxsize=16)
def scale_of(arm: Arm) -> float:
    """How large an arm is beside those that distances were chosen for: 1 for all but small ones."""
    reach = reach_of(arm, next(iter(arm.tools), None))
    return reach / USUAL_REACH if reach < SMALL_REACH else 1.0


def level_of(arm: Arm, reach: float) -> float:
    """Height [m] above the foot of what an arm works on: zero for an arm on a table.

    Args:
        arm: The arm; its home is not used.
        reach: How far its tool gets from the first joint [m].
    """
    height = float(shoulder_of(arm)[2])
    return height - BELOW * reach if height > TALL * reach else 0.0


@lru_cache(maxsize=16)
def workplace_of(arm: Arm) -> FloatArray:
    """Find where an arm works from.

    Args:
        arm: The arm.

    Returns:
        (4, 4) pose_workplace_to_base: its own foot, or, of an arm on a torso or beside its base, the foot it
        would have if its first joint stood on what it works on.
    """
    shoulder, reach = shoulder_of(arm), reach_of(arm, next(iter(arm.tools), None))
    pose = np.eye(4)
    if np.linalg.norm(shoulder[:2]) > ASIDE * reach:
        pose[:2, 3] = shoulder[:2]
    pose[2, 3] = level_of(arm, reach)
    return freeze(pose)


def shoulder_of(arm: Arm) -> FloatArray:
    """Where the first joint is in the base (3,) [m]; half drawn out where it slides."""
    return arm.chain.frames((arm.lower + arm.upper)[None] / 2.0)[0, 1, :3, 3]


def _pose(arm: Arm, tool: str | None, states: FloatArray) -> FloatArray:
    return arm.chain.frames(states)[:, -1] if tool is None else arm.tool_pose(states, tool)


def _in_front(arm: Arm, tool: str | None, rng: np.random.Generator) -> FloatArray:
    """States (m, n) with the tool pointing down in front."""
    if tool is None:
        return np.empty((0, len(arm.joints)))
    reach = reach_of(arm, tool)
    shoulder, level = shoulder_of(arm), level_of(arm, reach)
    targets: list[FloatArray] = []
    for share in SHARES:
        for height in HEIGHTS:
            for turn in range(TURNS):
                angle = 2.0 * np.pi * turn / TURNS
                pose = np.diag([1.0, -1.0, -1.0, 1.0])
                pose[:2, :2] = [[np.cos(angle), np.sin(angle)], [np.sin(angle), -np.cos(angle)]]
                pose[:3, 3] = shoulder[0] + reach * share, shoulder[1], level + reach * height
                targets.append(pose)
    found = arm.inverse(np.array(targets), tool, seeds=SEEDS, rng=rng, near=(arm.lower + arm.upper) / 2.0)
    return np.concatenate(found)


def _downward(arm: Arm, tool: str | None, rng: np.random.Generator) -> FloatArray:
    """Those of many drawn states (m, n) in which the tool points down best."""
    drawn = rng.uniform(arm.lower, arm.upper, (DRAWN, len(arm.joints)))
    return drawn[np.argsort(_pose(arm, tool, drawn)[:, 2, 2], kind="stable")[: DRAWN // 32]]


def _room(arm: Arm, states: FloatArray) -> FloatArray:
    """Least distance (m,) of two links in states (m, n) [m]; -inf where one is below the foot."""
    offsets = arm.offsets(arm.open_hand)
    frames = arm.chain.frames(states)
    room = np.full(len(states), np.inf)
    for link, parts in enumerate(arm.parts):
        for part in parts if arm.frame_of_link[link] > 0 else ():
            poses = np.matmul(frames[:, arm.frame_of_link[link]], offsets[link])
            heights = poses[:, 2, :3] @ part.T + poses[:, 2, 3:]
            room[heights.min(axis=1) < ABOVE] = -np.inf
    pairs = {
        pair
        for pair in colliding_pairs(arm.chain, arm.parts, arm.frame_of_link, offsets, None)
        if frozenset((arm.links[pair[0]], arm.links[pair[1]])) not in arm.apart
    }
    if not pairs or not len(states):
        return room
    sets, owner = parts_in_frames(arm.parts, arm.frame_of_link, offsets)
    moving = Frames.of(arm.chain.poses(states))
    centres = moving.points(sets.frame, sets.centre).transpose(2, 1, 0)
    every = np.arange(len(states))
    for i, j in combinations(range(len(owner)), 2):
        if (owner[i], owner[j]) not in pairs:
            continue
        many = np.full(len(states), i), np.full(len(states), j)
        need = np.full(len(states), CLEAR[0], dtype=np.float32)
        asked = Candidates(every, *many, centres[:, i] - centres[:, j], need)
        room = np.minimum(room, gaps(sets, moving, asked, iterations=12))
    return room


def _quality(arm: Arm, states: FloatArray) -> FloatArray:
    """How well an arm moves from each of the states (m, n).

    Room to the limits, no direction lost, and the elbow up: below it there is a table.
    """
    frames = arm.chain.frames(states)
    jacobian = arm.chain.jacobian(frames, frames[:, -1, :3, 3])
    least = np.linalg.svd(jacobian, compute_uv=False)[:, -1]
    room = np.minimum(states - arm.lower, arm.upper - states)
    room = np.minimum(room, np.pi / 2.0).min(axis=1)
    # joints that turn twice: of states alike the one with fewer whole turns
    turned = np.abs(states).max(axis=1)
    height = frames[:, 1:, 2, 3].mean(axis=1) / np.ptp(frames[:, 1:, :3, 3], axis=1).max()
    return least * np.clip(room, 0.0, 0.5) * np.clip(0.5 + height, 0.0, 2.0) - 1e-3 * turned
