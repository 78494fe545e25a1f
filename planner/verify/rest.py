"""Whether things stay where a plan puts them: each is let go in simulation, the others held in place."""

from dataclasses import dataclass, field

import numpy as np

from topple.planner.decide.goal import PlaceRelation
from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.placement.away import BODIES, Away
from topple.planner.placement.drops import Drops
from topple.planner.placement.proof import settled
from topple.planner.placement.tolerances import SHIFT, TURN
from topple.planner.verify.bodies import completed_of, parts_of
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import ROUNDED
from topple.topology.bodies.solids import moved
from topple.topology.geometry.sides import beyond, joggled_sides


@dataclass(eq=False)
class RestCheck:
    """Collects how far things get that are let go in the segments it is shown.

    What is put on a table is asked with the hidden sides, which it may have to stand on; what is put
    on or into another thing was lowered by what was seen of both. What is put into a container may roll but
    has to stay in it. A step that says that it lets its object fall is not counted, and told of.

    Attributes:
        plan: The plan.
        allowed: What falls as its step says, in sentences.
    """

    plan: PlanData
    shift: Worst = field(default_factory=lambda: Worst("shift after letting go", "m", SHIFT))
    turn: Worst = field(default_factory=lambda: Worst("turn after letting go", "rad", TURN))
    out: Worst = field(default_factory=lambda: Worst("outside of its container after letting go", "m"))
    excused: Worst = field(default_factory=lambda: Worst("said to fall, and stays", "1"))
    allowed: list[str] = field(default_factory=list[str])

    def __post_init__(self) -> None:
        self._up = np.array(self.plan.up)
        self._parts, self._whole = parts_of(self.plan), completed_of(self.plan)

    def look(self, piece: SegmentReplay) -> None:
        """Let go what a step puts down; the piece is the one in which it does."""
        step = piece.step
        into, name = step.placement.into, step.object
        if name not in piece.poses or (into is not None and into not in piece.poses):
            return  # it is in the hand still, which is told elsewhere
        containers = {PlaceRelation.WITHIN: into, Away.BIN: BODIES[Away.BIN]}
        inside = next((of for how, of in containers.items() if how == step.placement.how), None)
        riding = {held.object for held in step.attachments} - {name}
        bodies = {n: moved(self._parts[n], pose) for n, pose in piece.poses.items() if n not in riding}
        if into is None and inside is None:
            bodies[name] = moved(self._whole[name], piece.poses[name])
        release = np.eye(4)
        release[:3, 3] += step.placement.drop * self._up
        container = None if inside is None else np.vstack(bodies[inside])
        with Drops(name, bodies, self._up) as drops:
            found = settled(drops, release, np.eye(4), container, self._up)
        where = f"step {piece.index + 1} ({name})"
        if step.placement.falls:
            self.allowed.append(f"{where} is let go to fall: {found}")
            if found.within():
                self.excused.count(where, piece.index)
        elif found.outside is not None:
            self.out.note(found.outside, where, piece.index)
        else:
            self.shift.note(found.shift, where, piece.index)
            self.turn.note(found.turn, where, piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """How far things shift, turn and leave containers, and what of bodies is outside of their wholes."""
        found = (self.shift, self.turn, self.out, self.excused)
        return *(worst.residual() for worst in found), _around(self.plan)


def _around(plan: PlanData) -> Residual:
    """How far what was seen of the objects sticks out of the bodies that are taken for whole."""
    worst = Worst("bodies outside of their wholes", "m", ROUNDED)
    for thing in plan.objects:
        hulls = [joggled_sides(np.array(part)) for part in thing.whole]
        if hulls:
            seen = np.vstack(thing.parts)
            out = np.min([beyond(sides, seen) for sides in hulls], axis=0)
            worst.note(float(out.max()), thing.name)
    return worst.residual()
