"""Which links of an arm can hit each other, found by sampling its states."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from topple.robots.arm.kinematics import Chain
from topple.robots.arm.tolerances import ALWAYS, NEAR, SAMPLES
from topple.robots.collision.separation import Candidates, ConvexSets, Frames, gaps
from topple.topology.base.arrays import BoolArray, FloatArray


def colliding_pairs(
    chain: Chain,
    parts: Sequence[Sequence[FloatArray]],
    frame_of_link: Sequence[int],
    offsets: FloatArray,
    home: FloatArray | None,
) -> tuple[tuple[int, int], ...]:
    """Pairs of links that hit each other in some states and not in others.

    Links that do not move against each other, neighbours along the chain, pairs that overlap by construction
    (in nearly all states, or in the arm's own home state) and pairs that never come near are left out.

    Args:
        chain: The driven joints.
        parts: Per link the (V, 3) vertices of its convex parts in the link frame.
        frame_of_link: Per link the chain frame that carries it.
        offsets: (L, 4, 4) poses of the links in those frames.
        home: (n,) a state that is free; None where none is known.

    Returns:
        Pairs of link indices.
    """
    sets, owner = parts_in_frames(parts, frame_of_link, offsets)
    states = np.random.default_rng(0).uniform(chain.lower, chain.upper, (SAMPLES, chain.size))
    if home is not None:
        states[0] = home
    frames = Frames.of(chain.poses(states))
    centres = frames.points(sets.frame, sets.centre).transpose(2, 1, 0)
    meets: dict[tuple[int, int], BoolArray] = {}
    built_so: set[tuple[int, int]] = set()
    for i, j in combinations(range(len(owner)), 2):
        if abs(sets.frame[i] - sets.frame[j]) < 2:
            continue
        apart = centres[:, i] - centres[:, j]
        near = np.flatnonzero(
            np.einsum("ij,ij->i", apart, apart) < (sets.radius[i] + sets.radius[j] + NEAR) ** 2
        )
        many = np.full(len(near), i), np.full(len(near), j)
        need = np.full(len(near), NEAR, dtype=np.float32)
        gap = gaps(sets, frames, Candidates(near, *many, apart[near], need), iterations=12)
        links = owner[i], owner[j]
        meets.setdefault(links, np.zeros(SAMPLES, dtype=np.bool_))[near[gap <= NEAR]] = True
        if home is not None and (gap[near == 0] <= 0.0).any():
            built_so.add(links)
    return tuple(
        links for links, met in meets.items() if 0 < met.sum() < ALWAYS * SAMPLES and links not in built_so
    )


def parts_in_frames(
    parts: Sequence[Sequence[FloatArray]], frame_of_link: Sequence[int], offsets: FloatArray
) -> tuple[ConvexSets, list[int]]:
    """The parts of all links in the chain frames that carry them, and the link of each.

    Args:
        parts: Per link the (V, 3) vertices of its convex parts in the link frame.
        frame_of_link: Per link the chain frame that carries it.
        offsets: (L, 4, 4) poses of the links in those frames.
    """
    owner = [i for i, own in enumerate(parts) for _ in own]
    placed = [part @ offsets[i][:3, :3].T + offsets[i][:3, 3] for i, own in enumerate(parts) for part in own]
    return ConvexSets.of(placed, [frame_of_link[i] for i in owner]), owner
