"""What a plan says of its scene, of its grasps and of itself, held against these."""

from collections.abc import Iterator

import numpy as np

from topple.planner.decide.goal import Action
from topple.planner.fallbacks import Relaxation
from topple.planner.grasp.grasp import tool_of
from topple.planner.grasp.shape import shapes_of
from topple.planner.verify.hand import own_bodies
from topple.planner.verify.replay import Finding, Replay, off_by
from topple.topology.bodies.matter import MATTER
from topple.topology.bodies.solids import Solids
from topple.topology.geometry.sides import beyond, joggled_sides

# -- of itself


def scores(replay: Replay) -> Iterator[Finding]:
    """How far scores are from what their terms make."""
    for index, step in enumerate(replay.plan.steps):
        where, grasp = f"step {index + 1} ({step.object})", step.grasp
        if grasp.terms and (shape := shapes_of(replay.arm).get(tool_of(grasp.kind))):
            try:
                off = abs(shape.score(grasp.terms) - grasp.score)
                yield Finding(off, where, index)
            except KeyError as error:
                yield Finding(1.0, f"{where}: a {grasp.kind} has a term {error}", index)


def uprights(replay: Replay) -> Iterator[Finding]:
    """Steps that are upright and are not to be, or the other way round."""
    for index, step in enumerate(replay.plan.steps):
        if step.upright != (step.object in replay.plan.upright):
            yield Finding(1.0, f"step {index + 1} ({step.object})", index)


def marks(replay: Replay) -> Iterator[Finding]:
    """Steps said to make room or to come unseen, or not, against the rest of the plan."""
    steps = replay.plan.steps
    for index, step in enumerate(steps):
        again = any(later.object == step.object for later in steps[index + 1 :])
        making_room = bool(replay.plan.poses) and step.action == Action.REMOVE
        unseen = step.unseen == (Relaxation.UNSEEN in step.fallbacks)
        if step.buffer != making_room or (step.buffer and not again) or not unseen:
            yield Finding(1.0, f"step {index + 1} ({step.object})", index)


def sums_of_proofs(replay: Replay) -> Iterator[Finding]:
    """Find statements about the proofs of all motions, or of one, that cannot be true."""
    parts = [piece.segment for piece in replay.pieces]
    if replay.plan.certified != all(part.certified for part in parts if part.motion is not None):
        yield Finding(1.0, f"certified: {replay.plan.certified}")
    for part in parts:
        if part.certified and (part.motion is None or part.witness is not None):
            yield Finding(1.0, f"{part.kind}: certified, and nothing moves or something meets")


def sums_of_seconds(replay: Replay) -> Iterator[Finding]:
    """How far the time of all motions is from the sum of theirs [s]."""
    plan = replay.plan
    took = sum(piece.segment.seconds for piece in replay.pieces)
    yield Finding(abs(plan.seconds - took), f"{plan.seconds:g} s, the motions take {took:g} s")


def orders(replay: Replay) -> Iterator[Finding]:
    """Whether the order is that of the steps."""
    if replay.plan.order != [step.object for step in replay.plan.steps]:
        yield Finding(1.0, ", ".join(replay.plan.order))


# -- of its scene


def tilt_of_up(replay: Replay) -> Iterator[Finding]:
    """The angle between up of the plan and of the scene [rad]."""
    up = replay.situation.up
    angle = float(np.arccos(np.clip(replay.up @ up, -1.0, 1.0)))
    yield Finding(angle, f"the plan has {list(replay.plan.up)}, the scene {up.tolist()}")


def off_base(replay: Replay) -> Iterator[Finding]:
    """How far the arm stands from where the scene has it [m]."""
    its = replay.scene.robot_base
    if its is not None:
        ours, theirs = (f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in (replay.base[:3, 3], its[:3, 3]))
        yield Finding(off_by(replay.base, its), f"the plan has it at {ours}, the scene at {theirs}")


def beyond_seen(replay: Replay) -> Iterator[Finding]:
    """How far the plan's bodies stand out from those of the scene [m]."""
    return _beyond(replay, replay.parts, replay.situation.solids)


def beyond_guessed(replay: Replay) -> Iterator[Finding]:
    """How far they do with the sides that nobody saw [m]."""
    return _beyond(replay, replay.wholes, replay.situation.with_level_undersides().completed)


def _beyond(replay: Replay, said: Solids, own: Solids) -> Iterator[Finding]:
    for name in replay.scene.names:
        faces, corners = [joggled_sides(part) for part in own[name]], np.vstack(said[name])
        yield Finding(float(np.min([beyond(each, corners) for each in faces], axis=0).max()), name)


def fixed_in_one(replay: Replay) -> Iterator[Finding]:
    """Objects that never move in the plan or in the scene alone."""
    ours = replay.fixed - {MATTER, *own_bodies(replay.plan)}
    yield from (Finding(1.0, name) for name in sorted(ours ^ set(replay.scene.fixed)))


def unsaid_assumptions(replay: Replay) -> Iterator[Finding]:
    """Find assumptions of scene and arm that the plan does not state."""
    for words in (*replay.scene.assumptions, *replay.arm.assumptions):
        if words not in replay.plan.assumptions:
            yield Finding(1.0, words)
