"""Where objects touch: contact patches with normals, between clouds and with flat fixed surfaces."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.topology.base.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    bounds,
    middle_of,
    sum_of_rows,
    within_corners,
)
from topple.topology.base.remembered import remember
from topple.topology.base.tolerances import VOXEL
from topple.topology.bodies.tolerances import KEPT_BODIES
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.broadphase import near_pairs
from topple.topology.geometry.thin import cell_keys, voxel_means
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.friction import friction_between
from topple.topology.scene.tolerances import FRICTION
from topple.topology.statics.grounds import Plane, planes_and_rest
from topple.topology.statics.tolerances import BELOW, KEPT_PAIRS, SOLE


@dataclass(frozen=True)
class ContactTolerances:
    """Lengths [m] of the search for contacts.

    Attributes:
        search: Two samples further apart belong to no contact: a spacing within each surface
            (4 mm after thinning) on top of the largest gap.
        tight: Two surfaces this close carry each other: noise and spacing of a thinned cloud.
        catch: Surfaces this close count as one contact in a what-if question: an object that
            loses a support comes to rest on such a surface after moving less than the
            centimetre which counts as a move.
        patch: A surface is flat over this radius when its normal is taken; the radius of a spoon.
        footprint: Edge of the cells in which a patch keeps one point.
        smooth: A patch that spreads further across its plane (standard deviation) has an edge in it.
    """

    search: float = 0.009
    tight: float = 0.0025
    catch: float = 0.005
    patch: float = 0.012
    footprint: float = 0.012
    smooth: float = 0.0015


TOLERANCES = ContactTolerances()


@dataclass(frozen=True, eq=False)
class Contact:
    """One patch in which two objects touch, or nearly do.

    Attributes:
        a: First object.
        b: Second object.
        points: (k, 3) points of the patch [m].
        normals: (k, 3) unit normals, out of `a` into `b`.
        gaps: (k,) distance of the surfaces along the normal [m], negative where they overlap.
        turns: (k,) angle between the two surfaces there [rad], 0 at an edge or a corner: how far one
            body must roll on the other until this is where they touch.
        inferred: True where no camera saw the contact and gravity says there must be one.
        friction: Coefficient of dry friction.
        exact: Whether the normals are those of faces, not of points.
    """

    a: str
    b: str
    points: FloatArray
    normals: FloatArray
    gaps: FloatArray
    turns: FloatArray
    inferred: bool = False
    friction: float = FRICTION
    exact: bool = False

    def only(self, keep: BoolArray) -> "Contact | None":
        """The part of the patch chosen by a (k,) mask, itself where that is all; None where it is nothing."""
        if not keep.any():
            return None
        if keep.all():
            return self
        return replace(
            self,
            points=self.points[keep],
            normals=self.normals[keep],
            gaps=self.gaps[keep],
            turns=self.turns[keep],
        )


def find_contacts(
    upright: Upright,
    clouds: Mapping[str, FloatArray] | None = None,
    reach: float = TOLERANCES.search,
    among: Collection[frozenset[str]] | None = None,
) -> tuple[Contact, ...]:
    """All patches in which two surfaces are at most `reach` apart.

    Args:
        upright: The upright scene.
        clouds: name -> (N, 3) upright surfaces to use instead of the seen ones (completed bodies).
        reach: Largest gap [m].
        among: The pairs that are asked about; all of them where not given.

    Returns:
        Contacts with at least one movable side, from the lower object to the higher and the lower objects'
        first, so that they are the same in whatever order the objects are named.
    """
    given = upright.clouds if clouds is None else clouds
    surfaces = {name: given[name] for name in _by_height(upright, given)}
    grounds = {name: planes_and_rest(upright, name) for name in surfaces if name in upright.fixed}
    planes = {name: planes for name, (planes, _) in grounds.items()}
    sides = {**surfaces, **{name: rest for name, (_, rest) in grounds.items()}}
    found: list[Contact] = []
    pairs = _near_pairs(surfaces, planes) if among is None else _pairs(surfaces, among)
    for a, b in pairs:
        if a in upright.fixed and b in upright.fixed:
            continue
        ground, other = (a, b) if a in upright.fixed else (b, a)
        touching = [
            _on_plane(ground, plane, other, surfaces[other], reach) for plane in planes.get(ground, ())
        ]
        if len(sides[ground]):
            touching.append(_contact(a, b, sides[a], sides[b], reach))
        found += _join_patches([contact for contact in touching if contact is not None])
    return tuple(with_friction(contact, upright.friction) for contact in found)


def _by_height(upright: Upright, surfaces: Mapping[str, FloatArray]) -> list[str]:
    """Names of surfaces, what is fixed first, the others by their middle heights."""
    return sorted(surfaces, key=lambda name: (name not in upright.fixed, float(surfaces[name][:, 2].mean())))


def close_gap(upright: Upright, surfaces: Mapping[str, FloatArray], a: str, b: str) -> tuple[Contact, ...]:
    """The contact that two bodies would have if the gap between them were none: where they come nearest.

    Args:
        upright: The upright scene.
        surfaces: name -> (N, 3) upright surfaces [m].
        a: One of them.
        b: The other.

    Returns:
        The patch, marked as inferred; nothing where neither can move.
    """
    rests, moves = (b, a) if b in upright.fixed else (a, b)
    distance, nearest = PointTree(surfaces[rests]).query(surfaces[moves])
    closest = int(np.argmin(distance))
    shift = surfaces[rests][np.asarray(nearest)[closest]] - surfaces[moves][closest]
    together = {a: surfaces[a], b: surfaces[b], moves: surfaces[moves] + shift}
    found = find_contacts(upright, together, among=[frozenset((a, b))])
    return tuple(
        replace(contact, gaps=np.maximum(contact.gaps - contact.gaps.min(), 0.0), inferred=True)
        for contact in found
    )


def with_friction(contact: Contact, friction: Mapping[str, float]) -> Contact:
    """The contact with the friction of its two surfaces, as far as that is known.

    Args:
        contact: The contact.
        friction: Coefficient of the surface of each object that has been tried.
    """
    return replace(contact, friction=friction_between(friction, contact.a, contact.b))


def _join_patches(patches: Sequence[Contact]) -> list[Contact]:
    """The patches of one pair as one contact, where there are any."""
    if len(patches) < 2:
        return list(patches)
    first = patches[0]
    turned = [-patch.normals if patch.a != first.a else patch.normals for patch in patches]
    points, gaps, turns = (
        np.concatenate([getattr(patch, name) for patch in patches]) for name in ("points", "gaps", "turns")
    )
    return [Contact(first.a, first.b, points, np.concatenate(turned), gaps, turns)]


def _pairs(surfaces: Mapping[str, FloatArray], among: Collection[frozenset[str]]) -> list[tuple[str, str]]:
    """Pairs of surfaces that are asked about, in their order."""
    place = {name: i for i, name in enumerate(surfaces)}
    asked = [sorted(pair, key=place.__getitem__) for pair in among if pair <= place.keys()]
    return sorted(((a, b) for a, b in asked), key=lambda pair: (place[pair[0]], place[pair[1]]))


def _near_pairs(
    surfaces: Mapping[str, FloatArray], planes: Mapping[str, Sequence[Plane]]
) -> list[tuple[str, str]]:
    """Pairs whose boxes are near each other, and every pair with a plane: it goes on behind the objects."""
    names = list(surfaces)
    lower, upper = np.array([bounds(points) for points in surfaces.values()]).reshape(-1, 2, 3).swapaxes(0, 1)
    pairs = {(i, j) for i, j in near_pairs(lower, upper, TOLERANCES.search).tolist()}
    for number in (i for i, name in enumerate(names) if planes.get(name)):
        pairs |= {(min(i, number), max(i, number)) for i in range(len(names)) if i != number}
    return [(names[i], names[j]) for i, j in sorted(pairs)]


@remember(KEPT_PAIRS)
def _on_plane(ground: str, plane: Plane, name: str, points: FloatArray, reach: float) -> Contact | None:
    """Contact of an object with a table top."""
    over, heights = plane.over(points), plane.heights(points)
    if plane.ends:
        if float(heights.mean()) < -BELOW:
            return None
        over &= heights > -SOLE  # what is beside a board and reaches below it does not stand on it
    near = over & (heights < reach)
    if not near.any():
        return None
    # The lowest point of each cell: surfaces above it in the same cell are walls, not the foot.
    low = points[near][np.argsort(heights[near], kind="stable")]
    feet = low[_first_of_cells(low, TOLERANCES.footprint)]
    # Only undersides say how the body stands: the inner side of a thin wall would blur the normal.
    sole = _lowest(points[over & (heights < SOLE)], 2 * VOXEL)
    around = PointTree(sole).query_ball_point(feet, 1.5 * TOLERANCES.patch)
    normals, rough = local_normals(sole, around)
    leaning = np.arccos(np.minimum(1.0, np.abs(normals @ plane.normal)))
    turns = np.where(rough < TOLERANCES.smooth, leaning, 0.0)
    return Contact(ground, name, feet, np.tile(plane.normal, (len(feet), 1)), plane.heights(feet), turns)


def _lowest(points: FloatArray, cell: float) -> FloatArray:
    """The lowest point of every plan cell."""
    rising = points[np.argsort(points[:, 2], kind="stable")]
    return rising[_first_of_cells(rising, cell)]


def _first_of_cells(points: FloatArray, cell: float) -> IntArray:
    """Positions of the first point in every plan cell, ascending."""
    flat = points[:, :2]
    return np.sort(np.unique(cell_keys(flat, *bounds(flat), cell), return_index=True)[1])


def _contact(a: str, b: str, first: FloatArray, second: FloatArray, reach: float) -> Contact | None:
    """Contact of two clouds."""
    corners = np.array([bounds(first), bounds(second)])
    lower, upper = corners[:, 0].max(axis=0) - reach, corners[:, 1].min(axis=0) + reach
    if (lower > upper).any():
        return None
    candidates = second[within_corners(second, lower, upper)]
    return _meeting_at(a, b, first, second, candidates, reach) if len(candidates) else None


_tree_of = remember(KEPT_BODIES)(PointTree)


@remember(KEPT_PAIRS)
def _meeting_at(
    a: str, b: str, first: FloatArray, second: FloatArray, candidates: FloatArray, reach: float
) -> Contact | None:
    """Contact of two clouds of which some points (C, 3) of the second may be near the first."""
    distances, nearest = _tree_of(first).query(candidates, distance_upper_bound=reach)
    close = np.isfinite(distances)
    if not close.any():
        return None
    middles = (candidates[close] + first[nearest[close]]) / 2
    spots = voxel_means(middles, TOLERANCES.footprint)
    return _patch(a, b, spots, first, second, reach)


def _patch(
    a: str, b: str, spots: FloatArray, first: FloatArray, second: FloatArray, reach: float
) -> Contact | None:
    """Normals and gaps at the spots: taken from the flatter of the two surfaces there."""
    around_a = _tree_of(first).query_ball_point(spots, TOLERANCES.patch)
    around_b = _tree_of(second).query_ball_point(spots, TOLERANCES.patch)
    normals_a, spreads_a = local_normals(first, around_a)
    normals_b, spreads_b = local_normals(second, around_b)
    known = np.flatnonzero(np.isfinite(spreads_a) & np.isfinite(spreads_b))
    if len(known) == 0:
        return None
    normals_a, normals_b = normals_a[known], normals_b[known]
    a_is_flatter = spreads_a[known] <= spreads_b[known]
    normals = np.where(a_is_flatter[:, None], normals_a, normals_b)
    near_a = _Groups.of(first, [around_a[k] for k in known])
    near_b = _Groups.of(second, [around_b[k] for k in known])
    # b lies on the side of the contact where its points are; two faces that lie flat on each
    # other have none there, and the rest of the bodies tells.
    offsets = near_b.mean(normals) - near_a.mean(normals)
    apart = normals @ (middle_of(second) - middle_of(first))
    offsets = np.where(np.abs(offsets) < TOLERANCES.smooth, apart, offsets)
    normals = np.where(offsets[:, None] < 0, -normals, normals)
    gaps = np.where(
        a_is_flatter,
        near_b.lowest(normals) - near_a.mean(normals),
        near_b.mean(normals) + near_a.lowest(-normals),
    )
    smooth = np.maximum(spreads_a[known], spreads_b[known]) < TOLERANCES.smooth
    between = np.arccos(np.minimum(1.0, np.abs(sum_of_rows(normals_a * normals_b))))
    patch = Contact(a, b, spots[known], normals, gaps, np.where(smooth, between, 0.0))
    return patch.only(gaps <= reach)


@dataclass(frozen=True, eq=False)
class _Groups:
    """Points in groups of at least three, one group after the other.

    Attributes:
        points: (N, 3) points [m].
        counts: (k,) sizes of the groups.
    """

    points: FloatArray
    counts: IntArray

    @staticmethod
    def of(points: FloatArray, groups: Sequence[IntArray]) -> "_Groups":
        """The points of groups of positions."""
        members = np.concatenate(groups)
        return _Groups(points[members], np.array([len(group) for group in groups]))

    @property
    def _starts(self) -> IntArray:
        return np.cumsum(self.counts) - self.counts

    def _along(self, directions: FloatArray) -> FloatArray:
        """(N,) how far each point lies along the (k, 3) direction of its group [m]."""
        return sum_of_rows(self.points * np.repeat(directions, self.counts, axis=0))

    def mean(self, directions: FloatArray) -> FloatArray:
        """(k,) how far the points of each group lie along its (k, 3) direction [m]."""
        return np.add.reduceat(self._along(directions), self._starts) / self.counts

    def lowest(self, directions: FloatArray) -> FloatArray:
        """(k,) where each group begins along its (k, 3) direction, one stray point aside [m]."""
        along = self._along(directions)
        ranked = np.lexsort((along, np.repeat(np.arange(len(self.counts)), self.counts)))
        return along[ranked[self._starts + 1]]


def local_normals(points: FloatArray, groups: Sequence[IntArray]) -> tuple[FloatArray, FloatArray]:
    """Planes through groups of points.

    Args:
        points: (N, 3) points [m].
        groups: k arrays of indices into the points.

    Returns:
        (k, 3) unit normals and (k,) spreads [m] across the planes; straight up and infinite for groups
        of fewer than three points.
    """
    sizes = np.array([len(group) for group in groups])
    normals = np.tile([0.0, 0.0, 1.0], (len(groups), 1))
    spreads = np.full(len(groups), np.inf)
    whole = np.flatnonzero(sizes >= 3)
    if len(whole) == 0:
        return normals, spreads
    members = points[np.concatenate([g for g in groups if len(g) >= 3])]
    counts = sizes[whole]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    means = np.add.reduceat(members, starts) / counts[:, None]
    centred = members - np.repeat(means, counts, axis=0)
    outer = np.add.reduceat(centred[:, :, None] * centred[:, None, :], starts)
    values, vectors = np.linalg.eigh(outer / (counts - 1)[:, None, None])
    normals[whole] = vectors[:, :, 0]
    spreads[whole] = np.sqrt(np.maximum(values[:, 0], 0.0))
    return normals, spreads
