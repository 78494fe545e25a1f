"""A gripper as searches for grasps, rankings and verdicts see it: the planner's half of each kind."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from topple.planner.grasp.cells import Region, swept
from topple.planner.grasp.surface import Surface, surface_in
from topple.planner.grasp.surroundings import Dropped, Surroundings, surroundings
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, HAND_REACH, WAY_LAYERS, GraspTolerances
from topple.robots.arm.gripper import Tool, ToolState
from topple.robots.arm.tolerances import FINGER_SLABS, GRAVITY
from topple.robots.collision.prisms import Prism, fill_prisms, prisms
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.base.plugins import Table
from topple.topology.geometry.hull import Hull

if TYPE_CHECKING:
    from topple.planner.grasp.grasp import Grasp
    from topple.planner.grasp.room import Room
    from topple.robots.arm.arm import Arm
    from topple.topology.situation.situation import Situation

ACROSS = freeze(
    np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
)
"""(4, 4) a quarter turn of the hand about its approach."""


@dataclass(frozen=True, eq=False)
class Sought:
    """What a search for grasps looks at.

    Attributes:
        name: The object.
        cloud: (N, 3) its points, unthinned [m].
        surface: The same as a surface, with what is inferred of it.
        solid: What it fills, in convex parts.
        around: Points of everything else nearby, and the ground.
        up: (3,) unit vector against gravity.
        out: (3,) unit vector along which it goes: fingers come in against it.
        tolerances: Clearances and limits.
        dropped: Takes down what is left out and why.
        enough: So many grasps that brush by nothing are enough.
    """

    name: str
    cloud: FloatArray
    surface: Surface
    solid: Sequence[Hull]
    around: Surroundings
    up: FloatArray
    out: FloatArray
    tolerances: GraspTolerances
    dropped: Dropped
    enough: float = np.inf

    @classmethod
    def of(
        cls,
        name: str,
        situation: "Situation",
        dropped: Dropped | None = None,
        enough: float = np.inf,
        out: FloatArray | None = None,
    ) -> "Sought":
        """Look for grasps of an object in a situation; what was given of its weight and friction counts."""
        scene, up = situation.scene, situation.up
        around = surroundings(name, scene, up)
        surface = surface_in(name, situation, around)
        given = scene.centres.get(name, surface.centre)
        surface = replace(surface, mass=scene.masses.get(name), centre=given)
        # pads of rubber have a coefficient of 1, and the product is the object's own
        friction = scene.friction.get(name, GRASP_TOLERANCES.friction)
        tolerances = replace(GRASP_TOLERANCES, friction=friction)
        solid = [Hull.of(part) for part in situation.solids[name]]
        dropped = Dropped() if dropped is None else dropped
        out = situation.way_out(name) if out is None else out
        return cls(name, scene.clouds[name], surface, solid, around, up, out, tolerances, dropped, enough)


@dataclass(frozen=True, eq=False)
class Shape(ABC):
    """A tool's hand about where it takes hold (z approach, y closing), and what it takes: one file a kind.

    The other half is `topple.robots.arm.gripper.Gripper`. What is not said here is that of a tool which takes
    by a single face, is round, and stays as it is while it holds.

    Attributes:
        tool: The arm's tool.
        body: Prisms of all of the hand but what takes hold and moves for that.
        kind: What its grasps are called.
        where: Where it holds, in words.
        holder: What holds, in words.
        spare: Whether it is tried only where no other tool is sure to hold.
    """

    tool: Tool
    body: tuple[Prism, ...]

    kind: ClassVar[str]
    where: ClassVar[str]
    holder: ClassVar[str]
    spare: ClassVar[bool] = False

    @property
    def links(self) -> tuple[str, ...]:
        """Links that may be next to what it takes."""
        return self.tool.links

    # -- what it finds, and what that holds

    @abstractmethod
    def grasps(self, sought: Sought) -> list["Grasp"]:
        """Find grasps of an object, in the world; what is left out is noted. Deterministic."""

    @abstractmethod
    def score(self, terms: Mapping[str, float]) -> float:
        """Put the terms (0..1) of one of its grasps together, to 0..1."""

    @abstractmethod
    def max_weight(self, friction: float | None) -> float:
        """Weight [N] that it lifts at most, at a coefficient of friction; None where that was not tried."""

    @abstractmethod
    def load(
        self, weight: float, centre: FloatArray, down: FloatArray, width: float, own: FloatArray
    ) -> float:
        """How much of what it holds a weight takes, at the friction that is counted on.

        Args:
            weight: In [N].
            centre: (3,) of mass, from where it takes hold, in its axes [m].
            down: (3,) unit vector of gravity in its axes.
            width: Of what is between its pads [m].
            own: (N, 3) points of the object in its axes [m].

        Returns:
            The share; above 1 the object turns, slips or comes off.
        """

    def too_heavy(self, mass: float | None, friction: float | None) -> str:
        """Why it is known not to lift a mass [kg]; empty where it may, as of a guessed weight, None."""
        heavy = mass is not None and GRAVITY * mass > self.max_weight(friction)
        return f"{mass:g} kg are more than {self.holder}" if heavy else ""

    def widened(self, grasps: Sequence["Grasp"], sought: Sought) -> list["Grasp"]:
        """Grasps with the hand as far open as there is room: the object is larger than it looks."""
        return list(grasps)

    def turns(self, grasp: "Grasp") -> list["Grasp"]:
        """A grasp with the hand turned about its approach in all ways that hold the same."""
        across = replace(grasp, pose_tool_to_world=grasp.pose_tool_to_world @ ACROSS)
        return [grasp, grasp.turn(), across, across.turn()]

    # -- how the hand stands

    def ready(self, grasp: "Grasp") -> ToolState:
        """On the way in."""
        return self.tool.ready

    def closed(self, grasp: "Grasp") -> ToolState:
        """With the object."""
        return self.ready(grasp)

    def released(self, grasp: "Grasp", into: str | None, up: FloatArray) -> ToolState:
        """After letting go, in a vessel or not."""
        return self.ready(grasp)

    # -- where it is

    def filled(self, grasps: Sequence["Grasp"], length: float, layers: int) -> FloatArray:
        """Points (G, N, 3) of what has to be seen on the way in, some metres back from the front [m]."""
        return np.tile(fill_prisms(self.body, length, layers), (len(grasps), 1, 1))

    def stand_in(self, grasps: Sequence["Grasp"], solid: Sequence[Hull]) -> BoolArray:
        """(G,) whose hands would stand in what their object fills."""
        return np.zeros(len(grasps), dtype=np.bool_)

    @abstractmethod
    def holds(self, count: int) -> Region:
        """Where something has to be that `count` hands hold."""

    def sweeps(self, openings: FloatArray) -> tuple[list[Region], list[Region]]:
        """Regions that open hands (P,) sweep on their way in, and those where their own object may be."""
        return [swept(len(openings), *prism.x, *prism.y, prism.front) for prism in self.body], []

    def below(self, poses: FloatArray, up: FloatArray, floors: FloatArray) -> BoolArray:
        """Whether fingers at poses (P, 4, 4) would go below the ground, its height (P,) [m]."""
        return np.zeros(len(poses), dtype=np.bool_)

    def measured(self, grasp: "Grasp", room: "Room") -> tuple["Grasp", list[str], Callable[[], str]]:
        """A grasp as the hand would make it, what is against that, and what keeps it from holding, or ""."""
        within = room.within(grasp.tool, grasp.pose_tool_to_world[None])
        nothing = bool(within[0, room.scene.movable.index(grasp.object)] <= GRASP_TOLERANCES.stray_points)
        opened = replace(grasp, opening=grasp.opening or self.tool.ready.opening)
        return opened, [f"nothing of {grasp.object} is {self.where}"] * nothing, str


GRIPPERS: Table[Callable[["Arm"], Shape]] = Table(
    "topple.grippers",
    "gripper",
    {
        "suction": "topple.planner.grasp.suction:cup_shape",
        "fingers": "topple.planner.grasp.jaw:hand_shape",
    },
    Shape,
)
"""What measures the hand of an arm's tool, by the tool's name; other packages add theirs."""


@lru_cache(maxsize=16)
def shapes_of(arm: "Arm") -> Mapping[str, Shape]:
    """The hands of an arm's tools by their names, those that are spare last."""
    found = [GRIPPERS[name](arm) for name in arm.tools]
    return {shape.tool.name: shape for shape in sorted(found, key=lambda shape: shape.spare)}


def coming_unseen(
    grasps: Sequence["Grasp"], situation: "Situation", shapes: Mapping[str, Shape]
) -> BoolArray:
    """Tell whose hands come in through space that no camera saw to be empty.

    Asked is where the fingers are at the grasp and on their straight way there, or what is around the cup.
    Where both fingers are seen to be free, what is between them is bounded on both sides.

    Args:
        grasps: In the world.
        situation: What was seen, and what was moved since.
        shapes: The hands of the tools, by name.

    Returns:
        (G,) whether they do; nobody does where no camera is known.
    """
    found, tolerances = np.zeros(len(grasps), dtype=np.bool_), GRASP_TOLERANCES
    for tool, shape in shapes.items():
        rows = [row for row, grasp in enumerate(grasps) if grasp.tool == tool]
        if not rows:
            continue
        some = [grasps[row] for row in rows]
        local = shape.filled(some, tolerances.way, WAY_LAYERS)
        places = in_world(some, local)
        seen = situation.shown(places.reshape(-1, 3), tolerances.into_solid).reshape(places.shape[:2])
        found[rows] = np.count_nonzero(~seen, axis=1) > tolerances.stray_points
    return found


def in_world(grasps: Sequence["Grasp"], points: FloatArray) -> FloatArray:
    """Points (G, N, 3) of the hands of grasps, from their tools' frames [m]."""
    poses = np.stack([grasp.pose_tool_to_world for grasp in grasps])
    return points @ poses[:, :3, :3].swapaxes(1, 2) + poses[:, None, :3, 3]


def hand_bodies(arm: "Arm", tool: str, state: ToolState) -> list[tuple[str, FloatArray]]:
    """Convex bodies of a hand around one of its tool frames.

    Args:
        arm: The arm.
        tool: Name of the tool.
        state: How the hand stands.

    Returns:
        (link name, (V, 3) vertices in the tool frame [m]) for every body that can meet what is grasped.
    """
    q = np.asarray(arm.home, dtype=np.float64)[None]
    poses = arm.forward(q, state)[0]
    to_tool = np.linalg.inv(arm.tool_pose(q, tool)[0])
    found: list[tuple[str, FloatArray]] = []
    last = len(arm.joints)  # links before the last joint are near the tool in some states only
    for link, frame, pose, parts in zip(arm.links, arm.frame_of_link, poses, arm.parts, strict=True):
        for part in parts if frame == last else ():
            vertices = part @ (to_tool @ pose)[:3, :3].T + (to_tool @ pose)[:3, 3]
            if vertices[:, 2].max() > -HAND_REACH and np.linalg.norm(vertices, axis=1).min() < HAND_REACH:
                found.append((link, vertices))
    return found


def body_of(arm: "Arm", tool: Tool) -> tuple[Prism, ...]:
    """Prisms of the hand about one of its tools, ready for an object, but of the links that take hold."""
    bodies = hand_bodies(arm, tool.name, tool.ready)
    apart = (part for link, part in bodies if link not in tool.gripper.touching)
    return tuple(prism for part in apart for prism in prisms(part, FINGER_SLABS))
