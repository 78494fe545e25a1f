"""A scene at rest: bodies, contacts and weights, and what would not stay if something were gone."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, bounds, middle_of
from topple.topology.base.remembered import remember
from topple.topology.base.tolerances import VOXEL
from topple.topology.base.values import FrozenDict
from topple.topology.bodies.surfaces import surfaces_of
from topple.topology.bodies.tolerances import KEPT_BODIES
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.axes import around
from topple.topology.geometry.sides import hull_volume
from topple.topology.geometry.thin import voxel_means
from topple.topology.geometry.tolerances import ENOUGH
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.sixim.relation_table import RelationTable
from topple.topology.sixim.table import Relation
from topple.topology.statics.contact import TOLERANCES, Contact, close_gap, find_contacts
from topple.topology.statics.equilibrium import Weight, islands
from topple.topology.statics.falling import Fall, catchers, falls
from topple.topology.statics.hidden import hidden_contacts
from topple.topology.statics.holding import Search, deficits
from topple.topology.statics.tolerances import (
    DENSITY,
    GUESSED,
    LEVER,
    REACH,
    ROLL,
    SHELL_CELL,
    TILT,
    UNSTEADY,
    WALL,
)
from topple.topology.views.free_space import FreeSpace

AROUND = around(12)
"""Directions in which a flat patch keeps its outermost point."""


@dataclass(frozen=True, eq=False)
class Statics:
    """What gravity can be asked about.

    Attributes:
        upright: The scene in a frame whose z axis is up.
        surfaces: name -> (N, 3) upright points [m] of the whole body, hidden parts completed.
        contacts: Patches between the bodies.
        weights: The movable objects' weights: as given, else guessed from their volume.
        unexplained: name -> missing share of the weight while everything is in place: what the
            clouds leave open.
        sight: What the cameras saw to be empty, or None where nobody knows.
        meeting: The pairs that meet, as the relations say; None where no relations were asked.
    """

    upright: Upright
    surfaces: Mapping[str, FloatArray]
    contacts: tuple[Contact, ...]
    weights: Mapping[str, Weight]
    unexplained: Mapping[str, float]
    sight: FreeSpace | None = None
    meeting: frozenset[frozenset[str]] | None = None

    @staticmethod
    def of(
        scene: Scene, among: Collection[str] | None = None, relations: RelationTable | None = None
    ) -> "Statics":
        """Complete the bodies of a scene and find their contacts.

        Args:
            scene: A scene that knows where up is.
            among: The movable objects to look at; all of them where not given. What meets none of them
                changes nothing for them, except for what was seen past it, which is kept.
            relations: Which pairs meet: there are contacts between these and no others. Without them every
                pair whose surfaces are near counts, as it does while relations are still being found.

        Returns:
            The scene at rest.

        Raises:
            InvalidInput: The scene has no `up`.
        """
        bodies = surfaces_of(scene)
        upright = bodies.upright if among is None else bodies.upright.among(among)
        sight, surfaces = bodies.sight, bodies.among(upright.clouds)
        meeting = None if relations is None else relations.meeting
        contacts = find_contacts(upright, surfaces, among=meeting)
        if relations is not None:
            contacts += tuple(_closed_gaps(relations, upright, surfaces, contacts))
        weights = {
            name: weigh(surfaces[name], scene.masses.get(name), upright.centres.get(name))
            for name in upright.movable
        }
        usable = within_reach(contacts, weights)
        unexplained = deficits(weights, usable)
        wanting = [name for name, missing in unexplained.items() if missing > UNSTEADY]
        if wanting:
            contacts += hidden_contacts(upright, surfaces, usable, weights, wanting, sight, meeting)
            unexplained = deficits(weights, within_reach(contacts, weights))
        return Statics(
            upright, surfaces, contacts, FrozenDict(weights), FrozenDict(unexplained), sight, meeting
        )

    @cached_property
    def touch_normals(self) -> Mapping[tuple[str, str], float]:
        """(a, b) -> upward part of the mean contact normal from a into b, for pairs that touch."""
        normals: dict[tuple[str, str], float] = {}
        for contact in self.contacts:
            if contact.gaps.min() <= TOLERANCES.catch:
                up = float(contact.normals[:, 2].mean())
                normals[contact.a, contact.b] = up
                normals[contact.b, contact.a] = -up
        return normals

    @cached_property
    def _catchers(self) -> tuple[Contact, ...]:
        """All contacts a falling body may meet."""
        near = [self._apart(c) for c in find_contacts(self.upright, self.surfaces, REACH)]
        return catchers((*(c for c in near if c is not None), *(c for c in self.contacts if c.inferred)))

    def _apart(self, contact: Contact) -> Contact | None:
        """Keep the points of a patch that may catch a body; of bodies apart, those across a gap."""
        if self.meeting is None or frozenset((contact.a, contact.b)) in self.meeting:
            return contact
        return contact.only(contact.gaps > TOLERANCES.catch)

    @cached_property
    def _islands_by_name(self) -> Mapping[str, frozenset[str]]:
        """Movable name -> all that hangs together with it: where it is taken nothing else has to be asked."""
        return {name: island for island in islands(self.weights, self._catchers) for name in island}

    @cached_property
    def _falls_at_rest(self) -> Mapping[str, Fall]:
        """How far bodies seem to sink while everything is in place: what contacts leave open."""
        return falls(self.weights, self._catchers, search=self._search)

    @cached_property
    def _search(self) -> Search:
        """Memory that one search for forces leaves to the next."""
        return Search()

    def fallen_without(self, away: Collection[str], held: Collection[str] = ()) -> dict[str, float]:
        """Find the objects that fall once others are gone, for clouds that show whole surfaces.

        Args:
            away: Names taken out of the scene.
            held: Names that a hand keeps still: they carry others, and do not fall.

        Returns:
            name -> how far, 1 where it just counts as a move, for those that move.
        """
        before = self._falls_at_rest  # first, since the forces of what is in place shorten the search
        joined = set[str]().union(*(self._islands_by_name.get(name, self._islands_by_name) for name in away))
        near = [c for c in self._catchers if c.a in joined or c.b in joined]
        met = {name for c in near if c.a in away or c.b in away for name in (c.a, c.b)}
        free = {name: w for name, w in self.weights.items() if name in joined and name not in held}
        found = falls(free, near, beside=met, without=away, search=self._search)
        far = {name: fall.beyond(before[name]) for name, fall in found.items()}
        return {name: share for name, share in far.items() if share > 1.0}

    def unheld_without(self, away: Collection[str], held: Collection[str] = ()) -> dict[str, float]:
        """Measure how much less forces hold each object once others are gone.

        Args:
            away: Names taken out of the scene.
            held: Names that a hand keeps still: they carry others, and stay.

        Returns:
            name -> by how much the share of its weight grows that nothing carries, for all that hang together
            with what is gone.
        """
        met = {name for c in self.contacts if c.a in away or c.b in away for name in (c.a, c.b)}
        contacts = [c for c in self.contacts if c.a not in away and c.b not in away]
        joined = islands(self.weights.keys() - {*away, *held}, contacts, met)
        moving = set[str]().union(*joined)
        left = {name: weight for name, weight in self.weights.items() if name in moving}
        usable = within_reach([c for c in contacts if c.a in moving or c.b in moving], left)
        found = deficits(left, usable)
        return {name: missing - self.unexplained.get(name, 0.0) for name, missing in found.items()}

    def unsteady_without(self, away: Collection[str], held: Collection[str] = ()) -> dict[str, float]:
        """Find the objects that do not stay where they are once others are gone.

        Args:
            away: Names taken out of the scene.
            held: Names that a hand keeps still: they carry others, and stay.

        Returns:
            name -> by how much the share of its weight grows that nothing carries, for those of which that is
            more than `UNSTEADY` (`GUESSED` where hidden sides were completed).
        """
        limit = UNSTEADY if self.sight is None else GUESSED
        found = self.unheld_without(away, held)
        return {name: missing for name, missing in found.items() if missing > limit}


def _closed_gaps(
    relations: RelationTable, upright: Upright, surfaces: Mapping[str, FloatArray], found: Collection[Contact]
) -> list[Contact]:
    """The contacts of pairs that are said to touch though their surfaces are not seen to come near."""
    known = {frozenset((contact.a, contact.b)) for contact in found}
    touching = [pair for pair in relations.near.values() if pair.relation is Relation.TOUCH]
    return [
        contact
        for pair in touching
        if {pair.a, pair.b} <= surfaces.keys() and frozenset((pair.a, pair.b)) not in known
        for contact in close_gap(upright, surfaces, pair.a, pair.b)
    ]


@remember(KEPT_BODIES)
def weigh(points: FloatArray, mass: float | None = None, centre: FloatArray | None = None) -> Weight:
    """Guess weight and centre of mass of a body from its surface, as far as they are not known.

    Args:
        points: (N, 3) evenly spread surface points [m].
        mass: In [kg] where it is known.
        centre: (3,) centre of mass [m] where it is known; else the density is taken as even.

    Returns:
        The weight. A mass not given is `DENSITY` times a volume: the hull's for solid things, the surface
        times a wall for hollow ones, whichever is less.
    """
    centre = middle_of(points) if centre is None else centre
    if mass is not None:
        return Weight(1e3 * mass / DENSITY, centre, LEVER)
    volume = volume_around(points[:: -(-len(points) // ENOUGH)])
    shell = len(voxel_means(points, SHELL_CELL)) * SHELL_CELL**2 * WALL
    return Weight(1e3 * max(min(volume, shell), 1e-7), centre, LEVER)


def volume_around(points: FloatArray) -> float:
    """Volume [m³] of the convex hull of points (N, 3); of flat ones that of their box, a voxel thick."""
    lower, upper = bounds(points)
    return hull_volume(points) or float(np.prod(np.maximum(upper - lower, VOXEL)))


def within_reach(contacts: Collection[Contact], movable: Collection[str]) -> list[Contact]:
    """Contacts that carry now, or would after a movement too small to count.

    A point further than `TOLERANCES.tight` counts where the object would reach it by turning about its
    nearest carrying point by less than 9 degrees.

    Args:
        contacts: Patches with gaps.
        movable: Names that can move.

    Returns:
        The usable parts of the patches.
    """
    touching: dict[str, list[FloatArray]] = {name: [] for name in movable}
    for contact in contacts:
        near = contact.points[(contact.gaps <= TOLERANCES.tight) & (contact.turns <= ROLL)]
        for name in (contact.a, contact.b):
            if name in touching and len(near):
                touching[name].append(near)
    pivots = {name: PointTree(np.concatenate(near)) if near else None for name, near in touching.items()}
    usable: list[Contact] = []
    for contact in contacts:
        level = contact.turns <= ROLL
        keep = (contact.gaps <= TOLERANCES.tight) & level
        for name in (contact.a, contact.b):
            pivot = pivots.get(name)
            if name not in pivots:
                continue
            if pivot is None:
                keep |= (contact.gaps <= TOLERANCES.catch) & level
                continue
            arms = pivot.query(contact.points)[0]
            keep |= (
                (contact.gaps <= TOLERANCES.tight + TILT * arms) & (contact.gaps <= TOLERANCES.search) & level
            )
        part = contact.only(keep & _outline(contact, keep))
        if part is not None:
            usable.append(part)
    return usable


def _outline(contact: Contact, keep: BoolArray) -> BoolArray:
    """The points that matter of a flat patch: forces inside its outline are sums of forces on it."""
    count = int(keep.sum())
    if count <= 2 * len(AROUND) or np.ptp(contact.normals[keep], axis=0).max() > 1e-6:
        return np.ones(len(keep), dtype=np.bool_)
    reach = np.where(keep[:, None], contact.points[:, :2] @ AROUND.T, -np.inf)
    chosen = np.zeros(len(keep), dtype=np.bool_)
    chosen[np.argmax(reach, axis=0)] = True
    return chosen
