"""What the hand does to objects: grasps, what is held, what is kept level, what may touch, where it ends."""

from collections.abc import Iterator, Sequence

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.placement.away import BODIES, IN_HAND, Away
from topple.planner.placement.tolerances import BIN_WALL, LIFT_CLEAR
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.grip import distance
from topple.planner.verify.replay import Finding, Piece, Replay, off_by
from topple.planner.verify.tolerances import NEAR
from topple.robots.collision.fcl_bodies import fcl_body
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import move_parts
from topple.topology.geometry.rigid import move_points

ARRIVING = (SegmentKind.APPROACH, SegmentKind.GRASP, SegmentKind.LIFT)
"""Where the fingers may touch neighbours of what they take."""


# -- what is in it


def said_to_be_held(replay: Replay) -> Iterator[Finding]:
    """Pieces that say something else of what is in the hand than what is, and hands that stay closed."""
    yield from replay.closed
    for piece in replay.pieces:
        holding = piece.segment.holding
        if (holding is not None) != bool(piece.held) or (holding is not None and holding not in piece.held):
            truth = ", ".join(piece.held) or "nothing"
            yield piece.finds(1.0, f"{holding or 'nothing'} is said, {truth} is in it")


def _ends(replay: Replay, piece: Piece) -> FloatArray:
    """(4, 4) pose in the world of the pads or the lip as a piece ends."""
    return replay.tools(piece, piece.states[-1:])[0] @ replay.pads(piece)


def off_grasp(replay: Replay) -> Iterator[Finding]:
    """How far tools end from the grasps that their steps have [m]."""
    for piece in replay.of_kind(SegmentKind.APPROACH):
        yield piece.finds(off_by(_ends(replay, piece), np.array(piece.step.grasp.pose_tool_to_world)))


def off_object(replay: Replay) -> Iterator[Finding]:
    """How far objects are from the room between the pads, or from the lip [m]."""
    for piece in replay.of_kind(SegmentKind.APPROACH):
        to_tool = inverse(_ends(replay, piece)) @ piece.poses.get(piece.step.object, np.eye(4))
        gripper = replay.arm.tools[piece.segment.tool].gripper
        half = gripper.closing_region(piece.segment.hand.opening) / 2.0
        yield piece.finds(distance(half, move_parts(replay.parts[piece.step.object], to_tool)))


def off_attachment(replay: Replay) -> Iterator[Finding]:
    """How far what is held is from where its step says that it is held [m]."""
    for piece in replay.of_kind(SegmentKind.GRASP):
        said = {
            held.object: replay.pads(piece) @ np.array(held.pose_start_to_tool)
            for held in piece.step.attachments
            if held.tool == piece.segment.tool
        }
        for name, to_tool in piece.held.items():
            yield piece.finds(off_by(to_tool, said[name]) if name in said else 1.0, name)


def off_place(replay: Replay) -> Iterator[Finding]:
    """How far tools are from where their steps put objects down [m]."""
    for piece in replay.of_kind(SegmentKind.PLACE):
        grasp = np.array(piece.step.grasp.pose_tool_to_world)
        wanted = np.array(piece.step.placement.pose_before_to_after) @ grasp
        yield piece.finds(off_by(_ends(replay, piece), wanted))


def tilts(replay: Replay) -> Iterator[Finding]:
    """How far what is kept level is tilted on its way [rad]."""
    for piece in replay.pieces:
        name = piece.step.object
        if piece.step.upright and name in piece.held:
            turns = replay.tools(piece, piece.states)[:, :3, :3] @ piece.held[name][:3, :3]
            up = turns @ piece.before[name][:3, :3].T @ replay.up @ replay.up
            yield piece.finds(float(np.arccos(np.clip(up, -1.0, 1.0)).max()))


def touching_without_reason(replay: Replay) -> Iterator[Finding]:
    """Pairs that may touch and are not the hand with what it takes, or that with what it stands on."""
    links, hand = set(replay.arm.links), {link for tool in replay.arm.tools.values() for link in tool.links}
    for piece in replay.pieces:
        name, kind = piece.step.object, piece.segment.kind
        carried = {held.object for held in piece.step.attachments}
        for pair in piece.may_touch:
            own, others = pair & links, pair - links
            fine = bool(own) and own <= hand and len(others) == 1 and kind != SegmentKind.MOVE
            if fine and not others <= carried:
                fine = kind in ARRIVING and not others & replay.fixed
            if not own and name in pair:
                (other,) = pair - {name}
                fine = _next_to(replay, piece, other)
            if not fine:
                yield piece.finds(1.0, " and ".join(sorted(pair)))


def _next_to(replay: Replay, piece: Piece, other: str) -> bool:
    """Whether the object in the hand is next to another one where it is taken, or is put onto it."""
    if piece.segment.kind == SegmentKind.PLACE and piece.step.placement.into == other:
        return True
    name = piece.step.object
    if piece.segment.kind not in ARRIVING[1:] or other not in piece.poses or name not in piece.before:
        return False
    lay = move_parts(replay.parts[name], piece.before[name])
    return _gap(lay, move_parts(replay.parts[other], piece.poses[other])) < NEAR


def _gap(some: Sequence[FloatArray], others: Sequence[FloatArray]) -> float:
    """Distance [m] between convex parts (V, 3) of two bodies."""
    import fcl

    bodies = [fcl_body(part) for part in others]
    asked = fcl.DistanceRequest
    return min(float(fcl.distance(fcl_body(part), body, asked())) for part in some for body in bodies)


# -- where things go that are taken


def own_bodies(plan: PlanData) -> frozenset[str]:
    """Names of what stands in a plan beside the scene: the bin or the area for what is taken."""
    how = "" if plan.away is None else plan.away.how
    return frozenset({BODIES[Away(how)]} if how in BODIES else ())


def elsewhere(replay: Replay) -> Iterator[Finding]:
    """Steps that end where the plan does not say that things go."""
    away = "" if replay.plan.away is None else replay.plan.away.how
    for index, step in enumerate(replay.plan.steps):
        how = step.placement.how
        if how not in ("on", "within", "" if step.action == "place" else away):
            yield Finding(1.0, f"step {index + 1} ({step.object}): {how or 'table'}", index)


def _last_pieces(replay: Replay, how: Away) -> Iterator[Piece]:
    """The last pieces of steps that end in one way, the object where it is to be then."""
    for piece in replay.last():
        where = piece.held if how in IN_HAND else piece.poses
        if replay.plan.away is not None and piece.step.placement.how == how and piece.step.object in where:
            yield piece


def _destination(replay: Replay) -> FloatArray:
    """(4, 4) pose in the world of where things go that are taken."""
    assert replay.plan.away is not None
    return np.array(replay.plan.away.pose_to_world)


def short_of_clear(replay: Replay) -> Iterator[Finding]:
    """How much of the distance that a lift ends at from everything is lacking [m]."""
    for piece in _last_pieces(replay, Away.LIFT):
        own = replay.body(piece, piece.step.object)
        gaps = (_gap(own, move_parts(replay.parts[other], pose)) for other, pose in piece.poses.items())
        yield piece.finds(LIFT_CLEAR - min(gaps, default=np.inf))


def beside_point(replay: Replay) -> Iterator[Finding]:
    """How far from their point things are held out [m]."""
    for piece in _last_pieces(replay, Away.HAND_OVER):
        point, corners = _destination(replay)[:3, 3], np.vstack(replay.body(piece, piece.step.object))
        aside = np.maximum(corners.min(axis=0) - point, point - corners.max(axis=0))
        yield piece.finds(float(aside.max()))


def off_area(replay: Replay) -> Iterator[Finding]:
    """How far things stand out from the area that is vouched for [m]."""
    for piece in _last_pieces(replay, Away.ZONE):
        assert replay.plan.away is not None
        own = move_points(np.vstack(replay.body(piece, piece.step.object)), inverse(_destination(replay)))
        half = np.array(replay.plan.away.size[:2]) / 2.0
        yield piece.finds(float((np.abs(own[:, :2]).max(axis=0) - half).max()))


def falls(replay: Replay) -> Iterator[Finding]:
    """How far things fall otherwise than said, out of a hand that keeps them or into a bin [m]."""
    if replay.plan.away is None:
        return
    for piece in replay.last():
        if piece.step.placement.how in IN_HAND:
            yield piece.finds(abs(piece.step.placement.drop) + float(piece.step.placement.falls))
    for piece in replay.of_kind(SegmentKind.RELEASE):
        name, place = piece.step.object, piece.step.placement
        if place.how == Away.BIN and name in piece.poses:
            floor = float(_destination(replay)[:3, 3] @ replay.up) + BIN_WALL
            lowest = float((np.vstack(replay.body(piece, name)) @ replay.up).min())
            yield piece.finds(abs(lowest - floor) + float(place.falls))
