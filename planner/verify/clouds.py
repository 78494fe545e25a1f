"""Seen points against what the arm and the carried object fill: bodies may be entered, points not."""

from collections.abc import Iterator, Sequence

import numpy as np

from topple.planner.verify.replay import Finding, Replay
from topple.planner.verify.tolerances import FILLED, LOOKED, SHARE, STRAYS
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray, bounds, within_corners
from topple.topology.bodies.tolerances import GRAIN
from topple.topology.geometry.pieces import pieces_of, surface_spacing
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.geometry.thin import spacing_of, voxel_means

Solid = tuple[FloatArray, FloatArray, FloatArray]
"""Sides of a convex part, and the corners of its box."""


def _solids(parts: Sequence[FloatArray]) -> list[Solid]:
    return [(joggled_sides(part), *bounds(part)) for part in parts]


def _objects(replay: Replay) -> dict[str, list[Solid]]:
    return {name: _solids(parts) for name, parts in replay.parts.items()}


def _depths(replay: Replay) -> tuple[tuple[bool, Finding], ...]:
    """How deep seen points are in what may touch them, where the bodies were not asked [m].

    Each with whether it is of what an object is put on or into: there its bodies are no bar, its points are
    all that is.
    """
    scene, arm, found = replay.scene, replay.arm, list[tuple[bool, Finding]]()
    objects = replay.once(_objects)
    hulls = {name: _solids(parts) for name, parts in zip(arm.links, arm.parts, strict=True) if parts}
    every = max(round(LOOKED / replay.spacing), 1)
    for piece in replay.pieces:
        numbers = np.unique([*range(0, len(piece.states), every), len(piece.states) - 1])
        states = piece.states[numbers]
        tools = replay.tools(piece, states)
        links = np.matmul(replay.base, arm.forward(states, piece.hand))
        for pair in piece.may_touch:
            seen = [name for name in pair if name in piece.poses and name != piece.step.object]
            onto = piece.step.placement.into in seen
            if len(seen) != 1:
                continue
            cloud = move_points(scene.clouds[seen[0]], piece.poses[seen[0]])
            (other,) = pair - {seen[0]}
            lay = 0.0
            if other in hulls:
                poses, solids = links[:, arm.links.index(other)], hulls[other]
            elif other in piece.held:
                poses, solids = np.matmul(tools, piece.held[other]), objects[other]
                if not onto:  # as deep as it lay or is to lie is no entering
                    lay = _depth(move_points(cloud, inverse(poses[piece.at_rest])), solids)
            else:
                continue
            for number, pose in zip(numbers.tolist(), poses, strict=True):
                depth = _depth(move_points(cloud, inverse(pose)), solids) - lay
                found.append((onto, piece.finds(depth, f"{seen[0]} in {other} at state {number}")))
    return tuple(found)


def depths_in_arm(replay: Replay) -> Iterator[Finding]:
    """How deep seen points are in links and what is carried [m]."""
    return (finding for onto, finding in replay.once(_depths) if not onto)


def depths_in_load(replay: Replay) -> Iterator[Finding]:
    """How deep points of what an object is put on or into are in that object [m]."""
    return (finding for onto, finding in replay.once(_depths) if onto)


def outside(replay: Replay) -> Iterator[Finding]:
    """How far seen points are outside of the plan's bodies [m]."""
    for name, cloud in replay.scene.clouds.items():
        sides = [sides for sides, *_ in replay.once(_objects)[name]]
        out = beyond_all(sides, cloud)
        yield Finding(float(np.quantile(out, SHARE)), name)
        # a post on a large table is less than the share of strays, but its points hang together
        odd = voxel_means(cloud[out > FILLED], 2 * GRAIN)
        for piece in pieces_of(odd, surface_spacing(odd, spacing_of(cloud))):
            yield Finding(float(beyond_all(sides, piece).max()), name)


def beyond_all(solids: Sequence[FloatArray], points: FloatArray) -> FloatArray:
    """(N,) how far points (N, 3) are from the nearest of some solids, by their sides [m], negative inside."""
    return np.min([beyond(sides, points) for sides in solids], axis=0)


def _depth(points: FloatArray, solids: Sequence[Solid]) -> float:
    """How deep points are in solids [m], a few strays left out."""
    deep = np.zeros(len(points))
    for sides, lower, upper in solids:
        near = within_corners(points, lower, upper)  # a large table has few points in a hand
        deep[near] = np.maximum(deep[near], -beyond(sides, points[near]))
    return float(np.sort(deep)[max(len(deep) - 1 - STRAYS, 0)])
