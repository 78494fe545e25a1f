"""What checks come to, step by step: what is shown, by which means, and what is not."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from topple.planner.formats.plan_structs import PlanData, Step
from topple.planner.formats.verification import BROKEN, OFF_PLACE, UNFOUND, Proof, Residual, StepProofs
from topple.planner.grasp.grasp import GraspKind
from topple.planner.placement.away import IN_HAND
from topple.planner.verify.between import BetweenCheck
from topple.planner.verify.force import ForceCheck
from topple.planner.verify.handed import HANDED
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.sight import UNSAID


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
WEIGHT = Claim("its weight is held", "force of the hand", ("weight beyond what the hand can hold",))
CARRIED = Claim(
    "the arm can carry it",
    "rated payload, gravity torques on the way",
    ("load beyond the rated payload", "joint torques against effort limits"),
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
FOLLOWED = Claim(
    "a controller drives what was checked",
    "cubics through the samples",
    ("splines through the samples off the straight way",),
)
PUT = Claim(
    "it is let go where the step says",
    "hand state replayed",
    ("tool at the place", "object against its place", "put into what it is not over"),
)
HANDED_ON = Claim("it ends where things go that are taken", "bodies at the end of its step", HANDED)
STAYS = Claim(
    "it stays there",
    "let go in PyBullet",
    (
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
        "steps that wait otherwise than dependencies say",
        "excuses for dependencies that are kept",
    ),
)
TURN_AGAIN = Claim("so it is by what was seen", "dependencies derived again", (BROKEN, UNFOUND))
SEEN = Claim("no seen point is entered", "clouds against links and load", ("seen points entered",))
PRESSED = Claim(
    "nor is it pressed into what bears it",
    "clouds against the load",
    ("pressed into what it is put on or into",),
)
GOAL = Claim(
    "the goal is reached",
    "relations and places afterwards",
    ("goal clauses unmet", OFF_PLACE, "order against the steps", "actions that the goal does not ask for"),
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
HIDDEN = Claim(
    "its hidden sides are those of this scene",
    "bodies completed again",
    ("hidden sides of the plan beyond the scene's",),
)
TOLD = Claim(
    "it tells of itself what is so",
    "counted again",
    (
        "proofs against those of the motions",
        "seconds against those of the motions",
        "steps said to make room or come unseen, or not, against the rest",
        UNSAID,
        "assumptions of the scene or the arm left out",
    ),
)
BASE = Claim(
    "the arm stands where the scene has it", "poses compared", ("base of the plan against the scene's",)
)
OF_MOTIONS = (CARRIED, FREE, BETWEEN, SEEN, DRIVABLE, FOLLOWED, LEVEL)
OF_STEPS = (
    TURN,
    TURN_AGAIN,
    HELD,
    WEIGHT,
    CARRIED,
    FREE,
    BETWEEN,
    SEEN,
    DRIVABLE,
    FOLLOWED,
    LEVEL,
    PUT,
    HANDED_ON,
    PRESSED,
    STAYS,
)
OF_PLANS = (SAME, HIDDEN, BASE, GOAL, TOLD)
UNASKED = ("torques of speeding up", "friction and hidden sides other than assumed", "what moves by itself")
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
        away = self._plan.away is not None
        asked = {LEVEL: step.upright, PRESSED: step.placement.into is not None, HANDED_ON: away}
        for claim in OF_STEPS:
            proof = _proof(claim, residuals, index)
            if proof.shown is not False and not asked.get(claim, True):
                continue
            if claim is WEIGHT and proof.shown:
                proof = self._strong_enough(index, step)
            elif proof.shown and (why := self._unasked(claim, index, step)):
                proof = replace(proof, shown=None, detail=why)
            found.append(self._told(claim, index, proof))
        return StepProofs(index, step.object, step.action, tuple(found))

    def _unasked(self, claim: Claim, index: int, step: Step) -> str:
        """Why a claim that nothing speaks against was not looked at; empty where it was."""
        if claim in OF_MOTIONS and index not in self._states:
            return "there is no motion"
        if claim is BETWEEN:
            return self._between.open.get(index, "")
        if claim is CARRIED:
            words = self._force.guessed.get(index, "")
            return words and f"{words}, weight guessed from volume"
        if claim in (PRESSED, STAYS) and step.placement.how in IN_HAND:
            return "it stays in the hand, as its step says"
        if (
            claim in (PUT, PRESSED, STAYS)
            and step.placement.how not in IN_HAND
            and index not in self._released
        ):
            return "it is never let go"
        if claim is SEEN and step.unseen:
            return "the hand comes in where no camera saw that there is nothing, as its step says"
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
        cup = step.grasp.kind == GraspKind.SUCTION
        means = "suction limit of the cup" if cup else "friction and force of the pads"
        load = self._force.loads.get(index)
        if load is None:
            return Proof(WEIGHT.what, means, None, "nothing is held, or it has no volume")
        held = {step.object, *(each.object for each in step.attachments)}
        weight = "weighed" if held <= set(self._weighed) else "weight guessed from volume"
        return Proof(WEIGHT.what, means, True if load <= 1.0 else None, f"{load:.0%} of it, {weight}")


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
