"""Whether the upward direction fits the scene: how much stands in equilibrium with it, and with another."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from operator import is_

import numpy as np

from topple.topology.base.arrays import FloatArray, bounds, sum_of_rows
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import RIGID, VOXEL
from topple.topology.base.values import FrozenDict
from topple.topology.geometry.plane import up_from_fixed
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.statics.contact import Contact, find_contacts
from topple.topology.statics.holding import deficits
from topple.topology.statics.rest import Statics, within_reach
from topple.topology.statics.tolerances import ALONG, APART, BETTER, FAR_OFF, HANGING

_LEVEL = ("table", "ground", "floor")

GIVEN_UP = "the up that is given (up=, or the scene's own up or table_plane)"

_FLOOR = "\n"  # no object's name: names have printable characters only


def check_up(scene: Scene, statics: Statics | None = None) -> None:
    """Refuse a scene that hangs in the air with its `up` and would stand with another.

    Bodies at rest are in equilibrium. Where much of their weight is carried by nothing with the direction
    given, the normal of the table and the opposite direction are tried, and without a fixed object the axes.

    Args:
        scene: A scene that knows where up is.
        statics: The scene at rest where it has been worked out before.

    Raises:
        InvalidInput: Another direction fits and this one does not; the line says which, or how to have it
            found. None fits and all objects are metres apart, as with poses in millimetres. Also where the
            scene has no `up`.
    """
    statics = Statics.of(scene) if statics is None else statics
    if not statics.weights:
        return
    assert scene.up is not None  # statics needs it
    _check_distances(scene, statics)
    if unborne_share(statics) < HANGING:
        return
    hanging = unborne_share(Statics.of(scene))  # by the clouds alone, as with the other directions
    if hanging < HANGING:
        return
    for other in _other_directions(scene, scene.up):
        if unborne_share(Statics.of(scene.with_up(other))) <= hanging - BETTER:
            raise InvalidInput(_contradiction(scene, scene.up, other, hanging))


def _check_distances(scene: Scene, statics: Statics) -> None:
    """Refuse objects that hang in the air whichever way is up, each of them far from all others."""
    low, high = np.array([bounds(cloud) for cloud in scene.clouds.values()]).swapaxes(0, 1)
    apart = np.linalg.norm(np.maximum(low[:, None] - high, low - high[:, None]).clip(min=0.0), axis=2)
    np.fill_diagonal(apart, np.inf)
    moves = np.array([name not in scene.fixed for name in scene.clouds])
    nearest = float(apart.min(axis=1)[moves].min())
    bottoms = np.array([surface[:, 2].min() for surface in statics.surfaces.values()])
    level = not scene.fixed and np.ptp(bottoms) < FAR_OFF
    if nearest <= FAR_OFF or level or (scene.fixed and unborne_share(statics) < HANGING):
        return
    spread, width = np.ptp((low + high) / 2.0, axis=0).max(), np.median((high - low)[moves].max(axis=1))
    unit, factor = ("millimetres", 1000) if spread > 1000 * width / 2.0 else ("centimetres", 100)
    raise InvalidInput(
        f"the objects are some {width:.2g} m wide, and each is {nearest:.3g} m and more from all others and "
        f"carried by nothing, whichever way is up: are the poses in {unit}? topple takes metres, so divide "
        f"their translations by {factor}"
    )


def unborne_share(statics: Statics) -> float:
    """How much of the weight of a scene nothing carries.

    A table carries what is above it and nothing below it; without a fixed object a floor is laid under the
    lowest point. Of what only contacts that no camera saw would carry, half counts.

    Args:
        statics: The scene at rest.

    Returns:
        The share, 0..1.
    """
    standing, surfaces = _contacts(statics)
    contacts = [part for contact in standing if (part := _pushes(contact, surfaces, statics)) is not None]
    seen = [contact for contact in contacts if not contact.inferred]
    shares = [_missing_share(statics, seen)]
    shares.append(shares[0] if len(seen) == len(contacts) else _missing_share(statics, contacts))
    return float(np.mean(shares))


def _missing_share(statics: Statics, contacts: Sequence[Contact]) -> float:
    """Share of the weight that contacts leave uncarried; what all of them leave is known."""
    if len(contacts) == len(statics.contacts) and all(map(is_, contacts, statics.contacts)):
        deficit = statics.unexplained
    else:
        deficit = deficits(statics.weights, within_reach(contacts, statics.weights))
    masses = {name: weight.mass for name, weight in statics.weights.items()}
    return sum(masses[name] * min(deficit[name], 1.0) for name in masses) / sum(masses.values())


def _contacts(statics: Statics) -> tuple[tuple[Contact, ...], Mapping[str, FloatArray]]:
    """The contacts and surfaces of the scene; with a floor's where nothing is fixed."""
    if statics.upright.fixed:
        return statics.contacts, statics.surfaces
    low, high = bounds(np.concatenate(list(statics.surfaces.values())))
    along, across = (np.arange(low[k], high[k] + VOXEL, 2 * VOXEL) for k in (0, 1))
    plan = np.column_stack([each.ravel() for each in np.meshgrid(along, across)])
    floor = np.column_stack([plan, np.full(len(plan), low[2])])
    clouds = FrozenDict({**statics.upright.clouds, _FLOOR: floor})
    tops, rest = FrozenDict({_FLOOR: (floor,)}), FrozenDict({_FLOOR: np.empty((0, 3))})
    upright = replace(statics.upright, clouds=clouds, fixed=frozenset({_FLOOR}), tops=tops, rest=rest)
    surfaces = {**statics.surfaces, _FLOOR: floor}
    return find_contacts(upright, surfaces), surfaces


def _pushes(contact: Contact, surfaces: Mapping[str, FloatArray], statics: Statics) -> Contact | None:
    """The part of a contact in which a fixed surface has the object on the side to which it pushes."""
    fixed = statics.upright.fixed | {_FLOOR}
    if (contact.a in fixed) == (contact.b in fixed):
        return contact
    ground_first = contact.a in fixed
    middle = surfaces[contact.b if ground_first else contact.a].mean(axis=0)
    beyond = sum_of_rows((middle - contact.points) * contact.normals)
    # Points are those of the object: the surface lies deeper by the gap.
    pushing = beyond + contact.gaps > 0 if ground_first else beyond < 0
    if len(contact.normals) == 1 or np.ptp(contact.normals, axis=0).max() > 0:
        # What hangs on a peg, not on a plane, has its middle below it: the surfaces nearest tell the side.
        a, b = (_around(contact.points, surfaces[name]) for name in (contact.a, contact.b))
        pushing |= sum_of_rows((b - a) * contact.normals) > 0
    return contact.only(pushing)


def _around(points: FloatArray, surface: FloatArray) -> FloatArray:
    """Middles of the ten points of a surface that are nearest to each of some points."""
    nearest = PointTree(surface).query(points, k=min(10, len(surface)))[1]
    return surface[nearest.reshape(len(points), -1)].mean(axis=1)


def _other_directions(scene: Scene, up: FloatArray) -> Iterator[FloatArray]:
    """Directions that people mean when they give another one, each once, the likely ones first.

    What hangs on a wall lies on it as well as on a table: only with what is called a table, or by a mask's
    label, or with nothing fixed, its normal and the axes of the frame are tried.
    """
    tables = [name for name in scene.clouds if name in scene.fixed and _is_level(name)]
    found = up_from_fixed(scene.clouds, tables, scene.viewpoints)
    likely = [] if found is None else [found[0]]
    axes = [] if scene.fixed and not tables else [*np.eye(3)[::-1], *-np.eye(3)[::-1]]
    tried = [up]
    for direction in (*likely, -up, *axes):
        if all(float(direction @ other) < APART for other in tried):
            tried.append(direction)
            yield direction


def _is_level(name: str) -> bool:
    return name.isdigit() or name.lower() in _LEVEL


def _contradiction(scene: Scene, up: FloatArray, other: FloatArray, hanging: float) -> str:
    """The line that says what does not fit and what would."""
    what = f"up is {_words(up)}, but then nothing carries {hanging:.0%} of the weight of the objects"
    fits, give = f"with up {_words(other)} they stand", f"up=[{_words(other).replace(' ', ', ')}]"
    if scene.images and not scene.fixed:
        return (
            f"{what}: in a depth image up is a direction of the camera's frame (0 0 1 is its viewing axis); "
            f"name what they stand on by its label, fixed=LABEL, and leave out {GIVEN_UP}; {fits}"
        )
    cure = f"give {give}, or turn round the up or table_plane that the scene gives"
    found = up_from_fixed(scene.clouds, sorted(scene.fixed), scene.viewpoints)
    if any(float(other @ turned) > ALONG for turned in _as_in_opengl(scene, up)):
        cure = (
            "is the camera's pose in OpenGL axes, y up and z backward? give pose @ diag(1, -1, -1, 1); or, "
            f"if the pose is right, {give}"
        )
    elif scene.images and found is not None and float(found[0] @ up) > APART:
        named = " and ".join(sorted(scene.fixed))
        cure = f"is it {named} that they stand on? say with fixed=NAME what is; or give {give}"
    elif scene.images:
        cure = f"leave out {GIVEN_UP}, and it is taken from what is fixed; or give {give}"
    elif not scene.fixed:
        cure = f"give {give}, or name what carries them with fixed=NAME"
    return f"{what}, while {fits}: {cure}"


def _as_in_opengl(scene: Scene, up: FloatArray) -> Iterator[FloatArray]:
    """Where up would point if the poses of the pictures had y up and z backward, where they have any pose."""
    for image in scene.images:
        across = image.pose_camera_to_world[:3, 0]
        if np.abs(image.pose_camera_to_world - np.eye(4)).max() > RIGID:
            yield 2.0 * across * float(across @ up) - up


def _words(direction: FloatArray) -> str:
    """A direction as people type it: an axis where it is one but for noise."""
    axis = np.sign(direction) * (np.abs(direction) > ALONG)
    direction = axis if axis.any() else direction
    return " ".join(f"{value + 0.0:.3g}" for value in np.round(direction, 3))
