"""A plan as a recording of ROS 2: trajectories, hand commands and objects, at the times of the plan."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.formats.plan_structs import Step
from topple.planner.planning.plan_format import Plan
from topple.planner.transfer.segments import Segment
from topple.robots.collision.convex import hull_of
from topple.robots.driver import Trajectory
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import NotInstalled

WORLD, BASE = "world", "base"
HAND_SECONDS = 1.0  # [s] a hand is given to close or open: a plan does not time it
_SECOND = 1_000_000_000  # [ns]

# What rosbags does not know of itself, as in moveit_msgs, object_recognition_msgs and control_msgs of ROS 2
_TYPES = {
    "object_recognition_msgs/msg/ObjectType": "string key\nstring db",
    "control_msgs/msg/GripperCommand": "float64 position\nfloat64 max_effort",
    "moveit_msgs/msg/CollisionObject": (
        "std_msgs/Header header\ngeometry_msgs/Pose pose\nstring id\n"
        "object_recognition_msgs/ObjectType type\nshape_msgs/SolidPrimitive[] primitives\n"
        "geometry_msgs/Pose[] primitive_poses\nshape_msgs/Mesh[] meshes\n"
        "geometry_msgs/Pose[] mesh_poses\nshape_msgs/Plane[] planes\n"
        "geometry_msgs/Pose[] plane_poses\nstring[] subframe_names\n"
        "geometry_msgs/Pose[] subframe_poses\nbyte ADD=0\nbyte REMOVE=1\nbyte APPEND=2\n"
        "byte MOVE=3\nbyte operation"
    ),
}


def recording(plan: Plan) -> bytes:
    """Write the plan as messages, each at its time from the start of the plan on.

    At the start: `/tf_static` (world to base), a `moveit_msgs/CollisionObject` for each object on
    `/collision_object` (convex parts as meshes in the world), and the order and its dependencies as JSON on
    `/topple/order`. Then for each segment: a `trajectory_msgs/JointTrajectory` on `/joint_trajectory`, and
    a `control_msgs/GripperCommand` on `/gripper_command` where the hand changes (`position` is the distance
    of the pads in [m], or the cup's extension where it holds by a cup), and what it is for as JSON on
    `/topple/segment`.

    Args:
        plan: The plan.

    Returns:
        The bytes of the `.mcap` file.

    Raises:
        NotInstalled: The package rosbags is not there.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "plan"
        with _Recording(path) as bag:
            bag.send("/tf_static", bag.make("tf2_msgs/TFMessage", [_base(bag, plan)]))
            for thing in plan.objects:
                bag.send("/collision_object", _object(bag, thing.name, thing.parts))
            edges = [{"first": each.first, "then": each.then} for each in plan.dependencies]
            bag.say("/topple/order", {"goal": plan.goal, "order": plan.order, "dependencies": edges})
            command: float | None = None
            for step in plan.steps:
                for segment in step.segments:
                    command = _send(bag, plan, step, segment, command)
        return (path / "plan.mcap").read_bytes()


def _send(bag: "_Recording", plan: Plan, step: Step, segment: Segment, command: float | None) -> float:
    """A segment; the hand is brought to its place before the motion. Returns where the hand is then."""
    about = {"object": step.object, "action": step.action, "kind": segment.kind, "tool": segment.tool}
    bag.say("/topple/segment", {**about, "holding": segment.holding})
    hand = segment.hand.opening if step.grasp.width else segment.hand.cup_extension
    if hand != command:
        bag.send("/gripper_command", bag.make("control_msgs/GripperCommand", hand, 0.0))
        bag.seconds += HAND_SECONDS
    if segment.motion is not None:
        bag.send("/joint_trajectory", _trajectory(bag, plan.joints, segment.motion))
        bag.seconds += segment.seconds
    return hand


def _trajectory(bag: "_Recording", joints: list[str], motion: Trajectory) -> Any:
    none = np.empty(0)
    points = [
        bag.make(
            "trajectory_msgs/JointTrajectoryPoint",
            np.array(at),
            np.array(speed),
            none,
            none,
            bag.make("builtin_interfaces/Duration", *divmod(round(time * _SECOND), _SECOND)),
        )
        for time, at, speed in zip(motion.times, motion.positions, motion.velocities, strict=True)
    ]
    return bag.make("trajectory_msgs/JointTrajectory", bag.header(BASE), joints, points)


def _object(bag: "_Recording", name: str, parts: list[list[list[float]]]) -> Any:
    meshes: list[Any] = []
    for part in parts:
        vertices, faces = hull_of(np.array(part))
        corners = [bag.make("geometry_msgs/Point", *map(float, vertex)) for vertex in vertices]
        triangles = [bag.make("shape_msgs/MeshTriangle", face.astype(np.uint32)) for face in faces]
        meshes.append(bag.make("shape_msgs/Mesh", triangles, corners))
    kind = bag.make("object_recognition_msgs/ObjectType", "", "")
    here = [bag.pose(np.eye(4)) for _ in meshes]
    return bag.make(
        "moveit_msgs/CollisionObject",
        bag.header(WORLD), bag.pose(np.eye(4)), name, kind, [], [], meshes, here, [], [], [], [], operation=0,
    )  # fmt: skip


def _base(bag: "_Recording", plan: Plan) -> Any:
    placed = bag.pose(np.array(plan.pose_base_to_world))
    at = placed.position
    shift = bag.make("geometry_msgs/Vector3", at.x, at.y, at.z)
    transform = bag.make("geometry_msgs/Transform", shift, placed.orientation)
    return bag.make("geometry_msgs/TransformStamped", bag.header(WORLD), BASE, transform)


class _Recording:
    """A recording to be written, and the time in it [s]."""

    def __init__(self, path: Path) -> None:
        try:
            from rosbags.rosbag2 import StoragePlugin, Writer
            from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        except ModuleNotFoundError as error:
            raise NotInstalled("recordings of ROS need rosbags", "ros") from error
        self.seconds = 0.0
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        for name, text in _TYPES.items():
            self._store.register(get_types_from_msg(text, name))
        self._bag = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> "_Recording":
        self._bag.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._bag.close()

    def make(self, kind: str, *values: Any, **named: Any) -> Any:
        """A message of a type, such as "geometry_msgs/Point"."""
        return self._store.types[kind.replace("/", "/msg/")](*values, **named)

    def header(self, frame: str) -> Any:
        """Of a message of now."""
        now = divmod(round(self.seconds * _SECOND), _SECOND)
        return self.make("std_msgs/Header", self.make("builtin_interfaces/Time", *now), frame)

    def pose(self, pose: FloatArray) -> Any:
        """Of a matrix (4, 4)."""
        turn = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
        place = self.make("geometry_msgs/Point", *pose[:3, 3].tolist())
        return self.make("geometry_msgs/Pose", place, self.make("geometry_msgs/Quaternion", *turn))

    def say(self, topic: str, document: dict[str, Any]) -> None:
        """Send JSON as text."""
        self.send(topic, self.make("std_msgs/String", json.dumps(document)))

    def send(self, topic: str, message: Any) -> None:
        """Record a message as of now."""
        kind = message.__msgtype__
        if topic not in self._connections:
            self._connections[topic] = self._bag.add_connection(topic, kind, typestore=self._store)
        data = self._store.serialize_cdr(message, kind)
        self._bag.write(self._connections[topic], round(self.seconds * _SECOND), data)
