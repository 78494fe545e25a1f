"""An arrangement in words, worked out: "plate on table, bowl on plate, spoon left of plate"."""

import os
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.decide.goal import Place, PlaceRelation, clauses_in, holds, parse_goal
from topple.planner.errors import NoSafePlan
from topple.planner.placement.lowered import lower
from topple.planner.placement.placement import Placement, placements
from topple.planner.placement.proof import Proof
from topple.planner.placement.resting import about, resting_poses
from topple.planner.placement.stacking import placements_on
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.tolerances import BESIDE, CHOICE, HEADINGS
from topple.planner.simulate.sandbox import Sandbox
from topple.robots.collision.fcl_bodies import apart
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.values import Word
from topple.topology.geometry.axes import level_axes
from topple.topology.situation.situation import Situation


class Side(Word):
    """On which side of another thing something shall lie, as seen along x of the robot's base."""

    LEFT = "left of"
    RIGHT = "right of"
    BEHIND = "behind"
    BEFORE = "in front of"


TOWARDS = {
    Side.LEFT: (0.0, 1.0),
    Side.RIGHT: (0.0, -1.0),
    Side.BEHIND: (1.0, 0.0),
    Side.BEFORE: (-1.0, 0.0),
}
"""(2,) directions along x, which leads away from who looks, and y, to their left."""


@dataclass(frozen=True)
class Beside:
    """An object that shall lie on one side of another one."""

    object: str
    side: Side
    where: str


def arrange_by_words(words: str, situation: Situation) -> Arrangement:
    """Work out an arrangement that words describe, with as little moved as they ask for.

    What already lies as it is told to stays; what is not named stays too, unless it is where something else
    shall be.

    Args:
        words: "A on B", "A within B", "A left of B", "A right of B", "A behind B" and "A in front of B",
            joined by "and" or commas.
        situation: How things lie now.

    Raises:
        InvalidInput: The words are none of these, or name a thing twice.
        UnknownObject: A name is not in the scene.
        NoSafePlan: Somewhere there is no room; or the words go round in a circle.
    """
    if not words.strip():
        raise InvalidInput('the arrangement is empty: say where objects go, as "cup left of plate"')
    return laid_out(_read(words, situation), situation)


def laid_out(
    clauses: Sequence[Place | Beside], situation: Situation, leaving: Collection[str] = ()
) -> Arrangement:
    """Find places for some things, with as little moved as they ask for.

    Args:
        clauses: What shall lie where, each thing once.
        situation: How things lie now.
        leaving: Of these, what has to go elsewhere even where it lies as told.

    Raises:
        NoSafePlan: Somewhere there is no room; or the clauses go round in a circle.
    """
    return _Laying(situation, leaving).all(_below_first(clauses))


def _read(words: str, situation: Situation) -> list[Place | Beside]:
    """The clauses."""
    scene, sides, said = situation.scene, list[Beside](), list[str]()
    pattern = re.compile(rf"^(.+?)\s+({'|'.join(Side)})\s+(.+)$")
    for clause in clauses_in(words, scene):
        found = pattern.match(clause)
        if found is None:
            said.append(clause)
            continue
        name, side, where = found.groups()
        for known in (name, where):
            if known not in scene.clouds:
                raise UnknownObject(known, scene.names)
        if name in scene.fixed or name == where:
            raise InvalidInput(f"{clause!r}: {name} is not to be moved there")
        sides.append(Beside(name, Side(side), where))
    goal = parse_goal(", ".join(said), scene) if said else None
    if goal is not None and (goal.free or goal.empty):
        raise InvalidInput(f"{words!r} does not say where objects go: 'free' and 'empty' are goals")
    clauses: list[Place | Beside] = [*(goal.places if goal is not None else ()), *sides]
    names = [clause.object for clause in clauses]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise InvalidInput(f"{words!r} names two places for {', '.join(twice)}: give one")
    return clauses


def _below_first(clauses: Sequence[Place | Beside]) -> list[Place | Beside]:
    """Clauses, what is below or beside others first."""
    done, left = list[Place | Beside](), list(clauses)
    while left:
        ready = [each for each in left if each.where not in {other.object for other in left}]
        if not ready:
            circle = " and ".join(sorted(each.object for each in left))
            raise NoSafePlan(f"the words go round in a circle: {circle}", (circle,))
        done, left = [*done, *ready], [each for each in left if each not in ready]
    return done


def is_words(goal: str) -> bool:
    """Whether a goal describes an arrangement, and is no path of one."""
    told = re.search(rf"\s(on|within|in|{'|'.join(Side)})\s", goal) is not None
    return told and not os.path.exists(goal)  # which takes words too long for a path


class _Laying:
    """Things laid out one after the other, in thought.

    Args:
        situation: How they lie now.
        leaving: What may not stay, even where it lies as told.
    """

    def __init__(self, situation: Situation, leaving: Collection[str] = ()) -> None:
        self._start, self._up, self._leaving = situation, situation.up, leaving
        self._poses: dict[str, FloatArray] = {}

    def all(self, clauses: Sequence[Place | Beside]) -> Arrangement:
        """Lay out what is named, then what is in its way."""
        start, waiting = self._start, [clause.object for clause in clauses]
        for clause in clauses:
            name = clause.object
            if not self._kept(clause):
                there = self._there(waiting, but=name)
                if isinstance(clause, Beside):
                    there = there.without(*self._makes_room(clause, clauses, there))
                self._poses[name] = self._steady_motion(name, there, self._places(clause, there))
            waiting.remove(name)
        named = {clause.object for clause in clauses}
        for name in [n for n in start.movable if n not in named]:
            if self._in_the_way(name, clauses):
                there = self._there((), but=name)
                self._poses[name] = self._steady_motion(name, there, placements(name, there, limit=CHOICE))
        inside = [c for c in clauses if isinstance(c, Place) and c.how is PlaceRelation.WITHIN]
        return Arrangement(self._there(()).scene, pose_free={place.object: place for place in inside})

    def _there(self, waiting: Sequence[str], but: str | None = None) -> Situation:
        """Things where they shall be, without those that have no place yet; one of them where it is now."""
        found = self._start
        for name, pose in self._poses.items():
            found = found.moved((name,), pose)
        return found.without(*(name for name in waiting if name != but and name not in self._poses))

    def _makes_room(self, clause: Beside, clauses: Sequence[Place | Beside], there: Situation) -> list[str]:
        """List objects that are not named, and may have to go where one shall lie beside another."""
        named = {name for each in clauses for name in (each.object, each.where)}
        carrying = {each.supporter for each in self._start.supports if each.supported == clause.where}
        return [name for name in there.movable if name not in named | carrying]

    def _kept(self, clause: Place | Beside) -> bool:
        """Whether a thing lies as told already, on what stays where it is."""
        if isinstance(clause, Beside) or clause.where in self._poses or clause.object in self._leaving:
            return False
        return holds(clause, self._start.relations, self._start.supports)

    def _places(self, clause: Place | Beside, there: Situation) -> list[Placement]:
        """Where a thing may go, best first."""
        if isinstance(clause, Beside):
            return self._beside(clause, there)
        if clause.where in there.scene.fixed and clause.how is PlaceRelation.ON:
            return placements(clause.object, there, limit=CHOICE)
        found = placements_on(clause.object, there, clause.where, clause.how, limit=CHOICE)
        down = (lower(clause.object, there, place.pose_at_rest(self._up)) for place in found)
        return [place for place in down if place is not None and place.into == clause.where]

    def _beside(self, clause: Beside, there: Situation) -> list[Placement]:
        """A thing at the side of another one, lying along it."""
        up, cloud, other = self._up, there.scene.clouds[clause.object], there.scene.clouds[clause.where]
        x, y = self._axes()
        along, across = TOWARDS[clause.side]
        out = along * x + across * y
        found: list[Placement] = []
        rest = resting_poses(cloud, there.solids[clause.object], up)[0]
        middle = (other.min(axis=0) + other.max(axis=0)) / 2.0
        edge = float((other @ out).max())
        for k in range(HEADINGS):
            turned = cloud @ (about(up, 2.0 * np.pi * k / HEADINGS) @ rest.rotation).T
            pose = np.eye(4)
            pose[:3, :3] = about(up, 2.0 * np.pi * k / HEADINGS) @ rest.rotation
            pose[:3, 3] = middle - (turned.min(axis=0) + turned.max(axis=0)) / 2.0
            pose[:3, 3] += (edge + BESIDE - float((turned @ out).min()) - pose[:3, 3] @ out) * out
            place = lower(clause.object, there, pose)
            if place is not None and place.into is None:
                found.append(replace(place, score=-float(np.ptp(turned @ out))))
        return sorted(found, key=lambda place: -place.score)

    def _axes(self) -> tuple[FloatArray, FloatArray]:
        """(3,) level unit vectors: away from who looks, and to their left."""
        base, up = self._start.scene.robot_base, self._up
        forward = np.array([1.0, 0.0, 0.0]) if base is None else base[:3, 0]
        forward = forward - (forward @ up) * up
        if np.linalg.norm(forward) < 0.1:
            forward = level_axes(up)[0]
        forward = forward / np.linalg.norm(forward)
        return forward, np.asarray(np.cross(up, forward))

    def _steady_motion(self, name: str, there: Situation, places: Sequence[Placement]) -> FloatArray:
        """(4, 4) motion to the first place at which a thing stays, as it then lies.

        Raises:
            NoSafePlan: There is none.
        """
        with Sandbox() as sandbox:
            proof = Proof(name, there, sandbox=sandbox)
            held = next((place for place in places if proof.holds(place)), None)
        if held is None:
            words = f"{name} would stay nowhere where the words put it"
            raise NoSafePlan(words, (words,))
        return held.pose_at_rest(self._up)

    def _in_the_way(self, name: str, clauses: Sequence[Place | Beside]) -> bool:
        """Whether a thing that is not named is where another one shall be, or lies on one that leaves."""
        there = self._there(())
        below = {each.supporter for each in self._start.supports if each.supported == name}
        others = (c.object for c in clauses if c.object in self._poses and c.where != name)
        meets = any(not apart(there.solids[name], there.solids[other], 0.0) for other in others)
        return meets or bool(below & self._poses.keys())
