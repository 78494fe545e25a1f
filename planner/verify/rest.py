"""Whether things stay where a plan puts them: each is let go in simulation, the others held in place.

What is put on a table is asked with the hidden sides, which it may have to stand on; what is put on or into
another thing was lowered by what was seen of both. What is put into a container may roll but has to stay in
it. A step that says that it lets its object fall is not counted, and told of.
"""

from collections.abc import Iterator

import numpy as np

from topple.planner.placement.proof import Settled, container_of, settle
from topple.planner.simulate.sandbox import Sandbox
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.clouds import beyond_all
from topple.planner.verify.replay import Finding, Piece, Replay
from topple.topology.bodies.solids import move_parts
from topple.topology.geometry.sides import joggled_sides


def let_go(replay: Replay) -> tuple[tuple[Piece, Settled], ...]:
    """Let go what every step puts down; what is in the hand still is left out, which is told elsewhere."""
    found, sandbox, up = list[tuple[Piece, Settled]](), Sandbox(), replay.up
    for piece in replay.of_kind(SegmentKind.RELEASE):
        place, name = piece.step.placement, piece.step.object
        if name not in piece.poses or (place.into is not None and place.into not in piece.poses):
            continue
        inside, riding = (
            container_of(place.how, place.into),
            {held.object for held in piece.step.attachments} - {name},
        )
        bodies = {other: replay.body(piece, other) for other in piece.poses if other not in riding}
        if place.into is None and inside is None:
            bodies[name] = move_parts(replay.wholes[name], piece.poses[name])
        release = np.eye(4)
        release[:3, 3] += place.drop * up
        around, sandbox = None if inside is None else bodies[inside], sandbox.fill(name, bodies, up)
        found.append((piece, settle(sandbox, release, np.eye(4), around, up)))
    return tuple(found)


def _kept(replay: Replay, inside: bool) -> Iterator[tuple[Piece, Settled]]:
    """Select releases that are not said to fall, into a container or not."""
    for piece, found in replay.once(let_go):
        if not piece.step.placement.falls and (found.outside is not None) == inside:
            yield piece, found


def shifts(replay: Replay) -> Iterator[Finding]:
    """How far things get that are let go [m]."""
    return (piece.finds(found.shift) for piece, found in _kept(replay, inside=False))


def turns(replay: Replay) -> Iterator[Finding]:
    """How far things turn that are let go [rad]."""
    return (piece.finds(found.turn) for piece, found in _kept(replay, inside=False))


def out_of_container(replay: Replay) -> Iterator[Finding]:
    """How far things are outside of the containers that they are put into [m]."""
    return (piece.finds(found.outside or 0.0) for piece, found in _kept(replay, inside=True))


def false_falls(replay: Replay) -> Iterator[Finding]:
    """Things that are said to fall and stay."""
    for piece, found in replay.once(let_go):
        if piece.step.placement.falls and found.within():
            yield piece.finds(1.0)


def falls(replay: Replay) -> Iterator[str]:
    """Say what falls as its step says."""
    for piece, found in replay.once(let_go):
        if piece.step.placement.falls:
            yield f"step {piece.index + 1} ({piece.step.object}) is let go to fall: {found}"


def outside_of_wholes(replay: Replay) -> Iterator[Finding]:
    """How far what was seen of objects sticks out of the bodies that are taken for whole [m]."""
    for thing in replay.plan.objects:
        if thing.whole:
            hulls = [joggled_sides(np.array(part)) for part in thing.whole]
            yield Finding(float(beyond_all(hulls, np.vstack(thing.parts)).max()), thing.name)
