"""A plan as data: frozen structs that are written as JSON and read back equal."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np

from topple.planner.formats.plan_robot import ArmData
from topple.planner.transfer.segments import KINDS
from topple.topology.arrays import FloatArray
from topple.topology.errors import InvalidInput
from topple.topology.notebook import in_cell

if TYPE_CHECKING:
    from topple.planner.formats.verification import Verification
    from topple.robots.arm.arm import Arm
    from topple.topology.scene import Scene

FORMAT = "topple.plan"
FORMAT_VERSION = 1

Matrix = list[list[float]]


class JointTrajectory(NamedTuple):
    """A motion as arrays: times (t,) [s], positions (t, n) [rad] or [m], velocities (t, n)."""

    times: FloatArray
    positions: FloatArray
    velocities: FloatArray


class HandState(msgspec.Struct, frozen=True, forbid_unknown_fields=False):
    """How the hand stands: distance of the pads and extension of the cup [m]."""

    opening: float
    cup_extension: float


class Motion(msgspec.Struct, frozen=True):
    """A joint trajectory: times (t,) [s], positions (t, n) [rad], velocities (t, n) [rad/s]."""

    times: list[float]
    positions: Matrix
    velocities: Matrix


class SegmentData(msgspec.Struct, frozen=True):
    """One piece of a step.

    Attributes:
        kind: One of `topple.planner.transfer.segments.KINDS`.
        tool: "fingers" or "suction".
        hand: Set before the motion; for grasp and release what the hand is brought to.
        motion: Null for grasp and release.
        holding: What is in the hand.
        may_touch: Pairs of names (links, objects) that touch here and are meant to.
        certified: Whether the motion was proven free between its samples too.
        clearance: Proven lower bound [m] of the distance, all along, of the arm and what it holds to all that
            stands, but for the pairs that may touch.
        witness: What meets what where the proof failed.
    """

    kind: str
    tool: str
    hand: HandState
    motion: Motion | None = None
    holding: str | None = None
    may_touch: list[tuple[str, str]] = []
    certified: bool = False
    clearance: float = 0.0
    witness: tuple[str, str] | None = None


class GraspData(msgspec.Struct, frozen=True):
    """How an object is held; the pose is that of the tool frame in the world.

    `terms` are what the score is made of (`topple.planner.grasp.score`); grasps of one's own have none.
    """

    kind: str
    pose_tool_to_world: Matrix
    width: float
    score: float
    reason: str = ""
    terms: dict[str, float] = {}


class AttachmentData(msgspec.Struct, frozen=True):
    """Something that moves with the hand: the object, and what rides in it.

    Attributes:
        object: Its name.
        tool: The tool frame that carries it.
        pose_start_to_tool: Rigid transform from the world as it was when the plan began, where `objects` has
            the object's parts, to the tool frame: how it is held.
    """

    object: str
    tool: str
    pose_start_to_tool: Matrix


class PlacementData(msgspec.Struct, frozen=True):
    """Where it goes: the rigid transform of the object in the world, and how it then lies.

    Attributes:
        pose_before_to_after: From where it is before the step to where it is let go.
        rest: In words.
        drop: How far it then falls [m].
        into: What it is put on or into; null on a table.
        how: "on" or "within" that; empty on a table.
        falls: Whether it is let go though it does not stay there: a drop that was allowed.
    """

    pose_before_to_after: Matrix
    rest: str = ""
    drop: float = 0.0
    into: str | None = None
    how: str = ""
    falls: bool = False


class DependencyData(msgspec.Struct, frozen=True):
    """`first` has to go before `then`."""

    first: str
    then: str
    reason: str
    confidence: float


class Step(msgspec.Struct, frozen=True):
    """One pick and place.

    Attributes:
        object: What is moved.
        action: "remove" what is in the way, "free" a target, or "place" it where the goal says.
        reason: Why, in a sentence.
        after: Indices of the steps that have to be done before this one.
        grasp: How it is held.
        placement: Where it goes.
        segments: What the arm does, in order.
        attachments: What moves with the hand from grasp to release.
        upright: Whether the object is kept upright on the way.
        planning_seconds: What it took to find this step.
        against: Dependencies, each more likely wrong than right, that it goes against.
        fallbacks: What was tried to find the step where the plain way failed: see
            `topple.planner.fallbacks`.
        buffer: Whether the object only makes room, and is taken again to where it shall be.
    """

    object: str
    action: str
    reason: str
    after: list[int]
    grasp: GraspData
    placement: PlacementData
    segments: list[SegmentData]
    attachments: list[AttachmentData] = []
    upright: bool = False
    planning_seconds: float = 0.0
    against: list[DependencyData] = []
    fallbacks: list[str] = []
    buffer: bool = False


class ObjectData(msgspec.Struct, frozen=True):
    """What the plan took an object for before anything moved: convex parts, vertices in the world [m].

    Attributes:
        name: Its name.
        fixed: Whether it never moves.
        parts: What was seen of it: this is kept clear of.
        whole: The same with the hidden sides: this has to stand where the object is put on a table.
            Empty where nothing was guessed.
    """

    name: str
    fixed: bool
    parts: list[Matrix]
    whole: list[Matrix] = []


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """A whole sequence.

    Attributes:
        format: Always "topple.plan".
        format_version: Of this layout.
        goal: In words.
        robot: The arm's name.
        joints: Names of its joints, as in the trajectories' columns.
        seed: All searches started from it.
        pose_base_to_world: Where the arm stands.
        base_searched: Whether that was searched for, because nobody gave it.
        q_start: Joint values the plan starts from [rad].
        order: What is handled, first to last.
        dependencies: Why that order.
        steps: What is done.
        objects: Everything that was kept clear of.
        up: Against gravity, in the world.
        upright: Objects that are kept upright, with what is in them.
        assumptions: What was assumed and not seen.
        certified: Whether every motion was proven free between its samples too.
        seconds: Duration of the motions [s].
        planning_seconds: What it took to find the plan.
        tried: What was dropped on the way, with counts.
        arm: The arm with its tools, and where its URDF is; null in plans of older versions.
        poses: Where things shall lie in the end, where that was given: by name, the rigid transform in the
            world from where each is at the start.
    """

    format: str = FORMAT
    format_version: int = FORMAT_VERSION
    goal: str
    robot: str
    joints: list[str]
    seed: int
    pose_base_to_world: Matrix
    base_searched: bool
    q_start: list[float]
    order: list[str]
    dependencies: list[DependencyData]
    steps: list[Step]
    objects: list[ObjectData] = []
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    upright: list[str] = []
    assumptions: list[str] = []
    certified: bool = False
    seconds: float = 0.0
    planning_seconds: float = 0.0
    tried: dict[str, int] = {}
    arm: ArmData | None = None
    poses: dict[str, Matrix] = {}

    def trajectory(self, step: int, segment: int | str) -> "JointTrajectory":
        """Give one motion as arrays.

        Args:
            step: Index of the step, from 0.
            segment: Index of the segment in it, from 0, or its kind, such as "approach".

        Returns:
            Times (t,) [s] from 0, positions (t, n) [rad] or [m], velocities (t, n), columns as in `joints`.

        Raises:
            InvalidInput: There is no such step or segment, or the arm stands still in it (grasp, release).
        """
        if not 0 <= step < len(self.steps):
            raise InvalidInput(f"the plan has no step {step}: expected 0 to {len(self.steps) - 1}")
        segments = self.steps[step].segments
        kinds = [part.kind for part in segments]
        found = kinds.index(segment) if segment in kinds else -1
        index = found if isinstance(segment, str) else segment
        if not 0 <= index < len(segments):
            known = ", ".join(f"{number} {kind}" for number, kind in enumerate(kinds))
            raise InvalidInput(f"step {step} has no segment {segment!r}: it has {known}")
        motion = segments[index].motion
        if motion is None:
            raise InvalidInput(f"step {step}: the arm stands still in segment {index}, {kinds[index]}")
        return JointTrajectory(
            np.array(motion.times),
            np.array(motion.positions).reshape(len(motion.times), -1),
            np.array(motion.velocities).reshape(len(motion.times), -1),
        )

    def _repr_html_(self) -> str | None:
        """What a notebook shows."""
        return in_cell(self)

    def verify(self, scene: "Scene | None" = None, robot: "Arm | str | None" = None) -> "Verification":
        """Check everything again by other means than it was planned with.

        Args:
            scene: What the plan was made for; without it what needs clouds is not evaluated.
            robot: The arm; found again by what the plan says of it where None.

        Returns:
            Residuals: at most 0 where all is well, `inf` where not evaluated; see `topple.planner.verify`.

        Raises:
            InvalidInput: The plan does not fit the arm or the scene.
        """
        checking: Any = import_module("topple.planner.verify.verify")  # which reads plans, as all of it does
        found: Verification = checking.verify(self, scene, robot)
        return found


def plan_to_json(plan: Plan) -> bytes:
    """Write a plan.

    Args:
        plan: The plan.

    Returns:
        UTF-8 JSON.
    """
    return msgspec.json.encode(plan)


def plan_from_json(data: bytes | str, name: str = "plan.json") -> Plan:
    """Read a plan back.

    Args:
        data: JSON as `plan_to_json` writes it; unknown keys are passed over.
        name: Of the file, for messages.

    Returns:
        The plan, equal to the one written.

    Raises:
        InvalidInput: The text is no plan; the message has the path of the bad field.
    """
    try:
        plan = msgspec.json.decode(data, type=Plan)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"{name} is no plan: {error}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{name} is no JSON: {error}") from error
    if plan.format != FORMAT or plan.format_version != FORMAT_VERSION:
        expected = f"expected {FORMAT} version {FORMAT_VERSION}"
        raise InvalidInput(
            f"{name} is no plan: `$.format` is {plan.format} version {plan.format_version}, {expected}"
        )
    _check(plan, name)
    return plan


def plan_schema() -> dict[str, Any]:
    """The JSON schema (2020-12) of a plan, as `docs/plan.schema.json` has it."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | msgspec.json.schema(Plan)


def _check(plan: Plan, name: str) -> None:
    """What types cannot say: shapes, and steps that refer to steps before them."""
    count = len(plan.joints)
    _matrix(plan.pose_base_to_world, 4, 4, "$.pose_base_to_world", name)
    if len(plan.q_start) != count:
        raise InvalidInput(
            f"{name} is no plan: `$.q_start` has {len(plan.q_start)} values for {count} joints"
        )
    names = {thing.name for thing in plan.objects}
    for thing, pose in plan.poses.items():
        _matrix(pose, 4, 4, f"$.poses.{thing}", name)
        if thing not in names:
            known = ", ".join(sorted(names)) or "nothing"
            raise InvalidInput(f"{name} is no plan: `$.poses` has {thing!r}, its objects are {known}")
    for i, tool in enumerate(plan.arm.tools if plan.arm is not None else []):
        _matrix(tool.pose_tool_to_link, 4, 4, f"$.arm.tools[{i}].pose_tool_to_link", name)
    for i, step in enumerate(plan.steps):
        here = f"$.steps[{i}]"
        _matrix(step.grasp.pose_tool_to_world, 4, 4, f"{here}.grasp.pose_tool_to_world", name)
        _matrix(step.placement.pose_before_to_after, 4, 4, f"{here}.placement.pose_before_to_after", name)
        told = [("object", step.object), ("placement.into", step.placement.into or step.object)]
        told += [(f"attachments[{k}].object", held.object) for k, held in enumerate(step.attachments)]
        for key, which in told:
            if which not in names:
                known = ", ".join(sorted(names)) or "nothing"
                raise InvalidInput(f"{name} is no plan: `{here}.{key}` is {which!r}, its objects are {known}")
        if step.placement.how and step.placement.into is None:
            raise InvalidInput(f"{name} is no plan: `{here}.placement.how` is given, and no `into`")
        for k, held in enumerate(step.attachments):
            _matrix(held.pose_start_to_tool, 4, 4, f"{here}.attachments[{k}].pose_start_to_tool", name)
        for k, before in enumerate(step.after):
            if not 0 <= before < i:
                raise InvalidInput(f"{name} is no plan: `{here}.after[{k}]` is {before}, no earlier step")
        for j, segment in enumerate(step.segments):
            if segment.kind not in KINDS:
                raise InvalidInput(
                    f"{name} is no plan: `{here}.segments[{j}].kind` is {segment.kind!r}, "
                    f"expected one of {', '.join(KINDS)}"
                )
            if segment.motion is not None:
                rows = len(segment.motion.times)
                if rows == 0:
                    raise InvalidInput(f"{name} is no plan: `{here}.segments[{j}].motion.times` is empty")
                _matrix(segment.motion.positions, rows, count, f"{here}.segments[{j}].motion.positions", name)
                _matrix(
                    segment.motion.velocities, rows, count, f"{here}.segments[{j}].motion.velocities", name
                )
    for i, thing in enumerate(plan.objects):
        for key, parts in (("parts", thing.parts), ("whole", thing.whole)):
            for k, part in enumerate(parts):
                _matrix(part, max(len(part), 1), 3, f"$.objects[{i}].{key}[{k}]", name)


def _matrix(matrix: Matrix, rows: int, columns: int, where: str, name: str) -> None:
    if len(matrix) != rows:
        raise InvalidInput(f"{name} is no plan: `{where}` has {len(matrix)} rows, expected {rows}")
    for i, row in enumerate(matrix):
        if len(row) != columns:
            raise InvalidInput(f"{name} is no plan: `{where}[{i}]` has {len(row)} values, expected {columns}")
        if not np.isfinite(row).all():
            raise InvalidInput(f"{name} is no plan: `{where}[{i}]` has a value that is not finite")
