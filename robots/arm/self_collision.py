"""Which links of an arm can hit each other, found by sampling its states."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from topple.robots.arm.kinematics import Chain
from topple.robots.collision.separation import Candidates, ConvexSets, Frames, gaps
from topple.topology.arrays import FloatArray

SAMPLES = 4096  # a pair that meets in 0.1 % of the states is then missed once in sixty
NEAR = 0.005  # [m] pairs that come this close are kept too, which makes missing one rarer still
ALWAYS = 0.9  # share of states above which two links overlap by construction of their hulls


def colliding_pairs(
    chain: Chain,
    hulls: Sequence[FloatArray],
    frame_of_link: Sequence[int],
    offsets: FloatArray,
    home: FloatArray | None,
) -> tuple[tuple[int, int], ...]:
    """Pairs of links that hit each other in some states and not in others.

    Links that do not move against each other, neighbours along the chain, pairs that overlap by construction
    (in nearly all states, or in the arm's own home state) and pairs that never come near are left out.

    Args:
        chain: The driven joints.
        hulls: Per link its (V, 3) hull vertices in the link frame; empty without geometry.
        frame_of_link: Per link the chain frame that carries it.
        offsets: (L, 4, 4) poses of the links in those frames.
        home: (n,) a state that is free; None where none is known.

    Returns:
        Pairs of link indices.
    """
    with_hull = [i for i, hull in enumerate(hulls) if len(hull)]
    frame = [frame_of_link[i] for i in with_hull]
    placed = [hulls[i] @ offsets[i][:3, :3].T + offsets[i][:3, 3] for i in with_hull]
    sets = ConvexSets.of(placed, frame)
    pairs = np.array([(i, j) for i, j in combinations(range(len(frame)), 2) if abs(frame[i] - frame[j]) > 1])
    states = np.random.default_rng(0).uniform(chain.lower, chain.upper, (SAMPLES, chain.size))
    if home is not None:
        states[0] = home
    frames = Frames.of(chain.poses(states))
    centres = frames.points(sets.frame, sets.centre).transpose(2, 1, 0)
    found: list[tuple[int, int]] = []
    for i, j in pairs.tolist():
        apart = centres[:, i] - centres[:, j]
        near = np.flatnonzero(
            np.einsum("ij,ij->i", apart, apart) < (sets.radius[i] + sets.radius[j] + NEAR) ** 2
        )
        many = np.full(len(near), i), np.full(len(near), j)
        need = np.full(len(near), NEAR, dtype=np.float32)
        gap = gaps(sets, frames, Candidates(near, *many, apart[near], need), iterations=12)
        meets = near[gap <= NEAR]
        built_so = home is not None and bool((gap[near == 0] <= 0.0).any())
        if 0 < len(meets) < ALWAYS * SAMPLES and not built_so:
            found.append((with_hull[i], with_hull[j]))
    return tuple(found)
