"""Where a thing comes to rest once it is let go: asked of a simulated world before it is put there."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from topple.planner.placement.placement import Placement
from topple.planner.placement.tolerances import CLEAR, OTHER_FACE, QUIET
from topple.planner.simulate.sandbox import Sandbox
from topple.planner.tolerances import DISTURBED
from topple.robots.collision.fcl_bodies import apart
from topple.robots.engines import INSTALLED
from topple.robots.poses import angle_between
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids, move_parts
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation


def pick_staying(
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
        (cloud,) = move_parts((scene.clouds[name],), pose)
        pair = rule.relate(rule.prepare(name, cloud), container)
        return pair.relation in (Relation.WITHIN, Relation.PARTIAL_WITHIN)

    found = [place for place in places if inside(place.pose_at_rest(up))]
    if not INSTALLED:  # by geometry alone
        return found, found
    gentle: list[tuple[tuple[float, ...], Placement]] = []
    kept: list[tuple[tuple[float, ...], Placement]] = []
    sandbox = Sandbox().fill(name, bodies, up, contents, scene) if found else Sandbox()
    for place in found:
        rest = sandbox.release(place.pose_before_to_after)
        if inside(rest):
            way, push = sandbox.way(rest, place.pose_at_rest(up)), sandbox.push()
            there = move_parts(bodies[name], rest)
            beside = not all(apart(there, bodies[other], CLEAR) for other in contents)
            kept.append(((beside, round(2.0 * push), place.drop, round(way / DISTURBED)), place))
            gentle += kept[-1:] if push < QUIET else []
    return _quietest(gentle), _quietest(kept)


def _quietest(found: Sequence[tuple[tuple[float, ...], Placement]]) -> list[Placement]:
    """Placements clear of what lies there first, then what pushes least, falls and rolls least."""
    return [place for _, place in sorted(found, key=lambda each: each[0])]


def try_standing(
    places: Sequence[Placement],
    name: str,
    situation: Situation,
    beside: Solids | None = None,
    sandbox: Sandbox | None = None,
) -> list[Placement]:
    """Placements on a table, those marked that an object does not keep when it is let go there.

    Each attitude is tried once in simulation; what tips over is put down as it came to lie. A hand may not
    get down with it so: what tips over from the attitude it has now comes last as it is, to fall by itself.

    Args:
        places: Placements on something fixed.
        name: The object.
        situation: Where it is now.
        beside: Bodies that it may stand on besides, by name.
        sandbox: The world to let it go in; one of its own where None.

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
    tried = (sandbox or Sandbox()).fill(name, others, up, scene=scene)
    for place in places:
        attitude = tuple(np.round(place.pose_before_to_after[:3, :3].T @ up, 3).tolist())
        if attitude not in known:
            known[attitude] = _tipped_turn(tried, place, up)
        turn = known[attitude]
        found.append(place if turn is None else replace(_laid(tried, place, *turn, up), rolls=True))
        if turn is not None and place.tilt(up) < OTHER_FACE:
            falls.append(replace(place, rolls=True, falls=True, rest="as it was, to fall as it will"))
    return [*found, *falls]


def _tipped_turn(sandbox: Sandbox, place: Placement, up: FloatArray) -> tuple[FloatArray, float] | None:
    """How an object turns (3, 3) in its own axes from how a placement has it, and how low it then is.

    None where it stays.
    """
    meant, rest = place.pose_at_rest(up), sandbox.release(place.pose_before_to_after)
    if sandbox.way(rest, meant) < DISTURBED and angle_between(rest, meant) < OTHER_FACE:
        return None
    return meant[:3, :3].T @ rest[:3, :3], sandbox.lowest(rest, up)


def _laid(sandbox: Sandbox, place: Placement, turn: FloatArray, low: float, up: FloatArray) -> Placement:
    """A placement turned in the object's own axes by (3, 3) and brought to a height.

    Its centre of mass stays over the same spot.
    """
    pose, centre = place.pose_before_to_after.copy(), sandbox.body.centre_of_mass
    middle = pose[:3, :3] @ centre + pose[:3, 3]
    pose[:3, :3] = pose[:3, :3] @ turn
    pose[:3, 3] = middle - pose[:3, :3] @ centre
    pose[:3, 3] += (low + place.drop - sandbox.lowest(pose, up)) * up
    return replace(place, pose_before_to_after=pose, rest="as it comes to lie by itself")
