"""An arm: joints and limits, where its links are for many states at once, which states reach a pose."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.gripper import FINGERS, Gripper, Tool, ToolState, tools_of
from topple.robots.arm.gripper_file import GripperFile
from topple.robots.arm.inverse import distinct, solve
from topple.robots.arm.jaw import ParallelJaw
from topple.robots.arm.kinematics import Chain, driven_joints, joint_value, pose_of_joint
from topple.robots.arm.tolerances import STARTS
from topple.robots.arm.urdf import Joint, Model, read_urdf
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.base.checks import numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points

CHUNK = 512  # targets asked about at once: their states and frames are some 100 MB


@dataclass(frozen=True, eq=False)
class Arm:
    """A serial arm with a hand, made by `Arm.from_urdf` or `topple.robots.catalog.robot`.

    Attributes:
        name: Name for reports.
        urdf: The file to load into PyBullet.
        joints: Names of the driven joints, base first; a state q has one value for each.
        lower: (n,) lower joint limits in [rad] or [m].
        upper: (n,) upper joint limits.
        velocity: (n,) velocity limits in [rad/s] or [m/s].
        acceleration: (n,) acceleration limits in [rad/s2] or [m/s2].
        home: (n,) a state to rest in.
        links: Names of all links, base first.
        tools: The tools by name: "fingers", "suction".
        model: The tree as read from the file.
        chain: The driven joints as a chain.
        source: The file the arm is described by; `urdf` may be made from it.
        gripper: What was said of its hand beside that file, if anything.
        assumptions: What neither says and was assumed, a sentence each.
        catalog: Whether `topple.robots.robot` knows it by its name.
        apart: Pairs of names of links that are not checked against each other.
        payload: What it is rated to carry besides its hand [kg]; infinite where nobody says.
    """

    name: str
    urdf: Path
    joints: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    home: FloatArray
    links: tuple[str, ...]
    tools: Mapping[str, Tool]
    model: Model
    chain: Chain
    source: Path = Path()
    gripper: GripperFile | None = None
    assumptions: tuple[str, ...] = ()
    catalog: bool = False
    apart: frozenset[frozenset[str]] = frozenset()
    payload: float = np.inf
    _offsets: dict[ToolState, FloatArray] = field(default_factory=dict[ToolState, FloatArray], repr=False)

    @classmethod
    def from_urdf(
        cls,
        path: str | Path,
        tool_frame: str,
        gripper: Gripper | Mapping[str, Tool] | None = None,
        *,
        name: str | None = None,
        limits: tuple[Sequence[float], Sequence[float]] | None = None,
        velocity: Sequence[float] | None = None,
        acceleration: Sequence[float] | float = 10.0,
        home: Sequence[float] | None = None,
        source: Path | None = None,
    ) -> "Arm":
        """Read an arm.

        Args:
            path: The URDF.
            tool_frame: Link that carries the tool; the movable joints between it and the root are the arm's.
                With a gripper given, its frame is the tool frame: z out of the hand, y the closing
                direction.
            gripper: The gripper, or the tools by name where their frames are offset from links.
            name: Name for reports; the file's otherwise.
            limits: Lower and upper joint limits that replace the file's, in [rad] or [m].
            velocity: Velocity limits that replace the file's.
            acceleration: Acceleration limits, which URDF cannot state, in [rad/s2].
            home: A state to rest in; the middle of the limits otherwise.
            source: The file that the URDF was made from; itself otherwise.

        Returns:
            The arm.

        Raises:
            InvalidInput: If meshes are missing, joints have no limits or no velocity, or moving joints remain
                that neither the arm nor the gripper drives; the message names them.
        """
        model = read_urdf(path)
        named = (source or model.path).name
        joints, before = driven_joints(model, tool_frame, named)
        follows = [joint.name for joint in joints if joint.mimic is not None]
        if follows:
            raise InvalidInput(
                f"{named}: the arm's joints {', '.join(follows)} mimic others: such linkages are "
                "not supported"
            )
        tools = tools_of(gripper, tool_frame)
        _refuse_undriven(model, joints, tools, named)
        n = len(joints)
        lower = np.array([j.lower for j in joints] if limits is None else limits[0], dtype=float)
        upper = np.array([j.upper for j in joints] if limits is None else limits[1], dtype=float)
        if limits is None:
            unlimited = [joint.name for joint in joints if not joint.limited]
            if unlimited:
                raise InvalidInput(f"{named}: joints without limits: {', '.join(unlimited)}")
        speeds = np.array([j.velocity for j in joints] if velocity is None else velocity, dtype=float)
        slow = [joint.name for joint, speed in zip(joints, speeds, strict=True) if not speed > 0]
        if slow:
            raise InvalidInput(f"{named}: joints without a velocity limit: {', '.join(slow)}")
        return cls(
            name or model.name,
            model.path,
            tuple(joint.name for joint in joints),
            freeze(lower),
            freeze(upper),
            freeze(speeds),
            freeze(np.broadcast_to(np.asarray(acceleration, dtype=float), (n,))),
            freeze((lower + upper) / 2 if home is None else home),
            tuple(model.links),
            tools,
            model,
            Chain.of(joints, before, lower, upper),
            model.path if source is None else source,
        )

    @property
    def jaw(self) -> ParallelJaw | None:
        """The fingers, if the hand has any."""
        return next((jaw for tool in self.tools.values() if (jaw := tool.gripper.jaw) is not None), None)

    @property
    def cup(self) -> SuctionCup | None:
        """The suction cup, if the hand has one."""
        return next((cup for tool in self.tools.values() if (cup := tool.gripper.cup) is not None), None)

    @property
    def hand_limits(self) -> ToolState:
        """How far the hand's parts go."""
        ends = [tool.gripper.limits for tool in self.tools.values()]
        extension = max((end.cup_extension for end in ends), default=0.0)
        return ToolState(max((end.opening for end in ends), default=0.0), extension)

    @property
    def open_hand(self) -> ToolState:
        """Fingers fully open, the cup as it is on the way."""
        return self.on_the_way(self.hand_limits.opening)

    def on_the_way(self, opening: float) -> ToolState:
        """The hand between objects: the fingers at an opening in [m], the cup drawn in where it can be."""
        return ToolState(opening, max((tool.gripper.stowed for tool in self.tools.values()), default=0.0))

    @property
    def parts(self) -> tuple[tuple[FloatArray, ...], ...]:
        """Per link the (V, 3) vertices of its convex collision parts in the link frame, one an element."""
        return tuple(self.model.links[link].parts for link in self.links)

    @cached_property
    def frame_of_link(self) -> tuple[int, ...]:
        """Per link the index of the chain frame it moves with: 0 for the base, k behind joint k."""
        driven = {joint: k + 1 for k, joint in enumerate(self.joints)}
        frames: dict[str, int] = {self.links[0]: 0}
        for link in self.links[1:]:
            joint = self.model.joints[link]
            frames[link] = driven.get(joint.name, frames[joint.parent])
        return tuple(frames[link] for link in self.links)

    @cached_property
    def self_pairs(self) -> tuple[tuple[int, int], ...]:
        """Pairs of links, as indices into `links`, that can hit each other; found by sampling states."""
        from topple.robots.arm.self_collision import colliding_pairs

        hands = dict.fromkeys([self.open_hand, *(tool.ready for tool in self.tools.values())])
        return tuple(
            sorted(
                {
                    pair
                    for hand in hands
                    for pair in colliding_pairs(
                        self.chain, self.parts, self.frame_of_link, self.offsets(hand), self.home
                    )
                    if frozenset((self.links[pair[0]], self.links[pair[1]])) not in self.apart
                }
            )
        )

    def offsets(self, state: ToolState) -> FloatArray:
        """Poses of all links in the chain frames they move with.

        Args:
            state: How the hand stands.

        Returns:
            (L, 4, 4) read-only.
        """
        if state not in self._offsets:
            self._offsets[state] = freeze(self._offsets_at(self.hand_values(state)))
        return self._offsets[state]

    def joint_values(self, q: FloatArray, state: ToolState) -> dict[str, float]:
        """Values of all moving joints by name: the arm's at q (n,), the hand's, and those that mimic them."""
        values = dict(zip(self.joints, (float(v) for v in q), strict=True)) | self.hand_values(state)
        moving = [joint for joint in self.model.joints.values() if joint.kind != "fixed"]
        return {joint.name: joint_value(joint, values) for joint in moving}

    def hand_values(self, state: ToolState) -> dict[str, float]:
        """Values of the hand's driven joints by name."""
        values: dict[str, float] = {}
        for tool in self.tools.values():
            values |= tool.gripper.values(state)
        return values

    def _offsets_at(self, values: Mapping[str, float]) -> FloatArray:
        index = {link: i for i, link in enumerate(self.links)}
        offsets = np.tile(np.eye(4), (len(self.links), 1, 1))
        for i, link in enumerate(self.links[1:], start=1):
            joint = self.model.joints[link]
            if joint.name not in self.joints:
                offsets[i] = offsets[index[joint.parent]] @ pose_of_joint(joint, joint_value(joint, values))
        return offsets

    def forward(self, q: FloatArray, state: ToolState | None = None) -> FloatArray:
        """Where the links are.

        Args:
            q: (m, n) or (n,) joint values in [rad] or [m].
            state: How the hand stands; fully open if not given.

        Returns:
            (m, L, 4, 4) poses of the links in the base.
        """
        frames = self.chain.frames(np.atleast_2d(q))
        return np.matmul(frames[:, list(self.frame_of_link)], self.offsets(state or self.open_hand))

    def bodies(
        self, q: ArrayLike, pose_base_to_world: FloatArray, state: ToolState | None = None
    ) -> tuple[FloatArray, ...]:
        """Convex parts (V, 3) of all links in the world [m], at joint values (n,) in [rad] or [m].

        Where `state` is not given the hand is both open and shut.

        Raises:
            InvalidInput: If there are not as many finite values as joints.
        """
        values = numeric(q, "q")
        if values.shape != (len(self.joints),) or not np.isfinite(values).all():
            raise InvalidInput(
                f"{self.name} stands at {values.tolist()}: expected {len(self.joints)} finite joint values, "
                f"of {', '.join(self.joints)}"
            )
        hands = (self.open_hand, self.on_the_way(0.0)) if state is None else (state,)
        poses = [pose_base_to_world @ pose for hand in hands for pose in self.forward(values, hand)[0]]
        links = zip(poses, self.parts * len(hands), strict=True)
        return tuple(move_points(part, pose) for pose, parts in links for part in parts)

    def tool(self, name: str) -> Tool:
        """The tool called `name`.

        Raises:
            InvalidInput: If the arm has no such tool; the message lists what it has.
        """
        if name not in self.tools:
            raise InvalidInput(f"{self.name} has no tool {name!r}; it has {', '.join(self.tools) or 'none'}")
        return self.tools[name]

    def tool_to_flange(self, tool: str) -> FloatArray:
        """The (4, 4) pose of a tool in the last chain frame."""
        link = self.tool(tool).link
        return self.offsets(self.open_hand)[self.links.index(link)] @ self.tools[tool].pose_tool_to_link

    def tool_pose(self, q: FloatArray, tool: str = FINGERS) -> FloatArray:
        """Where a tool is.

        Args:
            q: (m, n) or (n,) joint values.
            tool: Name of the tool.

        Returns:
            (m, 4, 4) pose_tool_to_base.
        """
        return np.matmul(self.chain.frames(np.atleast_2d(q))[:, -1], self.tool_to_flange(tool))

    def inverse(
        self,
        pose_tool_to_base: FloatArray,
        tool: str = FINGERS,
        *,
        seeds: int = 64,
        rng: np.random.Generator | None = None,
        near: FloatArray | None = None,
    ) -> list[FloatArray]:
        """States that bring a tool to a pose.

        Args:
            pose_tool_to_base: (4, 4) or (k, 4, 4) targets.
            tool: Name of the tool.
            seeds: Random starts for each target, the home state among them.
            rng: Where the starts are drawn from; a fixed seed if not given.
            near: (n,) a state to begin with; solutions come ordered by the largest joint change from it (from
                the home state otherwise).

        Returns:
            For each target the (s, n) distinct solutions within the joint limits; (0, n) where none was
            found.
        """
        targets: FloatArray = np.asarray(pose_tool_to_base, dtype=float).reshape(-1, 4, 4)
        start = self.home if near is None else near
        starts = self._starts(len(targets), seeds, start, rng or np.random.default_rng(0))
        held = self.tool_to_flange(tool)
        solutions, owner = solve(self.chain, targets @ np.linalg.inv(held), starts, tool_point=held[:3, 3])
        result: list[FloatArray] = []
        for k in range(len(targets)):
            found = solutions[owner == k]
            result.append(distinct(found[np.argsort(np.abs(found - start).max(axis=1), kind="stable")]))
        return result

    def reaches(self, poses_tool_to_base: FloatArray, tool: str = FINGERS, *, seeds: int = 64) -> BoolArray:
        """Whether `inverse` has a state for any of a few poses, found without looking for all of them.

        Args:
            poses_tool_to_base: (k, a, 4, 4): k targets, each in a ways that will do.
            tool: Name of the tool.
            seeds: Random starts for each way, the home state among them.

        Returns:
            (k,) whether there is a state within the joint limits.
        """
        targets: FloatArray = np.asarray(poses_tool_to_base, dtype=float)
        ways, rng = targets.shape[1], np.random.default_rng(0)
        held = self.tool_to_flange(tool)
        flanges = targets @ np.linalg.inv(held)
        found = np.zeros(len(targets), dtype=np.bool_)
        for first in range(0, len(targets), CHUNK):
            some = flanges[first : first + CHUNK]
            starts = self._starts(len(some) * ways, seeds, self.home, rng).reshape(len(some), ways, seeds, -1)
            left = np.flatnonzero((np.linalg.norm(some[..., :3, 3], axis=2) <= self.chain.reach).any(axis=1))
            for begin, end in pairwise((0, *(count for count in STARTS if count < seeds), seeds)):
                if len(left) == 0:
                    break
                tries = starts[left, :, begin:end].reshape(len(left) * ways, end - begin, -1)
                _, owner = solve(self.chain, some[left].reshape(-1, 4, 4), tries, tool_point=held[:3, 3])
                found[first + left[owner // ways]] = True
                left = left[~found[first + left]]
        return found

    def _starts(self, count: int, seeds: int, first: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Where searches for `count` targets start: (count, seeds, n) states, the same one first."""
        starts = rng.uniform(self.lower, self.upper, (count, seeds, len(self.joints)))
        starts[:, :1] = first
        return starts


@dataclass(frozen=True, eq=False)
class Station:
    """An arm as it stands: where, (4, 4), and with which joint values (n,) [rad] or [m]."""

    arm: Arm
    pose_base_to_world: FloatArray
    q: FloatArray


def _refuse_undriven(model: Model, joints: tuple[Joint, ...], tools: Mapping[str, Tool], named: str) -> None:
    driven = {joint.name for joint in joints}
    for tool in tools.values():
        driven |= {model.joint(name).name for name in tool.gripper.values(tool.ready)}
    left = [
        joint.name
        for joint in model.joints.values()
        if joint.kind != "fixed"
        and joint.name not in driven
        and not (joint.mimic and joint.mimic.joint in driven)
    ]
    if left:
        raise InvalidInput(
            f"{named}: nothing drives the joints {', '.join(left)}; name them in the gripper ([jaw] of a "
            "gripper file), or name the arm's there ([arm] joints), and these hold still"
        )
