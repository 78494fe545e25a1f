"""The arm a plan was made for, as data: what a controller has to know of it, and how to find it again."""

import hashlib
import importlib.util
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import msgspec

from topple.planner.tolerances import ALIKE
from topple.robots.arm.gripper import Tool
from topple.robots.arm.gripper_file import GripperFile
from topple.robots.arm.tolerances import CUP_FRICTION
from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm

Matrix = list[list[float]]


class JawData(msgspec.Struct, frozen=True, omit_defaults=True):
    """A parallel jaw.

    Attributes:
        joints: Joints that move the fingers.
        links: Links of the fingers.
        openings: (k,) distances of the pads [m], increasing.
        joint_values: (k, len(joints)) joint values at these openings [m] or [rad].
        force: Largest closing force [N].
        pad_size: Extent of a pad along the tool's x and z [m].
        friction: Of the pads.
        arc: (k,) how far along the tool's z the pads are at these openings [m]: a grasp's pose is theirs at
            its width. Left out where they slide straight.
    """

    joints: list[str]
    links: list[str]
    openings: list[float]
    joint_values: Matrix
    force: float
    pad_size: tuple[float, float]
    friction: float
    arc: list[float] = []
    beside: float | None = None


class CupData(msgspec.Struct, frozen=True):
    """A suction cup.

    Attributes:
        link: Link of the cup.
        joint: Sliding joint that carries it; null where it stands fixed.
        stroke: Travel of that joint [m].
        radius: Of the lip [m].
        force: Pull at which it lets go [N].
        lip_depth: Unevenness under the lip that its rubber bridges [m].
        friction: Between the lip and what it takes.
    """

    link: str
    joint: str | None
    stroke: float
    radius: float
    force: float
    lip_depth: float
    friction: float = CUP_FRICTION


class ToolData(msgspec.Struct, frozen=True):
    """A tool: its frame has z out of the hand, y in the closing direction; a jaw, a cup, or another kind.

    Attributes:
        name: "fingers" or "suction", or another package's, as the segments name it.
        link: Link that carries the frame.
        pose_tool_to_link: (4, 4) where the frame is in it.
        jaw: The jaw; null for another kind.
        cup: The cup; null for another kind.
        more: What another package's gripper says of itself; left out for others.
    """

    name: str
    link: str
    pose_tool_to_link: Matrix
    jaw: JawData | None = None
    cup: CupData | None = None
    more: dict[str, Any] | msgspec.UnsetType = msgspec.UNSET


class ArmData(msgspec.Struct, frozen=True):
    """An arm and its tools.

    Attributes:
        urdf: The file that describes it: `PACKAGE:PATH` inside an installed Python package, else a path.
        sha256: Digest of that file.
        catalog: Whether topple knows the arm by its name.
        joints: Names of its joints, base first.
        lower: Lower limits [rad] or [m].
        upper: Upper limits.
        velocity: Velocity limits [rad/s] or [m/s].
        acceleration: Acceleration limits [rad/s2] or [m/s2].
        tools: What it holds with.
        gripper: What the gripper file beside the URDF said; null where there was none.
    """

    urdf: str
    sha256: str
    catalog: bool
    joints: list[str]
    lower: list[float]
    upper: list[float]
    velocity: list[float]
    acceleration: list[float]
    tools: list[ToolData]
    gripper: GripperFile | None = None


def arm_data(arm: "Arm") -> ArmData:
    """An arm as data."""
    return ArmData(
        urdf=_name_file(arm.source),
        sha256=_digest(arm.source),
        catalog=arm.catalog,
        joints=list(arm.joints),
        lower=arm.lower.tolist(),
        upper=arm.upper.tolist(),
        velocity=arm.velocity.tolist(),
        acceleration=arm.acceleration.tolist(),
        tools=[_tool_data(tool) for tool in arm.tools.values()],
        gripper=arm.gripper,
    )


def arm_from(data: ArmData, name: str) -> "Arm":
    """Find the arm of a plan again.

    Args:
        data: What the plan says of it.
        name: The arm's name.

    Returns:
        The arm, from the same URDF.

    Raises:
        InvalidInput: The URDF is not there or is another one than the plan was made with, or its limits or
            tools are not what the plan says.
    """
    from topple.robots.catalog import robot

    path = _found(data.urdf)
    if path is None or not path.is_file():
        raise InvalidInput(f"the plan's arm {name!r} is described by {data.urdf}, which is not here: give it")
    digest = _digest(path)
    if digest != data.sha256:
        raise InvalidInput(
            f"{data.urdf} is not the file the plan was made with (sha256 {digest[:12]}, expected "
            f"{data.sha256[:12]}): plan again, or give the arm"
        )
    arm = robot(name) if data.catalog else robot(path, gripper=data.gripper)
    told, found = msgspec.to_builtins(data), msgspec.to_builtins(arm_data(arm))
    for key in ("joints", "lower", "upper", "velocity", "acceleration", "tools"):
        if not _alike(told[key], found[key]):
            raise InvalidInput(
                f"the plan's arm {name!r} is not as {data.urdf} has it: `$.arm.{key}` says otherwise; plan "
                "again, or give the arm"
            )
    return arm


def _alike(told: Any, found: Any) -> bool:
    """Whether data are the same, but for last digits that another processor may find."""
    if isinstance(told, dict) and isinstance(found, dict):
        a, b = cast(dict[str, Any], told), cast(dict[str, Any], found)
        return a.keys() == b.keys() and all(_alike(a[key], b[key]) for key in a)
    if isinstance(told, list) and isinstance(found, list):
        some, others = cast(list[Any], told), cast(list[Any], found)
        return len(some) == len(others) and all(map(_alike, some, others))
    if isinstance(told, float) and isinstance(found, float):
        return math.isclose(told, found, rel_tol=ALIKE, abs_tol=ALIKE)
    return bool(told == found)


def _tool_data(tool: Tool) -> ToolData:
    frame = {"name": tool.name, "link": tool.link, "pose_tool_to_link": tool.pose_tool_to_link.tolist()}
    return msgspec.convert({**frame, **tool.gripper.data()}, ToolData)


def _name_file(path: Path) -> str:
    """A file by the package that ships it, or else by its path."""
    path = path.resolve()
    for folder in sys.path:
        root = Path(folder or ".").resolve()
        if path.is_relative_to(root):
            package, *rest = path.relative_to(root).parts
            if rest and (root / package / "__init__.py").is_file():
                return f"{package}:{'/'.join(rest)}"
    return str(path)


def _found(urdf: str) -> Path | None:
    package, colon, rest = urdf.partition(":")
    if not colon or not package.isidentifier():
        return Path(urdf)
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        return None
    if spec is None or not spec.submodule_search_locations:
        return None
    return Path(next(iter(spec.submodule_search_locations))) / rest


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
