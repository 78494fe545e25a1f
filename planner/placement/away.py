"""Where things go that are taken: into a bin, onto a level area, to a point in the air, or only clear of all.

What a caller vouches for is in no cloud: a bin beside the arm and a level area are bodies of their own. What
went there is none of the scene's any more; on a level area it stays in the way.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.placement.free_space import FreeSpace, free_around
from topple.planner.placement.placement import Placement, placements
from topple.planner.placement.resting import about
from topple.planner.placement.tolerances import (
    AHEAD,
    BIN_BESIDE,
    BIN_SIZE,
    BIN_SPOTS,
    BIN_WALL,
    HEIGHTS_IN_BIN,
    HIGHEST,
    LEVEL_WITH,
    LIFT_CLEAR,
    RAISED,
    SLAB,
    TOWARDS,
    YAWS,
)
from topple.robots.collision.fcl_bodies import apart
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import Word
from topple.topology.bodies.solids import Solids, move_parts
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.rigid import move_points

if TYPE_CHECKING:
    from topple.topology.situation.situation import Situation


class Away(Word):
    """Where things go that are taken."""

    TABLE = "table"
    """To a free place on what is seen."""
    LIFT = "lift"
    """Clear of everything, and no further: the caller's own skill goes on from there."""
    BIN = "bin"
    """Into an open box."""
    ZONE = "zone"
    """Onto a level area that the caller vouches for."""
    HAND_OVER = "hand-over"
    """To a point, where somebody takes it out of the hand."""


IN_HAND = (Away.LIFT, Away.HAND_OVER)
"""Where the hand keeps what it has taken."""
BODIES = {Away.BIN: "bin beside the arm", Away.ZONE: "area that is vouched for"}
"""Names of what is in no cloud."""
NUMBERS = {
    Away.BIN: (0, 7, "X Y Z YAW SX SY SZ"),
    Away.ZONE: (4, 5, "X0 Y0 X1 Y1, and Z where it is not level with the arm's foot"),
    Away.HAND_OVER: (3, 3, "X Y Z"),
}


@dataclass(frozen=True, eq=False)
class Destination:
    """Where things go that are taken, as a caller says it, in the frame of the arm's base.

    Attributes:
        how: Which.
        pose: (4, 4) pose_destination_to_base of the middle of its underside; None for a bin that is to be
            stood where there is room.
        size: (3,) of a bin or an area [m], along its axes.
    """

    how: Away
    pose: FloatArray | None = None
    size: FloatArray = field(default_factory=lambda: np.zeros(3))

    @staticmethod
    def of(words: "str | Sequence[str | float] | Destination") -> "Destination":
        """Read where things go.

        Args:
            words: "table", "lift", "bin", or with numbers [m, rad] in the frame of the arm's base: ("bin",
                X, Y, Z, YAW, SX, SY, SZ), the middle of its underside and its size; ("zone", X0, Y0, X1, Y1),
                two corners, and Z where it is not level with the arm's foot; ("hand-over", X, Y, Z), where
                the middle of the object is held out.

        Raises:
            InvalidInput: It is no such thing.
        """
        if isinstance(words, Destination):
            return words
        word, *given = [words] if isinstance(words, str) else list(words)
        known = ", ".join(Away)
        if word not in tuple(Away):
            raise InvalidInput(f"away is {word!r}: expected one of {known}")
        how = Away(word)
        least, most, names = NUMBERS.get(how, (0, 0, "no numbers"))
        if len(given) not in (least, most):
            raise InvalidInput(f"away {how} has {len(given)} numbers: expected {names}")
        try:
            values = [float(value) for value in given]
        except ValueError as error:
            raise InvalidInput(f"away {how} is {given}: expected {names} in metres and radians") from error
        if not all(math.isfinite(value) for value in values):
            raise InvalidInput(f"away {how} is {given}: expected finite {names} in metres and radians")
        if not values:
            return Destination(how, None, np.array(BIN_SIZE if how is Away.BIN else (0.0, 0.0, 0.0)))
        pose = np.eye(4)
        if how is Away.ZONE:
            low, high = np.minimum(values[:2], values[2:4]), np.maximum(values[:2], values[2:4])
            pose[:2, 3], size = (low + high) / 2.0, np.array([*(high - low), SLAB])
            pose[2, 3] = sum(values[4:]) - SLAB
        else:
            pose[:3, 3], size = values[:3], np.array(values[4:] or (0.0, 0.0, 0.0))
            if how is Away.BIN:
                pose[:3, :3] = about(np.array([0.0, 0.0, 1.0]), values[3])
        if how is not Away.HAND_OVER and not (size > 2.0 * BIN_WALL * (how is Away.BIN)).all():
            raise InvalidInput(f"away {how} is {given}: it has no room, expected {names} of some size")
        return Destination(how, pose, size)

    def at(self, situation: "Situation", pose_base_to_world: FloatArray) -> "Receiver | None":
        """Stand it beside an arm.

        Args:
            situation: What is seen.
            pose_base_to_world: (4, 4) where the arm stands.

        Returns:
            It, as it stands; None for the table, which is seen.

        Raises:
            InvalidInput: There is no room for a bin beside the arm, or it stands in something.
        """
        if self.how is Away.TABLE:
            return None
        if self.how is not Away.BIN:
            pose = np.eye(4) if self.pose is None else self.pose
            found = Receiver(self.how, pose_base_to_world @ pose, self.size, pose_base_to_world)
            return found.level_with(situation) if self.how is Away.ZONE else found
        tried = BIN_BESIDE if self.pose is None else ()
        found = [self.pose] if self.pose is not None else [_beside(r, a) for r in tried for a in _turns()]
        for pose in found:
            for rise in (0.0,) if self.pose is not None else np.arange(0.0, HIGHEST, 0.01).tolist():
                raised = pose_base_to_world @ pose
                raised[:3, 3] += rise * situation.up
                stood = Receiver(self.how, raised, self.size, pose_base_to_world)
                if stood.clear_of(situation):
                    return stood
        where = "there is no room for it beside the arm" if self.pose is None else "it stands in what is seen"
        raise InvalidInput(
            f"away bin: {where}; say with seven numbers where one stands: {NUMBERS[Away.BIN][2]}"
        )


@dataclass(frozen=True, eq=False)
class Receiver:
    """Where things go that are taken, as it stands.

    Attributes:
        how: Which.
        pose: (4, 4) in the world, of the middle of its underside; for hand-over of the point.
        size: (3,) along its axes [m].
        pose_base_to_world: (4, 4) of the arm.
    """

    how: Away
    pose: FloatArray
    size: FloatArray
    pose_base_to_world: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", freeze(self.pose))

    @property
    def bodies(self) -> Solids:
        """Bodies of the receiver that are in the way, by name: convex parts (8, 3) in the world [m]."""
        if self.how not in BODIES:
            return {}
        x, y, z = self.size
        boxes = [((0.0, 0.0, z / 2.0), (x, y, z))]
        if self.how is Away.BIN:
            w = BIN_WALL
            boxes = [((0.0, 0.0, w / 2.0), (x, y, w))]
            boxes += [((s * (x - w) / 2.0, 0.0, z / 2.0), (w, y, z)) for s in (-1.0, 1.0)]
            boxes += [((0.0, s * (y - w) / 2.0, z / 2.0), (x, w, z)) for s in (-1.0, 1.0)]
        return {BODIES[self.how]: [move_points(_corners(*box), self.pose) for box in boxes]}

    def move(self, pose: FloatArray) -> "Receiver":
        """The same in another frame, to which a rigid transform (4, 4) leads."""
        return replace(self, pose=pose @ self.pose, pose_base_to_world=pose @ self.pose_base_to_world)

    def level_with(self, situation: "Situation") -> "Receiver":
        """The same on the table that is seen there, where that is higher by no more than noise."""
        half, rise = self.size / 2.0, [0.0]
        for name in situation.scene.fixed:
            seen = move_points(situation.scene.clouds[name], inverse(self.pose)) - [0.0, 0.0, self.size[2]]
            on_it = (np.abs(seen[:, :2]) < half[:2]).all(axis=1) & (np.abs(seen[:, 2]) < LEVEL_WITH)
            rise += np.quantile(seen[on_it, 2], [0.98]).tolist() if on_it.any() else []
        pose = self.pose.copy()
        pose[:3, 3] += max(rise) * situation.up
        return replace(self, pose=pose)

    def clear_of(self, situation: "Situation") -> bool:
        """Whether nothing that is seen is where it stands."""
        whole = [move_points(_corners((0.0, 0.0, self.size[2] / 2.0), tuple(self.size)), self.pose)]
        return all(apart(whole, parts, 1e-3) for parts in situation.solids.values())

    def places(self, name: str, situation: "Situation", beside: Solids) -> list[Placement]:
        """Where an object may go, best first.

        Args:
            name: The object.
            situation: Where it is now.
            beside: What is in the way besides, by name.
        """
        if self.how is Away.LIFT:
            return self._clear(name, situation, beside)
        if self.how is Away.HAND_OVER:
            middle = np.vstack(situation.solids[name]).mean(axis=0)
            words, point = "where it is taken over", self.pose[:3, 3]
            return [self._at(situation, middle, point, k, words) for k in range(YAWS)]
        if self.how is Away.BIN:
            return self._in_bin(name, situation)
        base = self.pose_base_to_world
        return [
            replace(place, how=self.how)
            for place in placements(
                name, situation, pose_base_to_world=base, spaces=[self._space(name, situation, beside)]
            )
        ]

    def _at(
        self,
        situation: "Situation",
        middle: FloatArray,
        to: FloatArray,
        yaw: int,
        words: str,
        drop: float = 0.0,
    ) -> Placement:
        """Placement that turns an object about up and brings its middle from one point (3,) to another."""
        pose = np.eye(4)
        pose[:3, :3] = about(situation.up, 2.0 * np.pi * yaw / YAWS)
        pose[:3, 3] = to - pose[:3, :3] @ middle
        return Placement(pose, 1.0 - 0.1 * min(yaw, YAWS - yaw) / YAWS, words, drop, how=self.how)

    def _clear(self, name: str, situation: "Situation", beside: Solids) -> list[Placement]:
        """Straight the way out until nothing is near; then the same nearer to the arm, and before it."""
        own, middle = situation.solids[name], situation.scene.clouds[name].mean(axis=0)
        others = {**situation.solids, **beside}
        rest = [part for other, parts in others.items() if other != name for part in parts]
        up, base = situation.up, self.pose_base_to_world
        out, where = situation.way_out(name), "up" if situation.goes_up(name) else "out"
        inwards = base[:3, 3] + AHEAD * base[:3, 0] - middle
        inwards -= float(inwards @ up) * up
        found: list[Placement] = []
        for share in TOWARDS:
            aside = middle + share * inwards
            for rise in np.arange(RAISED, HIGHEST, 0.02).tolist():
                place = self._at(situation, middle, aside + rise * out, 0, f"{1e2 * rise:.0f} cm {where}")
                if apart(move_parts(own, place.pose_before_to_after), rest, LIFT_CLEAR):
                    found.append(place)
                    break
        return found

    def _in_bin(self, name: str, situation: "Situation") -> list[Placement]:
        """Over the middle of its floor first, as low as the hand gets."""
        up, parts = situation.up, np.vstack(situation.solids[name])
        middle = (parts.min(axis=0) + parts.max(axis=0)) / 2.0
        low = float((parts @ up).min() - middle @ up)
        found: list[Placement] = []
        for drop in (*HEIGHTS_IN_BIN, float(self.size[2])):
            for x, y in BIN_SPOTS:
                spot = move_points(
                    np.array([[x * self.size[0], y * self.size[1], BIN_WALL + drop]]), self.pose
                )[0]
                found += [
                    self._at(situation, middle, spot - low * up, k, "", drop) for k in range(0, YAWS, 2)
                ]
        return found

    def _space(self, name: str, situation: "Situation", beside: Solids) -> FreeSpace:
        """Find the free part of the level area."""
        axes, up = np.stack(level_axes(situation.up)), situation.up
        top = move_points(_corners((0.0, 0.0, self.size[2]), (self.size[0], self.size[1], 0.0)), self.pose)
        bodies = {other: parts for other, parts in {**situation.solids, **beside}.items() if other != name}
        del bodies[BODIES[self.how]]
        return free_around(BODIES[self.how], top, axes, up, bodies)

    def assumption(self) -> str:
        """State what is taken on trust, in a sentence; empty where nothing is."""
        x, y, z = np.round(self.pose[:3, 3], 3).tolist()
        wide, deep, high = (f"{1e2 * length:.0f}" for length in self.size)
        said: Mapping[Away, str] = {
            Away.BIN: f"a bin of {wide} x {deep} x {high} cm stands at {x:g} {y:g} {z:g}, unseen",
            Away.ZONE: f"{wide} x {deep} cm at {x:g} {y:g} {z:g} are level and free, unseen",
            Away.LIFT: "what is lifted is put away by other means before the next step begins",
            Away.HAND_OVER: "what is held out is taken from the hand before the next step begins",
        }
        return said.get(self.how, "")


def _turns() -> list[float]:
    """Directions [rad] from the arm in which a bin is tried: to its sides first, then behind it."""
    return [np.radians(sign * angle) for angle in (90.0, 60.0, 120.0, 150.0, 180.0) for sign in (1.0, -1.0)]


def _beside(distance: float, turn: float) -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3] = about(np.array([0.0, 0.0, 1.0]), turn + np.pi / 2.0)
    pose[:2, 3] = distance * np.cos(turn), distance * np.sin(turn)
    return pose


def _corners(middle: tuple[float, float, float], size: tuple[float, ...]) -> FloatArray:
    """(8, 3) corners of a box."""
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return np.asarray(middle + signs * np.array(size), dtype=np.float64)
