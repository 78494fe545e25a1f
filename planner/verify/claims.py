"""What a plan claims, in one table: each claim with its residuals, how each is measured and its limit."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import topple.planner.verify.between as between
import topple.planner.verify.clouds as clouds
import topple.planner.verify.drive as drive
import topple.planner.verify.hand as hand
import topple.planner.verify.outcome as outcome
import topple.planner.verify.premises as premises
import topple.planner.verify.rest as rest
import topple.planner.verify.sight as sight
import topple.planner.verify.tolerances as most
from topple.planner.formats.plan_structs import Step
from topple.planner.placement.away import IN_HAND
from topple.planner.placement.tolerances import SHIFT, TURN
from topple.planner.tolerances import DISTURBED
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.by_fcl import collisions
from topple.planner.verify.force import Weights
from topple.planner.verify.replay import Finding, NoScene, Replay
from topple.planner.verify.verification import Proof, Residual


@dataclass(frozen=True)
class Check:
    """One residual.

    Attributes:
        name: Of what is measured.
        measure: Finds it in a replay; asks that for the scene where it needs one.
        unit: Of the values, 1 for counts and shares.
        allowed: The largest value; None where findings are counted, and there should be none.
    """

    name: str
    measure: Callable[[Replay], Iterable[Finding]]
    unit: str = "1"
    allowed: float | None = None

    def residual(self, replay: Replay) -> Residual:
        """Measure it: the worst beyond what is allowed, or the count; `inf` without a scene it needs."""
        try:
            found = list(self.measure(replay))
        except NoScene as error:
            return Residual(self.name, math.inf, self.unit, str(error))
        allowed = self.allowed or 0.0
        steps = {each.step for each in found if each.step is not None and not each.value <= allowed}
        if self.allowed is None:
            found = [each for each in found if each.value]
            value, where = float(sum(each.value for each in found)), "; ".join(each.where for each in found)
        else:
            start = Finding(0.0, "")
            value, where, _ = max((start, *found), key=lambda x: math.inf if math.isnan(x.value) else x.value)
        return Residual(self.name, value - allowed, self.unit, where, allowed, tuple(sorted(steps)))


Why = Callable[[Replay, int], str]
"""Why a claim is not shown of a step, by its index, or a figure of it; empty where there is none."""


@dataclass(frozen=True)
class Claim:
    """What is claimed of every step, or of the plan as a whole.

    Attributes:
        what: In a few words.
        means: By which it is looked at.
        checks: Residuals that refute it.
        asked: Whether it is claimed of a step.
        unshown: Why nothing was shown of a step that nothing speaks against.
        figure: What was found of a step of which it is shown.
    """

    what: str
    means: str
    checks: tuple[Check, ...]
    asked: Callable[[Replay, Step], bool] = lambda _replay, _step: True
    unshown: tuple[Why, ...] = ()
    figure: Why = lambda _replay, _step: ""

    @property
    def names(self) -> tuple[str, ...]:
        """Of its residuals."""
        return tuple(check.name for check in self.checks)

    def proof(
        self, replay: Replay, residuals: Mapping[str, Residual], step: int | None = None
    ) -> Proof | None:
        """Judge the claim by residuals, of one step or of the whole plan; None where it is not claimed."""
        asked, means = [residuals[name] for name in self.names], self.means.format(step=replay.spacing)
        failed = [each for each in asked if each.evaluated and not each.ok and step in (None, *each.steps)]
        if failed:
            words = "; ".join(f"{each.name}: {each.witness}" for each in failed)
            return Proof(self.what, means, False, words)
        why = next((each.witness for each in asked if not each.evaluated), "")
        if step is None:
            return Proof(self.what, means, None if why else True, why)
        if not self.asked(replay, replay.plan.steps[step]):
            return None
        why = why or next(filter(None, (ask(replay, step) for ask in self.unshown)), "")
        return Proof(self.what, means, None if why else True, why or self.figure(replay, step))


def _no_motion(replay: Replay, step: int) -> str:
    moves = any(piece.index == step and piece.segment.motion is not None for piece in replay.pieces)
    return "" if moves else "there is no motion"


def _states(replay: Replay, step: int) -> str:
    some = (piece for piece in replay.pieces if piece.index == step and piece.segment.motion is not None)
    return f"{sum(len(piece.states) for piece in some)} states"


def _never_let_go(replay: Replay, step: int) -> str:
    here = (piece for piece in replay.of_kind(SegmentKind.RELEASE) if piece.index == step)
    kept = replay.plan.steps[step].placement.how in IN_HAND
    return "" if kept or any(piece.step.object in piece.poses for piece in here) else "it is never let go"


def _in_hand(replay: Replay, step: int) -> str:
    kept = replay.plan.steps[step].placement.how in IN_HAND
    return "it stays in the hand, as its step says" if kept else ""


def _falling_words(replay: Replay, step: int) -> str:
    return "it is let go to fall, as its step says" if replay.plan.steps[step].placement.falls else ""


def _unseen_words(replay: Replay, step: int) -> str:
    words = "the hand comes in where no camera saw that there is nothing, as its step says"
    return words if replay.plan.steps[step].unseen else ""


def _load(replay: Replay, step: int) -> str:
    """The share of what the hand resists that the weight takes."""
    one, weights = replay.plan.steps[step], replay.once(Weights)
    weighed = {one.object, *(each.object for each in one.attachments)} <= weights.masses.keys()
    return f"{weights.loads[step]:.0%} of it, {'weighed' if weighed else 'weight guessed from volume'}"


def _not_borne(replay: Replay, step: int) -> str:
    """More than the hand holds of a guess is no refutation."""
    load = replay.once(Weights).loads.get(step)
    if load is None:
        return "nothing is held, or it has no volume"
    return "" if load <= 1.0 else _load(replay, step)


def _not_carried(replay: Replay, step: int) -> str:
    words = replay.once(Weights).guessed.get(step, "")
    return words and f"{words}, weight guessed from volume"


SEEN_ORDER = Claim(
    "so it is by what was seen",
    "dependencies derived again",
    (
        Check("dependencies of the scene broken", outcome.out_of_seen_order),
        Check("dependencies that the scene does not give", outcome.extra_dependencies),
    ),
)
OF_STEPS = (
    Claim(
        "what has to go first has gone",
        "the plan's dependencies",
        (
            Check("dependencies of the plan broken", outcome.out_of_order),
            Check("steps that wait otherwise than dependencies say", outcome.waiting_otherwise),
            Check("excuses for dependencies that are kept", outcome.excuses),
        ),
    ),
    SEEN_ORDER,
    Claim(
        "it is held from grasp to release",
        "hand state replayed",
        (
            Check("grasps that hold nothing", lambda replay: replay.empty),
            Check("steps that do not move their object", lambda replay: replay.unmoved),
            Check("objects in the hand when a step ends", lambda replay: replay.kept),
            Check("what is said to be in the hand and is not", hand.said_to_be_held),
            Check("hand that changes while it holds", lambda replay: replay.changed, "m", most.OPENED),
            Check("tool at the grasp", hand.off_grasp, "m", most.OFF),
            Check("object at the tool", hand.off_object, "m", most.REACHED),
            Check("attachment against grasp", hand.off_attachment, "m", most.OFF),
            Check("scores against their terms", premises.scores, "1", most.ROUNDED_SCORE),
        ),
    ),
    Claim(
        "its weight is held",
        "force and friction of what holds it",
        (Check("weight beyond what the hand can hold", lambda replay: replay.once(Weights).heavy, "N", 0.0),),
        unshown=(_not_borne,),
        figure=_load,
    ),
    Claim(
        "the arm can carry it",
        "rated payload, gravity torques on the way",
        (
            Check("load beyond the rated payload", lambda replay: replay.once(Weights).overload, "kg", 0.0),
            Check(
                "joint torques against effort limits", lambda replay: replay.once(Weights).torques, "1", 1.0
            ),
        ),
        unshown=(_no_motion, _not_carried),
    ),
    Claim(
        "arm and load meet nothing",
        "python-fcl every {step:g} rad",
        (
            Check("collisions (python-fcl)", collisions, "m", most.BY_FCL_SLACK),
            Check("pairs that may touch without a reason", hand.touching_without_reason),
        ),
        unshown=(_no_motion,),
        figure=_states,
    ),
    Claim(
        "nor between these states",
        "swept certificate derived again",
        (Check("motions without a proof", between.open_motions),),
        unshown=(_no_motion, between.open_motion),
        figure=between.clearance,
    ),
    Claim(
        "no seen point is entered",
        "clouds against links and load",
        (Check("seen points entered", clouds.depths_in_arm, "m", most.NOISE),),
        unshown=(_no_motion, _unseen_words),
    ),
    Claim(
        "the arm can follow",
        "limits of joints, speeds and accelerations",
        (
            Check("joint positions", drive.beyond_limits, "rad", most.WRITTEN),
            Check("joint velocities", drive.speeds, "1", most.OVER),
            Check("joint accelerations", drive.accelerations, "1", most.OVER),
            Check("continuity", drive.jumps, "rad", most.JUMP),
            Check("rest at the joins", drive.unrest, "rad/s", most.AT_REST),
            Check("positions from velocities", drive.drifts, "rad", most.DRIFT),
            Check("times that do not increase", drive.times),
        ),
        unshown=(_no_motion,),
    ),
    Claim(
        "a controller drives what was checked",
        "cubics through the samples",
        (Check("splines through the samples off the straight way", drive.strays, "m", most.STRAYED),),
        unshown=(_no_motion,),
    ),
    Claim(
        "it is kept level",
        "tilt along the motion",
        (
            Check("tilt of what is kept upright", hand.tilts, "rad", most.TILT),
            Check("steps upright that are not to be, or the other way round", premises.uprights),
        ),
        asked=lambda _, step: step.upright,
        unshown=(_no_motion,),
    ),
    Claim(
        "it is let go where the step says",
        "hand state replayed",
        (
            Check("tool at the place", hand.off_place, "m", most.OFF),
            Check("object against its place", lambda replay: replay.misplaced, "m", 2.0 * most.OFF),
            Check("put into what it is not over", lambda replay: replay.beside),
        ),
        unshown=(_never_let_go,),
    ),
    Claim(
        "it ends where things go that are taken",
        "bodies at the end of its step",
        (
            Check("away where the plan does not say", hand.elsewhere),
            Check("short of 15 cm from everything", hand.short_of_clear, "m", most.SHORT),
            Check("held out beside the point", hand.beside_point, "m", most.OFF),
            Check("off the area that is vouched for", hand.off_area, "m", most.OFF),
            Check("falls otherwise than it says", hand.falls, "m", most.FALL),
        ),
        asked=lambda replay, _: replay.plan.away is not None,
    ),
    Claim(
        "nor is it pressed into what bears it",
        "clouds against the load",
        (Check("pressed into what it is put on or into", clouds.depths_in_load, "m", most.NOISE),),
        asked=lambda _, step: step.placement.into is not None,
        unshown=(_in_hand, _never_let_go),
    ),
    Claim(
        "it stays there",
        "let go in PyBullet",
        (
            Check("shift after letting go", rest.shifts, "m", SHIFT),
            Check("turn after letting go", rest.turns, "rad", TURN),
            Check("outside of its container after letting go", rest.out_of_container, "m", 0.0),
            Check("said to fall, and stays", rest.false_falls),
        ),
        unshown=(_in_hand, _never_let_go, _falling_words),
    ),
)
OF_PLANS = (
    Claim(
        "the plan is of this scene",
        "bodies held against clouds",
        (
            Check("points outside of the plan's bodies", clouds.outside, "m", most.FILLED),
            Check("up of the plan against the scene's", premises.tilt_of_up, "rad", most.UPWARD),
            Check("bodies of the plan beyond the scene's", premises.beyond_seen, "m", most.SAME),
            Check("objects fixed in the plan or the scene alone", premises.fixed_in_one),
            Check("bodies outside of their wholes", rest.outside_of_wholes, "m", most.ROUNDED),
        ),
    ),
    Claim(
        "its hidden sides are those of this scene",
        "bodies completed again",
        (Check("hidden sides of the plan beyond the scene's", premises.beyond_guessed, "m", most.SAME),),
    ),
    Claim(
        "the arm stands where the scene has it",
        "poses compared",
        (Check("base of the plan against the scene's", premises.off_base, "m", most.SAME),),
    ),
    Claim(
        "the goal is reached",
        "relations and places afterwards",
        (
            Check("goal clauses unmet", outcome.unmet),
            Check("bodies off their place", outcome.off_wanted, "m", DISTURBED),
            Check("order against the steps", premises.orders),
            Check("actions that the goal does not ask for", outcome.not_asked_for),
        ),
    ),
    Claim(
        "it tells of itself what is so",
        "counted again",
        (
            Check("proofs against those of the motions", premises.sums_of_proofs),
            Check("seconds against those of the motions", premises.sums_of_seconds, "s", most.ROUNDED_TIME),
            Check("steps said to make room or come unseen, or not, against the rest", premises.marks),
            Check("hands that come in unseen and are not said to", sight.unsaid),
            Check("assumptions of the scene or the arm left out", premises.unsaid_assumptions),
        ),
    ),
)
UNASKED = ("torques of speeding up", "friction and hidden sides other than assumed", "what moves by itself")
"""What no check asks of any plan."""
