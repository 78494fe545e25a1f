"""A Scene from a running PyBullet world: what its collision shapes look like from all around."""

import itertools
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.robots.engine import pybullet
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.tolerances import AROUND, CELLS, DEEPEST, LARGEST, STEP
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.scene.friction import ROUGHEST
from topple.topology.scene.scene import Scene

RAYS = 16_000  # a call: PyBullet takes at most 16384
NAMELESS = frozenset(("", "baseLink", "base_link", "base", "link0"))  # what anything is called
DIRECTIONS = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if 0 < np.abs(d).sum() < 3], float)


@checked_arguments
def scene_from_world(
    client: int,
    *,
    names: Mapping[int, str] | None = None,
    fixed: Iterable[str] | None = None,
    ignore: Iterable[int] = (),
    up: ArrayLike = (0.0, 0.0, 1.0),
    spacing: float = TOLERANCES.cell,
) -> Scene:
    """Sample the surfaces of everything in a PyBullet world.

    Rays from eighteen sides meet the collision shapes themselves, whatever they were made from: primitives,
    meshes, compounds, bodies of several links. What no straight line from outside reaches has no points.

    Args:
        client: PyBullet's number of the simulation.
        names: Names by PyBullet's body number; a body without one is called as in its URDF file, or body_N.
        fixed: Names of what never moves; None: bodies of mass zero, and those fixed to the world.
        ignore: Body numbers to leave out: robots.
        up: (3,) direction against gravity.
        spacing: Of the rays in [m].

    Returns:
        The scene: a cloud (N, 3) in [m] for every body, its mass where it can move, and its friction. Where
        links differ in friction none is given; its assumptions say so.

    Raises:
        InvalidInput: If the world is empty, or there is none.
        UnknownObject: If `fixed` names something that is not there.

    Examples:
        >>> with World() as world:
        ...     world.add(Body.of("crate", [corners]))
        ...     scene_from_world(world.client, names={0: "crate"}).names
        ('crate',)
    """
    called = bodies_in(client, names or {}, ignore)
    if not called:
        raise InvalidInput(f"the PyBullet world {client} has no bodies: expected at least one")
    bodies = list(called)
    boxes = _trim_ground({body: box_of(client, body) for body in bodies})
    clouds = {called[body]: _surface(client, body, boxes[body], spacing) for body in bodies}
    clouds = {name: cloud for name, cloud in clouds.items() if len(cloud)}
    still = [called[body] for body in bodies if _is_fixed(client, body)] if fixed is None else list(fixed)
    for name in still:
        if fixed is not None and name not in clouds:
            raise UnknownObject(name, clouds, role="fixed object")
    seen = {body: name for body, name in called.items() if name in clouds}
    found = {name: _friction(client, body) for body, name in seen.items()}
    friction = {name: min(one, ROUGHEST) for name, one in found.items() if one is not None}
    notes = ["clouds are samples of the simulation's collision shapes, seen from all around"]
    for name, one in found.items():
        if one is None:
            notes.append(f"the links of {name!r} differ in friction: none is taken from them")
        elif one > ROUGHEST:
            notes.append(f"the friction of {name!r}, {one:g}, is taken as {ROUGHEST:g}")
    return Scene(
        clouds,
        fixed=[name for name in still if name in clouds],
        up=up,
        assumptions=notes,
        masses={name: mass for body, name in seen.items() if (mass := mass_of(client, body)) > 0},
        friction=friction,
    )


def bodies_in(client: int, given: Mapping[int, str], ignore: Iterable[int] = ()) -> dict[int, str]:
    """A name of its own for every body of a world.

    Args:
        client: PyBullet's number of the simulation.
        given: Names by body number.
        ignore: Numbers of bodies to leave out.

    Raises:
        InvalidInput: There is no such world.
    """
    if not pybullet.isConnected(client):
        raise InvalidInput(f"there is no PyBullet world {client}: expected what pybullet.connect returned")
    count: int = pybullet.getNumBodies(physicsClientId=client)
    numbers = {int(pybullet.getBodyUniqueId(k, physicsClientId=client)) for k in range(count)}
    called: dict[int, str] = {}
    for body in sorted(numbers - set(ignore)):
        link, model = (text.decode() for text in pybullet.getBodyInfo(body, physicsClientId=client))
        own = given.get(body) or model or (link if link not in NAMELESS else "") or f"body_{body}"
        called[body] = own if own not in called.values() else f"{own}_{body}"
    return called


def _is_fixed(client: int, body: int) -> bool:
    """Whether a body's base cannot move."""
    mass = pybullet.getDynamicsInfo(body, -1, physicsClientId=client)[0]
    return mass == 0.0


def _links(client: int, body: int) -> range:
    """Numbers of a body's links, its base being -1."""
    return range(-1, pybullet.getNumJoints(body, physicsClientId=client))


def mass_of(client: int, body: int) -> float:
    """Mass of a body with all its links [kg]; 0 where it cannot move."""
    if _is_fixed(client, body):
        return 0.0
    return float(
        sum(pybullet.getDynamicsInfo(body, k, physicsClientId=client)[0] for k in _links(client, body))
    )


def _friction(client: int, body: int) -> float | None:
    """Coefficient of friction of a body's surface; None where its links differ."""
    corners = {k: pybullet.getAABB(body, k, physicsClientId=client) for k in _links(client, body)}
    solid = [k for k, box in corners.items() if np.ptp(box, axis=0).max() > 0]  # the others have no shape
    found = {float(pybullet.getDynamicsInfo(body, k, physicsClientId=client)[1]) for k in solid or [-1]}
    return found.pop() if len(found) == 1 else None


def box_of(client: int, body: int) -> FloatArray:
    """(2, 3) lowest and highest corner of a body with all its links in [m]."""
    found = np.array([pybullet.getAABB(body, k, physicsClientId=client) for k in _links(client, body)])
    found = found[np.ptp(found, axis=1).max(axis=1) > 0]  # a link without a shape has no extent
    if len(found) == 0:
        return np.zeros((2, 3))
    return np.stack([found[:, 0].min(axis=0), found[:, 1].max(axis=0)])


def _trim_ground(boxes: dict[int, FloatArray]) -> dict[int, FloatArray]:
    """Boxes of the ground cut to the surroundings of the others, as a plane has no end."""
    small = [box for box in boxes.values() if np.ptp(box, axis=0).max() < LARGEST]
    if not small:
        around = np.array([[-1.0] * 3, [1.0] * 3])
    else:
        around = np.stack([np.min(small, axis=0)[0] - AROUND, np.max(small, axis=0)[1] + AROUND])
    cut: dict[int, FloatArray] = {}
    for body, box in boxes.items():
        large = np.ptp(box, axis=0).max() >= LARGEST
        cut[body] = np.clip(box, around[0], around[1]) if large else box
    return cut


def _surface(client: int, body: int, box: FloatArray, spacing: float) -> FloatArray:
    """(N, 3) first points of one body on rays from outside its box, from all sides."""
    extent = np.ptp(box, axis=0)
    if extent.max() <= 0:
        return np.zeros((0, 3))
    starts, ends = zip(*(_rays(box, direction, spacing) for direction in DIRECTIONS), strict=True)
    start, end = np.concatenate(starts), np.concatenate(ends)
    found: list[FloatArray] = []
    for first in range(0, len(start), RAYS):
        found.append(_first_hits(client, body, start[first : first + RAYS], end[first : first + RAYS]))
    points = np.concatenate(found)
    inside = ((points >= box[0] - spacing) & (points <= box[1] + spacing)).all(axis=1)
    return points[inside]


def _rays(box: FloatArray, direction: FloatArray, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Starts and ends (N, 3) of parallel rays through a box, on a grid."""
    middle, half = box.mean(axis=0), np.ptp(box, axis=0) / 2
    along = direction / np.linalg.norm(direction)
    aside = np.linalg.svd(along[None])[2][1:]
    reach = np.abs(aside) @ half
    counts = [int(np.clip(np.ceil(2 * r / spacing), 1, CELLS)) for r in reach]
    lines = [(np.arange(n) + 0.5) / n * 2 * r - r for n, r in zip(counts, reach, strict=True)]
    grid = np.stack(np.meshgrid(*lines), axis=-1).reshape(-1, 2)
    across = middle + grid @ aside
    depth = np.abs(along) @ half + 0.01
    return across + depth * along, across - depth * along


def _first_hits(client: int, body: int, start: FloatArray, end: FloatArray) -> FloatArray:
    """(M, 3) where rays first meet one body, whatever is before it."""
    along = end - start
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    found: list[FloatArray] = []
    for _ in range(DEEPEST):
        hits: Any = pybullet.rayTestBatch(start.tolist(), end.tolist(), numThreads=1, physicsClientId=client)
        number = np.array([hit[0] for hit in hits])
        place = np.array([hit[3] for hit in hits])
        found.append(place[number == body])
        other = (number >= 0) & (number != body)
        if not other.any():
            break
        start, end, along = place[other] + STEP * along[other], end[other], along[other]
    return np.concatenate(found)
