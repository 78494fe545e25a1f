"""What checks come to, step by step: what is shown, by which means, and what is not."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from topple.planner.formats.plan_structs import PlanData, Step
from topple.planner.formats.verification import BROKEN, OFF_PLACE, Proof, Residual, StepProofs
from topple.planner.grasp.grasp import GraspKind
from topple.planner.verify.between import BetweenCheck
from topple.planner.verify.force import ForceCheck
from topple.planner.verify.replay import SegmentReplay


class Claim(NamedTuple):
    """What a plan claims, the means to look at it, and the residuals that it takes."""

    what: str
    means: str
    residuals: tuple[str, ...]


HELD = Claim(
    "it is held from grasp to release",
    "hand state replayed",
    (
        "grasps that hold nothing",
        "steps that do not move their object",
        "objects in the hand when a step ends",
        "what is said to be in the hand and is not",
        "hand that changes while it holds",
        "tool at the grasp",
        "object at the tool",
        "attachment against grasp",
        "scores against their terms",
    ),
)
FREE = Claim(
    "arm and load meet nothing",
    "python-fcl every {fine} rad, PyBullet every {coarse} rad",
    (
        "collisions (python-fcl)",
        "collisions (PyBullet)",
        "touching bodies pressed deeper",
        "kinematics against PyBullet",
        "pairs that may touch without a reason",
    ),
)
BETWEEN = Claim("nor between these states", "swept certificate derived again", ("motions without a proof",))
DRIVABLE = Claim(
    "the arm can follow",
    "limits of joints, speeds and accelerations",
    (
        "joint positions",
        "joint velocities",
        "joint accelerations",
        "continuity",
        "rest at the joins",
        "positions from velocities",
        "times that do not increase",
    ),
)
PUT = Claim(
    "it is let go where the step says",
    "hand state replayed",
    ("tool at the place", "object against its place", "put into what it is not over"),
)
STAYS = Claim(
    "it stays there",
    "let go in PyBullet",
    (
        "shift of what is pushed",
        "turn of what is pushed",
        "disturbed by what is pushed",
        "shift after letting go",
        "turn after letting go",
        "outside of its container after letting go",
        "said to fall, and stays",
    ),
)
LEVEL = Claim(
    "it is kept level",
    "tilt along the motion",
    ("tilt of what is kept upright", "steps upright that are not to be, or the other way round"),
)
TURN = Claim(
    "what has to go first has gone",
    "the plan's dependencies",
    (
        "dependencies of the plan broken",
        "steps that wait for nothing and should",
        "excuses for dependencies that are kept",
    ),
)
TURN_AGAIN = Claim("so it is by what was seen", "dependencies derived again", (BROKEN,))
SEEN = Claim("no seen point is entered", "clouds against links and load", ("seen points entered",))
GOAL = Claim(
    "the goal is reached",
    "relations and places afterwards",
    ("goal clauses unmet", OFF_PLACE, "order against the steps"),
)
SAME = Claim(
    "the plan is of this scene",
    "bodies held against clouds",
    (
        "points outside of the plan's bodies",
        "up of the plan against the scene's",
        "bodies of the plan beyond the scene's",
        "objects fixed in the plan or the scene alone",
        "bodies outside of their wholes",
    ),
)
OF_MOTIONS = (FREE, BETWEEN, SEEN, DRIVABLE, LEVEL)
OF_STEPS = (TURN, TURN_AGAIN, HELD, FREE, BETWEEN, SEEN, DRIVABLE, LEVEL, PUT, STAYS)
OF_PLANS = (SAME, GOAL)
UNASKED = ("joint torques", "friction and hidden sides other than assumed", "what moves by itself")
"""What no check asks of any plan."""


class Proofs:
    """Says of each step what the segments it is shown and the residuals prove of it.

    Args:
        plan: The plan.
        between: What is proven between states.
        force: What the hand holds by force.
        weighed: Names of objects whose mass is known.
        spacing: Of the states [rad] of python-fcl, and of PyBullet.
    """

    def __init__(
        self,
        plan: PlanData,
        between: BetweenCheck,
        force: ForceCheck,
        weighed: Collection[str],
        spacing: tuple[float, float],
    ) -> None:
        self._plan, self._between, self._force = plan, between, force
        self._weighed, self._spacing = weighed, spacing
        self._states: dict[int, int] = {}
        self._released: set[int] = set()

    def look(self, piece: SegmentReplay) -> None:
        """Take down what a segment gives the checks to look at."""
        if piece.segment.motion is not None:
            self._states[piece.index] = self._states.get(piece.index, 0) + len(piece.states)
        if piece.segment.kind == "release" and piece.step.object in piece.poses:
            self._released.add(piece.index)

    def steps(self, residuals: Sequence[Residual]) -> tuple[StepProofs, ...]:
        """What is proven of each step."""
        return tuple(self._of(index, step, residuals) for index, step in enumerate(self._plan.steps))

    def whole(self, residuals: Sequence[Residual]) -> tuple[Proof, ...]:
        """What is proven of the plan as a whole."""
        return tuple(_proof(claim, residuals) for claim in OF_PLANS)

    def _of(self, index: int, step: Step, residuals: Sequence[Residual]) -> StepProofs:
        found: list[Proof] = []
        for claim in OF_STEPS:
            proof = _proof(claim, residuals, index)
            if claim is LEVEL and not step.upright and proof.shown:
                continue
            if proof.shown and (why := self._unasked(claim, index, step)):
                proof = replace(proof, shown=None, detail=why)
            found.append(self._told(claim, index, proof))
            if claim is HELD:
                found.append(self._strong_enough(index, step))
        return StepProofs(index, step.object, step.action, tuple(found))

    def _unasked(self, claim: Claim, index: int, step: Step) -> str:
        """Why a claim that nothing speaks against was not looked at; empty where it was."""
        if claim in OF_MOTIONS and index not in self._states:
            return "there is no motion"
        if claim is BETWEEN:
            return self._between.open.get(index, "")
        if claim in (PUT, STAYS) and index not in self._released:
            return "it is never let go"
        return "it is let go to fall, as its step says" if claim is STAYS and step.placement.falls else ""

    def _told(self, claim: Claim, index: int, proof: Proof) -> Proof:
        """With the figures of a step."""
        if claim is FREE:
            fine, coarse = self._spacing
            proof = replace(proof, means=claim.means.format(fine=f"{fine:g}", coarse=f"{coarse:g}"))
        if not proof.shown or claim not in (FREE, BETWEEN):
            return proof
        clearance = f"{1e3 * self._between.clearance[index]:.2g} mm at least" if claim is BETWEEN else ""
        return replace(proof, detail=clearance or f"{self._states[index]} states")

    def _strong_enough(self, index: int, step: Step) -> Proof:
        """Whether the hand holds the weight by force; more than it holds of a guess is no refutation."""
        if step.grasp.kind == GraspKind.PUSH:
            return Proof("its weight is held", "the table carries it", None, "it is pushed, never lifted")
        cup = step.grasp.kind == GraspKind.SUCTION
        means = "suction limit of the cup" if cup else "friction and force of the pads"
        load = self._force.loads.get(index)
        if load is None:
            return Proof("its weight is held", means, None, "nothing is held, or it has no volume")
        held = {step.object, *(each.object for each in step.attachments)}
        weight = "weighed" if held <= set(self._weighed) else "weight guessed from volume"
        return Proof(
            "its weight is held", means, True if load <= 1.0 else None, f"{load:.0%} of it, {weight}"
        )


def _proof(claim: Claim, residuals: Sequence[Residual], index: int | None = None) -> Proof:
    """What residuals say of a claim, of one step or of the whole plan."""
    asked = [residual for residual in residuals if residual.name in claim.residuals]
    failed = [each for each in asked if each.evaluated and not each.ok]
    failed = [each for each in failed if index is None or index in each.steps]
    if failed:
        words = "; ".join(f"{each.name}: {each.witness}" for each in failed)
        return Proof(claim.what, claim.means, False, words)
    missing = next((each.witness for each in asked if not each.evaluated), None)
    return Proof(claim.what, claim.means, True if missing is None else None, missing or "")
