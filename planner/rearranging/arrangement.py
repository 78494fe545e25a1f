"""How things shall lie in the end: a scene to copy, how it is built, and how far things are from it."""

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.building.build import BuildOrder, build_order
from topple.planner.building.standing import falling_in
from topple.planner.decide.goal import Goal, Place, PlaceRelation, holds
from topple.planner.rearranging.matching import Match, match_objects
from topple.planner.rearranging.possible import check_possible
from topple.planner.rearranging.registration import Registration, least, register, rest_of
from topple.planner.rearranging.steady import brace
from topple.planner.rearranging.tolerances import OTHER, SIZES
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.solids import up_of
from topple.topology.geometry.rigid import move_points
from topple.topology.io.load import AnyScene
from topple.topology.scene.frame import in_frame
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.topology.scene.scene import Scene

INSIDE = (Relation.WITHIN, Relation.PARTIAL_WITHIN)


@checked_arguments
class Arrangement:
    """A finished arrangement, seen, that things are to be brought to.

    Args:
        scene: How things shall lie, in the frame of what they lie in now, or the situation it was read as.
        matches: Which thing of it was taken to be which, where its names did not say.
        pose_free: Things of which it counts what they lie in, not in which pose.

    Examples:
        >>> finished = Arrangement(scene)
        >>> ArrangementTask(finished).goal(scene).text
        'book on table, cup on book'
    """

    def __init__(
        self,
        scene: AnyScene | Situation,
        matches: tuple[Match, ...] = (),
        pose_free: Mapping[str, Place] | None = None,
    ) -> None:
        self.situation, self.matches, self.pose_free = Situation.of(scene), matches, dict(pose_free or {})
        self._fits: dict[str, tuple[FloatArray, Registration]] = {}

    @staticmethod
    def alike(start: "Scene", goal: "Scene") -> "Arrangement":
        """A finished arrangement whose things are told by their shapes.

        Args:
            start: How things lie.
            goal: How things of these shapes shall lie.

        Raises:
            InvalidInput: There are others, or more.
        """
        return Arrangement(*match_objects(start, goal, up_of(start)))

    @cached_property
    def built(self) -> BuildOrder:
        """In which order it is put together.

        Raises:
            InvalidInput: The scene has no `up`, or nothing that moves.
        """
        return build_order(self.situation)

    @cached_property
    def first_down(self) -> frozenset[tuple[str, str]]:
        """(a, b): a has to be down before b, so that b is not barred and stands."""
        pairs = ((e.first, e.then) for e in self.built.footings)
        graph = brace(self.situation.movable, pairs, falling_in(self.situation.statics))
        return frozenset(graph.edges)

    def check(self, start: Situation) -> None:
        """Refuse a start that cannot become this.

        Args:
            start: How things lie.

        Raises:
            InvalidInput: It has other things, of other shapes, or another up; or no things can lie as in the
                goal.
        """
        goal = self.situation
        for here, there, words in ((start, goal, "the goal"), (goal, start, "the start")):
            missing = [name for name in here.movable if name not in there.movable]
            if missing:
                raise InvalidInput(
                    f"{', '.join(missing)}: not among what moves in {words}, which has "
                    f"{', '.join(there.movable) or 'nothing'}; things match by name: give both the same "
                    "things, or match by shape"
                )
        if float(start.up @ goal.up) < np.cos(np.radians(5.0)):
            raise InvalidInput("start and goal have another up: give both in one frame")
        check_possible(goal)
        whole = start.statics.sight is None and goal.statics.sight is None
        for name in start.movable:
            found, clouds = self.fit(name, start), [each.scene.clouds[name] for each in (start, goal)]
            # along the axes of the frame: those of a square are any, and its diagonal is no edge
            size, other = (np.ptp(each, axis=0) for each in (move_points(clouds[0], found.pose), clouds[1]))
            longer = float(np.abs(size - other).max()) if whole else 0.0
            if max(longer - SIZES, found.residual - OTHER) > 0.0:
                here, there = (" x ".join(f"{1e3 * each:.0f}" for each in edges) for edges in (size, other))
                raise InvalidInput(
                    f"{name} has another shape in the goal: {there} mm, and {here} mm at the start; "
                    "expected the same thing under the same name"
                )

    def in_frame(self, pose: FloatArray, up: FloatArray) -> "Arrangement":
        """The same in another frame: pose (4, 4) leads there, up (3,) is against gravity there."""
        return Arrangement(in_frame(self.situation.scene, pose, up), self.matches, self.pose_free)

    def fit(self, name: str, situation: Situation) -> Registration:
        """How an object has to be moved from where it is to where it shall be.

        Args:
            name: The object.
            situation: Where it is.
        """
        known, cloud = self._fits.get(name), situation.scene.clouds[name]
        if known is not None and known[0] is cloud:
            return known[1]
        guess, up = None if known is None else known[1].pose, self.situation.up
        surface = situation.surfaces[name] @ situation.statics.upright.rotation
        found = None if known is None else rest_of(known[1], known[0], cloud)
        if found is None:
            found = register(cloud, self.situation.scene.clouds[name], up, guess)
        found = least(found, cloud, surface, up)
        self._fits[name] = cloud, found
        return found

    def goal(self, scene: "Scene") -> Goal:
        """State the goal: which objects lie on and in which, and where everything is.

        Args:
            scene: How things lie now.

        Raises:
            InvalidInput: The scene has other things.
        """
        start = Situation.of(scene)
        self.check(start)
        places = tuple(filter(None, map(self._place, self.built.order)))
        if not places:
            raise InvalidInput("nothing in the goal is seen to rest on anything: expected an arrangement")
        fits = {name: self.fit(name, start) for name in scene.movable}
        told = {name: fit for name, fit in fits.items() if name not in self.pose_free}
        poses = {name: np.eye(4) if fit.stays else fit.pose for name, fit in told.items()}
        text = ", ".join(f"{place.object} {place.how} {place.where}" for place in places)
        return Goal(text, places=places, poses=poses, assumptions=tuple(map(str, self.matches)))

    def _place(self, name: str) -> Place | None:
        """Find the container or supporter of an object in the goal."""
        if name in self.pose_free:
            return self.pose_free[name]
        carrying = [each for each in self.situation.supports if each.supported == name]
        between, clouds, up = self.situation.relations.between, self.situation.scene.clouds, self.situation.up
        for each in carrying:
            below = float((clouds[name] @ up).mean()) < float((clouds[each.supporter] @ up).max())
            if below and between(name, each.supporter).relation in INSIDE:
                return Place(name, PlaceRelation.WITHIN, each.supporter)
        borne = [each for each in carrying if each.kind != "leans" and self._is_on(name, each.supporter)]
        sure = max(borne, key=lambda each: each.confidence, default=None)
        return None if sure is None else Place(name, PlaceRelation.ON, sure.supporter)

    def _is_on(self, name: str, other: str) -> bool:
        """Whether an object is on another one in the goal."""
        place, finished = Place(name, PlaceRelation.ON, other), self.situation
        return holds(place, finished.relations, finished.supports)
