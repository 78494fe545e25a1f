"""Reading a URDF into links with collision vertices and joints with limits, naming whatever is missing.

pybullet loads the same files but silently skips missing meshes, ignores `<mimic>` and invents limits; a
planner that promises collision-free motion has to refuse such a file, and say which element is at fault.
"""

import re
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

import numpy as np
from scipy.spatial import QhullError

from topple.robots.arm.elements import number, numbers, origin_of
from topple.robots.arm.shapes import geometry_parts, missing_meshes
from topple.robots.arm.tolerances import FULL_TURN, LIKELY_DEGREES, LONGEST, MOST_BODIES
from topple.robots.collision.convex import hull_of
from topple.robots.collision.tolerances import FINE, GAIN
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.io.limits import read_bytes

DRIVABLE = ("revolute", "continuous", "prismatic")
UNBOUND_PREFIX = expat.errors.codes[expat.errors.XML_ERROR_UNBOUND_PREFIX]


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another one: value = multiplier * value of `joint` + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of the tree.

    Attributes:
        name: Name in the file.
        kind: revolute, continuous, prismatic or fixed.
        parent: Name of the parent link.
        child: Name of the child link.
        pose_child_to_parent: (4, 4) at joint value zero.
        axis: (3,) unit axis in the child frame.
        lower: Lower limit in [rad] or [m].
        upper: Upper limit in [rad] or [m].
        velocity: Velocity limit in [rad/s] or [m/s].
        effort: Effort limit in [N m] or [N].
        limited: Whether the file gives limits (a continuous joint needs none).
        mimic: The joint it follows, if any.
    """

    name: str
    kind: str
    parent: str
    child: str
    pose_child_to_parent: FloatArray
    axis: FloatArray
    lower: float
    upper: float
    velocity: float
    effort: float
    limited: bool
    mimic: Mimic | None


@dataclass(frozen=True, eq=False)
class Inertial:
    """How a link's mass lies in it.

    Attributes:
        mass: In [kg], above 0.
        pose_inertial_to_link: (4, 4) with the centre of mass as its origin [m].
        tensor: (3, 3) of inertia about that, in these axes [kg m2], as the file states it.
    """

    mass: float
    pose_inertial_to_link: FloatArray
    tensor: FloatArray


@dataclass(frozen=True, eq=False)
class Link:
    """One link.

    Attributes:
        name: Name in the file.
        parts: (V, 3) hull vertices of each collision element in the link frame in [m].
        inertial: Its mass; None where the file states none.
    """

    name: str
    parts: tuple[FloatArray, ...] = ()
    inertial: Inertial | None = None


@dataclass(frozen=True, eq=False)
class Model:
    """A kinematic tree, links ordered parents first.

    Attributes:
        name: Name of the robot.
        path: The file it was read from.
        links: Links by name; the first one is the root.
        joints: Joints by the name of their child link.
    """

    name: str
    path: Path
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]

    @property
    def root(self) -> str:
        """Name of the root link."""
        return next(iter(self.links))

    def joint(self, name: str) -> Joint:
        """The joint called `name`.

        Raises:
            InvalidInput: If there is none; the message lists those there are.
        """
        for joint in self.joints.values():
            if joint.name == name:
                return joint
        known = ", ".join(joint.name for joint in self.joints.values())
        raise InvalidInput(f"{self.path.name}: no joint {name!r}; it has {known}")

    def path_to(self, link: str) -> tuple[Joint, ...]:
        """The joints from the root to `link`, root first.

        Raises:
            InvalidInput: If there is no such link.
        """
        if link not in self.links:
            raise InvalidInput(f"{self.path.name}: no link {link!r}; it has {', '.join(self.links)}")
        path: list[Joint] = []
        while link in self.joints:
            path.append(self.joints[link])
            link = self.joints[link].parent
        return tuple(reversed(path))


def read_urdf(path: str | Path) -> Model:
    """Read a URDF file with the meshes it names.

    Args:
        path: The URDF. Mesh names are taken as absolute, relative to the file, or `package://` relative to
            the file's folder or one of its parents (with or without the package's own name), to the other
            packages of their workspace, and to ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.

    Returns:
        The tree, with collision vertices in link frames.

    Raises:
        InvalidInput: If the file is not a URDF, its links do not form one tree, a joint kind is unknown, a
            joint has no axis, or collision meshes are missing or unreadable. Every missing mesh is named.
    """
    path = Path(path).expanduser().resolve()
    return model_of(urdf_root(path), path, cut=False)


def urdf_root(path: Path) -> ElementTree.Element:
    """Parse a URDF file.

    Args:
        path: The file.

    Returns:
        Its `<robot>` element.

    Raises:
        InvalidInput: If the file cannot be read, or is not a URDF.
    """
    return xml_root(path, "a URDF")


def xml_root(path: Path, kind: str) -> ElementTree.Element:
    """Parse an XML file that describes a robot.

    Args:
        path: The file.
        kind: What it should be, in messages: "a URDF".

    Returns:
        Its `<robot>` element.

    Raises:
        InvalidInput: If the file cannot be read, or is something else.
    """
    try:
        robot = _parse(read_bytes(path, str(path)))
    except OSError as error:
        raise InvalidInput(
            f"{path}: cannot be read ({error.strerror}); give the path of {kind} file"
        ) from error
    except ElementTree.ParseError as error:
        raise InvalidInput(f"{path}: not XML ({error}); give the path of {kind} file") from error
    if robot.tag != "robot":
        raise InvalidInput(f"{path}: the root element is <{robot.tag}>, {kind} has <robot>")
    bodies = sum(element.tag in ("link", "collision", "visual") for element in robot.iter())
    if bodies > MOST_BODIES:
        raise InvalidInput(
            f"{path}: {bodies} links and shapes; expected those of a robot, {MOST_BODIES} at most"
        )
    if any("}" in element.tag and "xacro" in element.tag for element in robot.iter()):
        made = f"robot.{kind.split()[-1].lower()}"
        raise InvalidInput(f"{path}: this is xacro: make {kind} of it (xacro {path.name} > {made})")
    return robot


def _parse(data: bytes) -> ElementTree.Element:
    """The root element; prefixes such as `drake:` are often used without being declared."""
    try:
        return ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        if error.code != UNBOUND_PREFIX:
            raise
    used = {prefix.decode() for prefix in re.findall(rb"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]", data)}
    declared = "".join(f' xmlns:{name}="urn:{name}"' for name in sorted(used) if name != "xmlns")
    return ElementTree.fromstring(re.sub(rb"<robot\b", b"<robot" + declared.encode(), data, count=1))


def model_of(
    robot: ElementTree.Element, path: Path, *, cut: bool = True, fine: Collection[str] = ()
) -> Model:
    """Read a `<robot>` element with the meshes it names.

    Args:
        robot: The element.
        path: The file it is from: mesh names are relative to it, and messages name it.
        cut: Make several convex parts of a concave mesh; else each is its hull, as PyBullet has it.
        fine: Links whose meshes are cut finely: what lies between fingers counts.

    Returns:
        The tree, as `read_urdf` gives it.

    Raises:
        InvalidInput: As for `read_urdf`.
    """
    for tag in ("link", "joint"):
        counts = Counter(str(element.get("name")) for element in robot.findall(tag))
        if twice := [name for name, count in counts.items() if count > 1]:
            raise InvalidInput(f"{path.name}: there are two of {tag} {twice[0]!r}: expected each name once")
    joints = _read_joints(robot, path)
    missing: list[str] = []
    links = dict[str, Link]()
    for element in robot.findall("link"):
        name = str(element.get("name"))
        gain = FINE if name in fine else GAIN if cut else None
        links[name] = _read_link(element, path, missing, gain)
    if missing:
        raise InvalidInput(missing_meshes(missing, path))
    return Model(str(robot.get("name", path.stem)), path, _parents_first(links, joints, path), joints)


def _parents_first(links: Mapping[str, Link], joints: Mapping[str, Joint], path: Path) -> dict[str, Link]:
    for joint in joints.values():
        for name in (joint.parent, joint.child):
            if name not in links:
                raise InvalidInput(
                    f"{path.name}: joint {joint.name!r} names the link {name!r}, which is not there"
                )
    if not links:
        raise InvalidInput(f"{path.name}: has no links: expected at least one")
    roots = [name for name in links if name not in joints]
    if len(roots) != 1:
        raise InvalidInput(
            f"{path.name}: expected one root link, found {', '.join(roots) or 'none (a loop)'}"
        )
    children: dict[str, list[str]] = {}
    for joint in joints.values():
        children.setdefault(joint.parent, []).append(joint.child)
    ordered: dict[str, Link] = {}
    waiting = list(roots)
    while waiting:
        name = waiting.pop()
        ordered[name] = links[name]
        waiting += reversed(children.get(name, []))
    if len(ordered) != len(links):
        lost = ", ".join(name for name in links if name not in ordered)
        raise InvalidInput(f"{path.name}: links in a loop, not connected to {roots[0]!r}: {lost}")
    return ordered


def _read_joints(robot: ElementTree.Element, path: Path) -> dict[str, Joint]:
    joints: dict[str, Joint] = {}
    for element in robot.findall("joint"):
        joint = _read_joint(element, path)
        if joint.child in joints:
            raise InvalidInput(f"{path.name}: link {joint.child!r} has two parent joints")
        joints[joint.child] = joint
    moving = [joint.name for joint in joints.values() if joint.kind != "fixed"]
    for joint in joints.values():
        if joint.kind != "fixed" and joint.mimic is not None and joint.mimic.joint not in moving:
            raise InvalidInput(
                f"{path.name}: joint {joint.name!r} mimics {joint.mimic.joint!r}, which is none that moves: "
                f"expected one of {', '.join(moving)}; or leave its <mimic> out"
            )
    return joints


def _read_joint(element: ElementTree.Element, path: Path) -> Joint:
    name, kind = str(element.get("name")), str(element.get("type"))
    where = f"{path.name}: joint {name!r}"
    if kind not in (*DRIVABLE, "fixed"):
        raise InvalidInput(
            f"{where} is {kind!r}, which cannot be driven; expected {', '.join(DRIVABLE)} or fixed"
        )
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        raise InvalidInput(f"{where} has no parent or no child")
    axis_element, limit = element.find("axis"), element.find("limit")
    text = None if axis_element is None else axis_element.get("xyz")
    axis = numbers(text, 3, (1.0, 0.0, 0.0), f"{where} axis")
    length = float(np.linalg.norm(axis))
    if kind != "fixed" and length < 1e-6:
        raise InvalidInput(f"{where} moves but its axis is zero")
    turns = kind == "continuous"
    bounds = {} if limit is None else dict(limit.attrib)
    lower = -FULL_TURN if turns else number(bounds.get("lower"), 0.0, where)
    upper = FULL_TURN if turns else number(bounds.get("upper"), 0.0, where)
    if lower > upper:
        raise InvalidInput(
            f"{where}: its lower limit {lower:g} is above its upper limit {upper:g}: exchange them"
        )
    if kind == "revolute" and LIKELY_DEGREES[0] < max(abs(lower), abs(upper)) <= LIKELY_DEGREES[1]:
        raise InvalidInput(
            f"{where} has limits of {lower:g} and {upper:g}, which are radians in a URDF: for degrees "
            f"expected {np.radians(lower):.4g} and {np.radians(upper):.4g}; "
            "a joint that turns on and on is 'continuous'"
        )
    return Joint(
        name,
        kind,
        str(parent.get("link")),
        str(child.get("link")),
        freeze(origin_of(element, where)),
        freeze(axis / length if length > 0 else axis),
        lower,
        upper,
        number(bounds.get("velocity"), 0.0, where),
        number(bounds.get("effort"), 0.0, where),
        turns or lower < upper,
        _read_mimic(element, where),
    )


def _read_mimic(element: ElementTree.Element, where: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    factor, offset = number(mimic.get("multiplier"), 1.0, where), number(mimic.get("offset"), 0.0, where)
    return Mimic(str(mimic.get("joint")), factor, offset)


def _read_link(element: ElementTree.Element, path: Path, missing: list[str], gain: float | None) -> Link:
    name = str(element.get("name"))
    parts: list[FloatArray] = []
    for collision in element.findall("collision"):
        where = f"{path.name}: link {name!r}"
        pose = origin_of(collision, where)
        for vertices in geometry_parts(collision.find("geometry"), path, where, missing, gain):
            if not max(np.abs(vertices).max(initial=0.0), np.abs(pose[:3, 3]).max()) < LONGEST:  # nan is not
                raise InvalidInput(f"{where} has a collision shape beyond {LONGEST:g} m: expected metres")
            try:
                parts.append(freeze(hull_of(move_points(vertices, pose))[0]))
            except QhullError as error:
                raise InvalidInput(f"{where} has a collision shape that has no hull") from error
    return Link(name, tuple(parts), _read_inertial(element.find("inertial"), f"{path.name}: link {name!r}"))


def _read_inertial(element: ElementTree.Element | None, where: str) -> Inertial | None:
    mass, inertia = (None if element is None else element.find(tag) for tag in ("mass", "inertia"))
    if element is None or mass is None or inertia is None:
        return None
    try:
        value = number(mass.get("value"), 0.0, where)
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        xx, xy, xz, yy, yz, zz = (number(inertia.get(key), 0.0, where) for key in keys)
        pose = origin_of(element, where)
    except InvalidInput:  # no number is as good as none: it is estimated then, as PyBullet is given it
        return None
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertial(value, freeze(pose), freeze(tensor)) if value > 0.0 else None
