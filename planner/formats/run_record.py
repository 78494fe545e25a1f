"""What a closed-loop run leaves behind, step by step: the data the run report is drawn from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees
from typing import Any

from topple.planner.decide.names import spoken
from topple.planner.fallbacks import Relaxation
from topple.planner.formats.arm_motion import ArmMotion
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.base.notebook import in_cell
from topple.topology.base.values import ByValue, in_columns
from topple.topology.scene.scene import Scene
from topple.topology.views.image import Photo

INTERRUPTED = "interrupted"
"""What a run is stopped by that somebody ended."""

Document = Mapping[str, Any]
"""A JSON document of the contract (`topple.relations`, `topple.order`), as its `to_json()` gives it."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Verdict(ByValue):
    """What one action did besides what it was meant to do.

    Attributes:
        violations: One sentence for each thing that was moved, turned, dropped or hit.
        disturbed: Distance [m] and angle [rad] by which everything that was not handled moved, by name.
        severity: How far the middle of what moved by more than counts fell [m], and with which energy [J].
        tilts: How far the others were tipped, turns about the vertical left out [rad], by name.
        forces: Largest contact force of the robot on an object not handled [N], by name.
        impulses: The largest of one touch, of what pressed by more than a brush does [N s], by name.
        slip: Distance [m] and angle [rad] by which the object moved in the hand; None where it was not held.
        dropped: Whether the object fell out of the hand, further than crockery survives.
        robot_seconds: Simulated time the arm moved; None where not measured.
    """

    violations: tuple[str, ...] = ()
    disturbed: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    severity: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    tilts: Mapping[str, float] = field(default_factory=dict[str, float])
    forces: Mapping[str, float] = field(default_factory=dict[str, float])
    impulses: Mapping[str, float] = field(default_factory=dict[str, float])
    slip: tuple[float, float] | None = None
    dropped: bool = False
    robot_seconds: float | None = None


@dataclass(frozen=True, eq=False)
class StepRecord(Verdict):
    """One action of the arm: what was seen before it, what it did, what was seen after it.

    Attributes:
        object: Name of the object that was handled; empty for an action on none (a second look).
        action: What was done, in a word or two ("take off and put down", "lift clear").
        success: The action did what it was meant to.
        attempts: Tries it took, 1 where the first one worked.
        relations_as_predicted: The relations seen afterwards are those the plan predicted.
        seconds: Wall-clock time of the step, planning and looking included.
        stopped_by: What was seen to move as the object was lifted: name -> how far [m]; it was put back then.
        waited: Wall-clock time from when the pictures were there that the step was chosen from until the arm
            began to move [s], None where not measured.
        prepared: Whether it was chosen while the arm did the step before.
        reason: Why this object and why now, and what was tried where it went wrong; plain sentences.
        picture_before: PNG bytes of the camera's view before the action, or None.
        picture_after: PNG bytes of the camera's view after it, or None.
        photo: The view before the action as it was taken for people, with its masks, or None.
        scene: What was seen before the action (clouds may be thinned already), or None.
        relations: `topple.relations` document of that scene, or None.
        order: `topple.order` document the step was chosen from, or None.
        predicted: `topple.relations` document the plan predicts after the action, or None.
        observed: `topple.relations` document of what was seen after the action, or None.
        tool_path: (k, 3) path of the tool centre point during the action [m, the scene's frame], or None.
        motion: How the arm moved, as planned, or None.
        events: What was not as planned and what followed from it, in sentences: another grasp, a new look,
            something newly seen, hidden or moved.
        fallbacks: What was tried to find the action where the plain way failed: see
            `topple.planner.fallbacks`.
    """

    object: str
    action: str
    success: bool
    attempts: int = 1
    relations_as_predicted: bool = True
    seconds: float = 0.0
    reason: str = ""
    picture_before: bytes | None = None
    picture_after: bytes | None = None
    photo: Photo | None = None
    scene: Scene | None = None
    relations: Document | None = None
    order: Document | None = None
    predicted: Document | None = None
    observed: Document | None = None
    tool_path: FloatArray | None = None
    motion: ArmMotion | None = None
    events: tuple[str, ...] = ()
    fallbacks: tuple[str, ...] = ()
    waited: float | None = None
    prepared: bool = False
    stopped_by: Mapping[str, float] = field(default_factory=dict[str, float])

    def to_json(self) -> dict[str, Any]:
        """The step as it stands in a `topple.run` document: no pictures, no clouds."""
        return {
            "object": self.object,
            "action": self.action,
            "success": self.success,
            "attempts": self.attempts,
            "disturbed": {name: list(map(float, move)) for name, move in self.disturbed.items()},
            "severity": _severity(self.severity),
            "relations_as_predicted": self.relations_as_predicted,
            "seconds": round(self.seconds, 3),
            "waited": None if self.waited is None else round(self.waited, 3),
            "prepared": self.prepared,
            "robot_seconds": None if self.robot_seconds is None else round(self.robot_seconds, 3),
            "reason": self.reason,
            "dropped": self.dropped,
            "events": list(self.events),
            "fallbacks": list(self.fallbacks),
            "unseen": Relaxation.UNSEEN in self.fallbacks,
            "tilts": {name: float(tilt) for name, tilt in self.tilts.items()},
            "forces": {name: float(force) for name, force in self.forces.items()},
            "impulses": {name: float(impulse) for name, impulse in self.impulses.items()},
            "slip": None if self.slip is None else list(self.slip),
        }


@dataclass(frozen=True, eq=False)
class RunRecord(ByValue):
    """A whole run: the goal, every step, and whether the goal holds at the end with nothing disturbed.

    Attributes:
        goal: The goal in words ("free plate").
        robot: Name of the arm.
        seed: Seed of every random choice of the run.
        success: The goal's relations hold at the end and there is no violation.
        violations: What went wrong, one sentence each; empty in a clean run.
        missing: Those of them that are about the goal: what of it does not hold at the end.
        steps: The actions in the order they were done; empty where the goal already held.
        seconds: Wall-clock time of the whole run.
        scene: What was seen at the end, or None.
        relations: `topple.relations` document of that, or None.
        order: `topple.order` document of what would be left to take, or None.
        wanted: PNG bytes of the same camera's view of the arrangement that was to be copied, or None.
        notes: What a reader should know besides: where the base stands, what was assumed.
        arm: The arm, for pictures of its motions; None where nobody knows.
        stopped: Why no more was done though the goal was not reached: "no plan", "budget", "blind" (nothing
            could be seen any more), "arm" (its hand does not let go, or it is not where it should be) or
            "interrupted" (by somebody); else empty.

    Examples:
        >>> print(RunRecord("free plate", "panda", 0, success=True).summary)
        Plate freed in 0 moves. Nothing else moved.
    """

    goal: str
    robot: str
    seed: int
    success: bool
    violations: tuple[str, ...] = ()
    steps: tuple[StepRecord, ...] = ()
    seconds: float = 0.0
    scene: Scene | None = None
    relations: Document | None = None
    order: Document | None = None
    notes: tuple[str, ...] = ()
    stopped: str = ""
    arm: Arm | None = None
    missing: tuple[str, ...] = ()
    wanted: bytes | None = None

    @property
    def verdict(self) -> str:
        """The outcome for the goal: "reached", "reached with violations" or "not reached"."""
        return "not reached" if self.missing else "reached" if self.success else "reached with violations"

    @property
    def summary(self) -> str:
        """The outcome in one line, as "Plate freed in 5 moves. Nothing else moved."."""
        before, free, names = self.goal.partition("free ")
        what, verb = f"{self.goal}:", "reached"
        if free and not before:
            what, verb = names.capitalize() if names.isalpha() else names, "freed"
        if self.missing:
            return f"{what} not {verb}: {self.missing[0]}."
        if self.success:
            return (
                f"{what} {verb} in {len(self.steps)} move{'s' * (len(self.steps) != 1)}. Nothing else moved."
            )
        wrong, *others = self.violations or ("a violation",)
        name, _, deed = wrong.partition(": ")
        at = [number for number, step in enumerate(self.steps, start=1) if deed and step.object == name]
        told = f"{deed} in step {at[-1]}" if at else wrong
        return f"{what} {verb}, but {told}{f', and {len(others)} more' if others else ''}."

    def __str__(self) -> str:
        """Format as `topple run` prints: the outcome, and a line for each action."""
        first = next((step.scene for step in self.steps if step.scene is not None), None)
        found = self.to_json() if first is None else spoken(first, self.to_json())
        return "\n".join([run_heading(found), *in_columns(run_rows(found))])

    @property
    def severity(self) -> Mapping[str, tuple[float, float]]:
        """How far what was disturbed fell [m], and with which energy [J], the worst of all steps by name."""
        worst: dict[str, tuple[float, float]] = {}
        for name, fall in (each for step in self.steps for each in step.severity.items()):
            worst[name] = max(worst.get(name, fall), fall)
        return worst

    @property
    def interrupted(self) -> bool:
        """Somebody ended the run before it came to its end."""
        return self.stopped == INTERRUPTED

    def _repr_html_(self) -> str | None:
        """Show the run in a notebook."""
        return in_cell(self)

    def to_json(self) -> dict[str, Any]:
        """The `topple.run` document, ready for `json.dumps`."""
        return {
            "format": "topple.run",
            "format_version": 1,
            "success": self.success,
            "goal": self.goal,
            "robot": self.robot,
            "seed": self.seed,
            "seconds": round(self.seconds, 3),
            "steps": [step.to_json() for step in self.steps],
            "stops": [
                {"object": step.object, "moved": name, "mm": round(1e3 * off, 1)}
                for step in self.steps
                for name, off in step.stopped_by.items()
            ],
            "severity": _severity(self.severity),
            "violations": list(self.violations),
            "verdict": self.verdict,
            "notes": list(self.notes),
            "stopped": self.stopped,
            "interrupted": self.interrupted,
        }


def _severity(falls: Mapping[str, tuple[float, float]]) -> Document:
    return {name: {"drop": float(drop), "energy": float(energy)} for name, (drop, energy) in falls.items()}


def run_heading(run: Document) -> str:
    """Sum up a `topple.run` document in one line."""
    outcome = {"reached": "done", "not reached": "failed"}.get(run["verdict"], run["verdict"])
    return f"{run['goal']}, {outcome} after {len(run['steps'])} actions, {run['seconds']:.1f} s"


def run_rows(run: Document) -> list[tuple[str, ...]]:
    """A row for each action of a `topple.run` document, with what else it moved."""
    rows: list[tuple[str, ...]] = []
    for number, step in enumerate(run["steps"], start=1):
        moved = [
            f"{name} {metres * 1000:.1f} mm {degrees(turn):.1f}°"
            for name, (metres, turn) in step["disturbed"].items()
            if metres > DISTURBED or turn > TURNED
        ]
        outcome = "done" if step["success"] else "failed"
        outcome += f", attempt {step['attempts']}" if step["attempts"] > 1 else ""
        relations = "as predicted" if step["relations_as_predicted"] else "not as predicted"
        deed, disturbed = (step["object"], step["action"], outcome), ", ".join(moved) or "nothing"
        rows.append((str(number), *deed, disturbed, relations, f"{step['seconds']:.1f}"))
    return rows
