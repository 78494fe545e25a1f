"""Where a thing comes to rest once it is let go: dropped in simulation among bodies that hold still."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from topple.planner.placement.placement import Placement
from topple.planner.placement.rehearsal import Rehearsal
from topple.planner.placement.tolerances import CLEAR, OTHER_FACE, QUIET, SECONDS
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots.collision.fcl_bodies import apart
from topple.robots.engines import INSTALLED
from topple.robots.poses import angle_between
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids, moved
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation


class Drops:
    """A simulated world in which one object is let go time and again, to be used with `with`.

    Args:
        name: The object.
        bodies: Convex parts of all objects, in the world; the others stay where they are.
        up: (3,) unit vector.
        loose: Others that can be pushed; they come to rest before anything is dropped.
        scene: Where masses and friction of the objects are given, if anywhere.
        rehearsal: The world to do it in, for one `Drops` at a time; one of its own where None.
    """

    def __init__(
        self,
        name: str,
        bodies: Solids,
        up: FloatArray,
        loose: Collection[str] = (),
        scene: Scene | None = None,
        rehearsal: Rehearsal | None = None,
    ) -> None:
        from topple.robots.world.bodies import Body
        from topple.robots.world.tolerances import FRICTION

        def body(which: str) -> Body:
            mass, friction = (None, FRICTION) if scene is None else (
                scene.masses.get(which), scene.friction.get(which, FRICTION)
            )  # fmt: skip
            made = Body.of(which, bodies[which], mass=mass, friction=friction)
            known = scene is not None and which in scene.centres
            return replace(made, centre_of_mass=scene.centres[which]) if scene and known else made

        kept = Rehearsal(up) if rehearsal is None else rehearsal
        self._own = kept if rehearsal is None else None
        self.name, self._level, self._loose = name, kept.level, sorted({*loose} - {name})
        rough = {} if scene is None else scene.friction
        still = [other for other in bodies if other != name and other not in loose]
        self._world = kept.among({other: (bodies[other], rough.get(other, FRICTION)) for other in still})
        for other in self._loose:
            self._world.add(body(other), self._level)
        if loose:
            self._world.settle(SECONDS)
        self._settled = {other: self._world.pose(other) for other in self._loose}
        self._world.add(body(name), self._level)

    def __enter__(self) -> "Drops":
        return self

    def __exit__(self, *_: object) -> None:
        for moving in (self.name, *self._loose):
            self._world.remove(moving)
        if self._own is not None:
            self._own.close()

    @property
    def centre_of_mass(self) -> FloatArray:
        """(3,) of the object where `bodies` has it [m]."""
        return self._world.body(self.name).centre_of_mass

    @property
    def _corners(self) -> FloatArray:
        """(V, 3) of the object's parts where `bodies` has it [m]."""
        return np.vstack(self._world.body(self.name).parts)

    def rest(self, pose_before_to_release: FloatArray) -> FloatArray:
        """Let the object go.

        Args:
            pose_before_to_release: (4, 4) rigid transform in the world from where `bodies` has it.

        Returns:
            (4, 4) rigid transform from there to where it comes to rest, or is after `SECONDS`.
        """
        for other, pose in self._settled.items():
            self._world.place(other, pose)
        self._world.place(self.name, self._level @ pose_before_to_release)
        self._world.settle(SECONDS)
        return np.asarray(self._level.T @ self._world.pose(self.name), dtype=np.float64)

    def push(self) -> float:
        """How much the last drop disturbed what is loose, at most: 1 is as much as counts."""
        most = 0.0
        for other, settled in self._settled.items():
            now, centre = self._world.pose(other), self._world.body(other).centre_of_mass
            way = float(np.linalg.norm((now - settled) @ np.append(centre, 1.0)))
            most = max(most, way / DISTURBED, angle_between(now, settled) / TURNED)
        return most

    def tipping(self, place: Placement, up: FloatArray) -> tuple[FloatArray, float] | None:
        """How the object turns (3, 3) in its own axes from how a placement has it, and how low it then is.

        None where it stays.
        """
        meant, rest = place.pose_at_rest(up), self.rest(place.pose_before_to_after)
        way = (rest - meant) @ np.append(self.centre_of_mass, 1.0)
        if np.linalg.norm(way) < DISTURBED and angle_between(rest, meant) < OTHER_FACE:
            return None
        low = float((self._corners @ rest[:3, :3].T @ up).min() + rest[:3, 3] @ up)
        return meant[:3, :3].T @ rest[:3, :3], low

    def laid(self, place: Placement, turn: FloatArray, low: float, up: FloatArray) -> Placement:
        """A placement turned in the object's own axes by (3, 3) and brought to a height.

        Its centre of mass stays over the same spot.
        """
        pose, centre = place.pose_before_to_after.copy(), self.centre_of_mass
        middle = pose[:3, :3] @ centre + pose[:3, 3]
        pose[:3, :3] = pose[:3, :3] @ turn
        pose[:3, 3] = middle - pose[:3, :3] @ centre
        lowest = float((self._corners @ pose[:3, :3].T @ up).min() + pose[:3, 3] @ up)
        pose[:3, 3] += (low + place.drop - lowest) * up
        return replace(place, pose_before_to_after=pose, rest="as it comes to lie by itself")


def staying(
    places: Sequence[Placement],
    name: str,
    where: str,
    situation: Situation,
    contents: Collection[str] = (),
) -> tuple[list[Placement], list[Placement]]:
    """The placements from which an object comes to rest in a container, by the relation of what is seen.

    Asked of where each one puts it, and of where it rolls to when it is let go there in simulation.

    Args:
        places: Placements into the container.
        name: The object.
        where: The container.
        situation: Where they are.
        contents: What lies in the container.

    Returns:
        Those that hold and disturb nothing that lies there, and all that hold; clear of the contents first,
        then what pushes them least, falls least far, and rolls least.
    """
    scene, rule, bodies, up = situation.scene, situation.relations.rule, situation.solids, situation.up
    container = rule.prepare(where, scene.clouds[where])

    def inside(pose: FloatArray) -> bool:
        (cloud,) = moved((scene.clouds[name],), pose)
        pair = rule.relate(rule.prepare(name, cloud), container)
        return pair.relation in (Relation.WITHIN, Relation.PARTIAL_WITHIN)

    found = [place for place in places if inside(place.pose_at_rest(up))]
    if not INSTALLED:  # by geometry alone
        return found, found
    gentle: list[tuple[tuple[float, ...], Placement]] = []
    kept: list[tuple[tuple[float, ...], Placement]] = []
    if found:
        with Drops(name, bodies, up, contents, scene) as drops:
            for place in found:
                rest = drops.rest(place.pose_before_to_after)
                if inside(rest):
                    way = (rest - place.pose_at_rest(up)) @ np.append(drops.centre_of_mass, 1.0)
                    there, push = moved(bodies[name], rest), drops.push()
                    beside = not all(apart(there, bodies[other], CLEAR) for other in contents)
                    quiet = (
                        beside,
                        round(2.0 * push),
                        place.drop,
                        round(float(np.linalg.norm(way)) / DISTURBED),
                    )
                    kept.append((quiet, place))
                    gentle += kept[-1:] if push < QUIET else []
    return _quietest(gentle), _quietest(kept)


def _quietest(found: Sequence[tuple[tuple[float, ...], Placement]]) -> list[Placement]:
    """Placements clear of what lies there first, then what pushes least, falls and rolls least."""
    return [place for _, place in sorted(found, key=lambda each: each[0])]


def standing(
    places: Sequence[Placement],
    name: str,
    situation: Situation,
    beside: Solids | None = None,
    rehearsal: Rehearsal | None = None,
) -> list[Placement]:
    """Placements on a table, those marked that an object does not keep when it is let go there.

    Each attitude is tried once in simulation; what tips over is put down as it came to lie. A hand may not
    get down with it so: what tips over from the attitude it has now comes last as it is, to fall by itself.

    Args:
        places: Placements on something fixed.
        name: The object.
        situation: Where it is now.
        beside: Bodies that it may stand on besides, by name.
        rehearsal: The world to let it go in; one of its own where None.

    Returns:
        The placements in their order, with `rolls` where it does not stay, and those that it falls from.
    """
    if not places or not INSTALLED:
        return list(places)
    up, scene, whole = situation.up, situation.scene, situation.completed
    others = {**situation.solids, **(beside or {}), name: whole[name]}
    known: dict[tuple[float, ...], tuple[FloatArray, float] | None] = {}
    found: list[Placement] = []
    falls: list[Placement] = []
    with Drops(name, others, up, scene=scene, rehearsal=rehearsal) as drops:
        for place in places:
            attitude = tuple(np.round(place.pose_before_to_after[:3, :3].T @ up, 3).tolist())
            if attitude not in known:
                known[attitude] = drops.tipping(place, up)
            turn = known[attitude]
            found.append(place if turn is None else replace(drops.laid(place, *turn, up), rolls=True))
            if turn is not None and place.tilt(up) < OTHER_FACE:
                falls.append(replace(place, rolls=True, falls=True, rest="as it was, to fall as it will"))
    return [*found, *falls]
