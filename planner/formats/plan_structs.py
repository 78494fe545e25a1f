"""What a plan is made of: frozen structs that are written as JSON and read back equal."""

from typing import Any

import msgspec
import numpy as np

from topple.planner.formats.plan_robot import ArmData, Matrix
from topple.planner.transfer.segments import Segment
from topple.robots.driver import Rows, Samples, Trajectory
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.notebook import in_cell, in_words
from topple.topology.base.values import in_columns

FORMAT = "topple.plan"
FORMAT_VERSION = 1

_LISTS: dict[Any, Any] = {Samples: list[float], Rows: Matrix}


def as_lists(array: Any) -> Any:
    """Write an array, as a hook of msgspec."""
    return array.tolist()


def as_array(kind: Any, value: object) -> FloatArray:
    """Read an array (n,) or (m, n) of a kind that `Trajectory` has, as a hook of msgspec.

    Raises:
        ValueError: It is none; msgspec adds the path of the field.
    """
    try:
        return np.array(msgspec.convert(value, _LISTS[kind]), dtype=np.float64)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error
    except ValueError as error:
        raise ValueError("Expected rows of one length") from error


class GraspData(msgspec.Struct, frozen=True):
    """How an object is held; the pose is that of the tool frame in the world, its pads `width` apart.

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
        how: "on" or "within" that; "lift", "bin", "zone" or "hand-over" where it goes to none of the scene's
            objects, see `away`; empty on a table.
        falls: Whether it is let go though it does not stay there: a drop that was allowed.
    """

    pose_before_to_after: Matrix
    rest: str = ""
    drop: float = 0.0
    into: str | None = None
    how: str = ""
    falls: bool = False

    @property
    def words(self) -> str:
        """The outcome for the object, in a few words."""
        if self.into is not None:
            return f"put down {self.how or 'on'} {self.into}"
        return {
            "lift": "held clear of everything",
            "bin": "put into the bin",
            "zone": "put onto the area that is vouched for",
            "hand-over": "held out",
        }.get(self.how, "put down")


class AwayData(msgspec.Struct, frozen=True):
    """Where objects go that are taken, other than onto what was seen: they are out of the scene then.

    Attributes:
        how: "lift", the hand ends 15 cm clear of everything with the object; "bin", into an open box, one of
            `objects`; "zone", onto a level area, which is one, too; "hand-over", held out at a point.
        pose_to_world: The middle of its underside, or the point.
        size: Along its axes [m].
    """

    how: str
    pose_to_world: Matrix
    size: list[float]


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
        buffer: Whether the object only makes room, and is taken again to its place.
        unseen: Whether the hand comes in through space that no camera saw to be empty: look there before.
    """

    object: str
    action: str
    reason: str
    after: list[int]
    grasp: GraspData
    placement: PlacementData
    segments: list[Segment]
    attachments: list[AttachmentData] = []
    upright: bool = False
    planning_seconds: float = 0.0
    against: list[DependencyData] = []
    fallbacks: list[str] = []
    buffer: bool = False
    unseen: bool = False


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


class PlanData(msgspec.Struct, frozen=True, kw_only=True, dict=True):
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
        clamped: Objects that a fixture keeps where they stand until the hand has closed on them.
        away: Where objects go that are taken; null where that is free places on what was seen.
        assumptions: What was assumed and not seen.
        certified: Whether every motion was proven free between its samples too.
        seconds: Duration of the motions [s].
        planning_seconds: What it took to find the plan.
        tried: What was dropped on the way, with counts.
        arm: The arm with its tools, and where its URDF is; null in plans of older versions.
        poses: Places of objects in the end, where they were given: by name, the rigid transform in the
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
    clamped: list[str] = []
    away: AwayData | None = None

    def trajectory(self, step: int, segment: int | str) -> Trajectory:
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
        kinds = [str(part.kind) for part in segments]
        found = kinds.index(segment) if segment in kinds else -1
        index = found if isinstance(segment, str) else segment
        if not 0 <= index < len(segments):
            known = ", ".join(f"{number} {kind}" for number, kind in enumerate(kinds))
            raise InvalidInput(f"step {step} has no segment {segment!r}: it has {known}")
        way = segments[index].motion
        if way is None:
            raise InvalidInput(f"step {step}: the arm stands still in segment {index}, {kinds[index]}")
        return way

    def heading(self) -> list[str]:
        """The goal with number, duration and proof of the motions, and where the arm stands: two lines."""
        x, y, z = (row[3] for row in self.pose_base_to_world[:3])
        proven = "every motion certified" if self.certified else "NOT every motion certified"
        count = f"{len(self.steps)} step{'' if len(self.steps) == 1 else 's'}"
        where = "searched" if self.base_searched else "given"
        return [
            f"{self.goal}, {count}, {self.seconds:.1f} s of motion, {proven}",
            f"{self.robot} stands at {x:.3f} {y:.3f} {z:.3f} m ({where})",
        ]

    def rows(self) -> list[tuple[str, ...]]:
        """A row for each step: number, action, object, reason, grasp, what it comes after, motion [s]."""
        rows: list[tuple[str, ...]] = []
        for number, step in enumerate(self.steps, start=1):
            seconds = sum(part.seconds for part in step.segments)
            deed, after = (
                (step.action, step.object, step.reason, step.grasp.kind),
                (self.steps[i] for i in step.after),
            )
            rows.append((str(number), *deed, ", ".join(other.object for other in after), f"{seconds:.1f}"))
        return rows

    def __str__(self) -> str:
        """Format as `topple plan` prints: the goal, where the arm stands, a line for each step."""
        heading, rows = in_words(vars(self).get("scene"), (self.heading(), [row[1:] for row in self.rows()]))
        return "\n".join([*heading, *in_columns([(str(n), *row) for n, row in enumerate(rows, start=1)])])

    def _repr_html_(self) -> str | None:
        """Show the plan in a notebook."""
        return in_cell(self)
