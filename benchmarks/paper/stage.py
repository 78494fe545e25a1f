"""Scenes built, settled and checked by physics alone: what should touch touches, what should not is apart.

A layout is drawn anew where the settled bodies do not have the listed contacts. No answer of any rule is
looked at here.
"""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from topple.benchmarks.paper.things import Things
from topple.benchmarks.paper.truth import SCENES, PaperScene
from topple.robots.engine import pybullet
from topple.robots.scenarios.scenario import Unlucky
from topple.robots.world.world import World
from topple.topology.base.errors import ToppleError
from topple.topology.sixim.table import Relation

Layout = Callable[[World, np.random.Generator, Things], None]

GROUND = (0.9, 0.9)
"""Extent [m] of what everything stands on: the surroundings of the objects, as the paper keeps them."""
CONTACT = 0.001
"""Largest gap [m] of bodies that count as touching: what the solver leaves, and twice the mesh error."""
APART = 0.003
"""Least gap [m] of things that count as disjoint: a plain deviation of 2 mm, and noise on both sides."""
FLOOR = 0.002
"""The same for what is above the ground: the floor of the YCB bowl is 2.5 mm thick."""
STICKS_OUT = 0.003
"""What is partly in a container stands this far [m] above its rim, and reaches as far below it."""
BELOW = 0.001
"""What is within a container stays this far [m] below its rim."""
WATCHED = 0.5
"""Time [s] for which a settled scene may not change."""
CREEP = 0.001
"""Way [m] that nothing may move in that time."""
ATTEMPTS = 80
"""Draws for one variant."""
SEARCH = 0.05
"""Gaps are measured up to this [m]."""


@contextmanager
def staged(
    number: int, variant: int, seed: int, things: Things, layouts: Mapping[int, Layout]
) -> Generator[World]:
    """A settled scene of the paper.

    Args:
        number: Of the scene, 1 to 14.
        variant: Number of the jittered variant.
        seed: Of a family of variants: others have other poses.
        things: Where the objects of scenes 8 to 14 come from.
        layouts: Scene numbers to what fills a world.

    Yields:
        The world; it ends with the context.

    Raises:
        ToppleError: If no draw has the listed contacts.
    """
    scene, reason = SCENES[number], ""
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, number, variant, attempt])
        with World() as world:
            world.add_table(scene.ground, size=GROUND)
            try:
                layouts[number](world, rng, things)
                _rest(world)
                check(world, scene)
            except Unlucky as error:
                reason = str(error)
                continue
            yield world
            return
    raise ToppleError(f"scene {number}, variant {variant}: no layout in {ATTEMPTS} draws, the last: {reason}")


def _rest(world: World) -> None:
    """Wait until everything lies still, and see that it stays so."""
    if not world.settle(4.0):
        raise Unlucky("something does not come to rest")
    before = world.poses()
    world.step(round(WATCHED / world.time_step))
    for name, pose in world.poses().items():
        if np.linalg.norm((pose - before[name])[:3, 3]) > CREEP:
            raise Unlucky(f"{name} creeps")


def gap(world: World, a: str, b: str) -> float:
    """Smallest distance of two bodies [m], negative where they overlap, `SEARCH` where they are far apart."""
    found: Any = pybullet.getClosestPoints(
        world.ids[a], world.ids[b], distance=SEARCH, physicsClientId=world.client
    )
    return min((float(point[8]) for point in found), default=SEARCH)


def check(world: World, scene: PaperScene) -> None:
    """Hold a settled world against the listed relations.

    Args:
        world: The world.
        scene: What is listed.

    Raises:
        Unlucky: If a listed contact is none, or a pair that is not listed comes near.
    """
    for a, relation, b in scene.pairs:
        measured = gap(world, a, b)
        if relation is Relation.DISJOINT:
            if measured < (FLOOR if scene.ground in (a, b) else APART):
                raise Unlucky(f"{a} and {b} are {1e3 * measured:.1f} mm apart")
        elif measured > CONTACT:
            raise Unlucky(f"{a} and {b} do not touch: {1e3 * measured:.1f} mm")
        if relation in (Relation.WITHIN, Relation.PARTIAL_WITHIN):
            _check_held(world, a, b, whole=relation is Relation.WITHIN)


def _check_held(world: World, content: str, container: str, *, whole: bool) -> None:
    """Whether a thing reaches into a container, and sticks out of it unless it should be in there whole."""
    inner, outer = np.concatenate(world.parts(content)), np.concatenate(world.parts(container))
    rim = float(outer[:, 2].max())
    lowest = inner[inner[:, 2].argmin()]
    lower, upper = outer[:, :2].min(axis=0), outer[:, :2].max(axis=0)
    if lowest[2] > rim - STICKS_OUT or (lowest[:2] < lower).any() or (lowest[:2] > upper).any():
        raise Unlucky(f"{content} is not in {container}")
    over = float(inner[:, 2].max()) - rim
    if whole and over > -BELOW:
        raise Unlucky(f"{content} sticks {1e3 * over:.1f} mm out of {container}")
    if not whole and over < STICKS_OUT:
        raise Unlucky(f"{content} sticks only {1e3 * over:.1f} mm out of {container}")


def bring_together(world: World, mover: str, other: str) -> None:
    """Push a body sideways along the table until it touches another.

    Args:
        world: Where both are at rest.
        mover: Name of the body that moves.
        other: Name of the body it is pushed to.
    """
    for _ in range(4):
        found: Any = pybullet.getClosestPoints(
            world.ids[mover], world.ids[other], distance=SEARCH, physicsClientId=world.client
        )
        if not found:
            raise Unlucky(f"{mover} is too far from {other} to be pushed to it")
        nearest = min(found, key=lambda point: point[8])
        way = np.subtract(nearest[6], nearest[5])
        way[2] = 0.0
        length = float(np.linalg.norm(way))
        if nearest[8] < 2e-4 or length < 1e-6:
            return
        pose = world.pose(mover)
        pose[:3, 3] += way / length * (float(nearest[8]) - 1e-4)
        world.place(mover, pose)
        if not world.settle(2.0):
            raise Unlucky(f"{mover} does not come to rest beside {other}")
