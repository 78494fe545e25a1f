"""Reading an SRDF, which says of a URDF which joints are an arm, what it holds with, and what never collides.

MoveIt's setup assistant writes such files; `robots/` folders ship them beside the URDF, in `srdf/` or in
`config/`.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from topple.robots.arm.elements import number
from topple.robots.arm.urdf import xml_root
from topple.topology.base.errors import InvalidInput

PLACES = (".", "srdf", "config", "../srdf", "../config")  # from the URDF's folder


@dataclass(frozen=True)
class Group:
    """Joints and links that are planned for together.

    Attributes:
        joints: Names of joints.
        links: Names of links, which stand for the joints that carry them.
        chains: Pairs (base link, tip link): all joints between.
        groups: Names of other groups it contains.
    """

    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    chains: tuple[tuple[str, str], ...] = ()
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class EndEffector:
    """What an arm holds with.

    Attributes:
        name: Its name.
        parent_link: The link of the arm that carries it.
        group: The group of its own joints and links.
        parent_group: The group that is the arm, where the file says so.
    """

    name: str
    parent_link: str
    group: str
    parent_group: str | None = None


@dataclass(frozen=True)
class Semantics:
    """What an SRDF says.

    Attributes:
        path: The file.
        groups: By name.
        end_effectors: In the order of the file.
        states: Group -> state -> joint -> value [rad] or [m].
        apart: Pairs of links that are not to be checked against each other.
    """

    path: Path
    groups: Mapping[str, Group]
    end_effectors: tuple[EndEffector, ...]
    states: Mapping[str, Mapping[str, Mapping[str, float]]]
    apart: frozenset[frozenset[str]]


def read_srdf(path: str | Path) -> Semantics:
    """Read an SRDF file.

    Args:
        path: The file.

    Returns:
        What it says.

    Raises:
        InvalidInput: The file cannot be read or is no SRDF, an attribute is missing, or a group contains one
            that is not there.
    """
    path = Path(path).expanduser().resolve()
    robot = xml_root(path, "an SRDF")
    if robot.find("link") is not None:
        raise InvalidInput(f"{path}: this is a URDF, its links are defined here: give it as the robot")

    where = path.name
    groups = {_text(e, "name", where): _group(e, where) for e in robot.findall("group")}
    for name, group in groups.items():
        for other in group.groups:
            if other not in groups:
                raise InvalidInput(f"{where}: group {name!r} contains {other!r}, which is not there")
    effectors = tuple(
        EndEffector(
            _text(e, "name", where),
            _text(e, "parent_link", where),
            _text(e, "group", where),
            e.get("parent_group"),
        )
        for e in robot.findall("end_effector")
    )
    apart = frozenset(
        frozenset((_text(e, "link1", where), _text(e, "link2", where)))
        for e in robot.findall("disable_collisions")
    )
    return Semantics(path, groups, effectors, _states(robot, where), apart)


def _text(element: ElementTree.Element, key: str, where: str) -> str:
    """An attribute that has to be there."""
    value = element.get(key)
    if not value:
        raise InvalidInput(f"{where}: a <{element.tag}> without {key!r}")
    return value


def _group(element: ElementTree.Element, where: str) -> Group:
    joints, links, groups = (
        tuple(_text(e, "name", where) for e in element.findall(tag)) for tag in ("joint", "link", "group")
    )
    chains = tuple(
        (_text(e, "base_link", where), _text(e, "tip_link", where)) for e in element.findall("chain")
    )
    return Group(joints, links, chains, groups)


def _states(robot: ElementTree.Element, where: str) -> dict[str, dict[str, dict[str, float]]]:
    """Group -> state -> joint -> value; joints with several numbers (planar, floating) are no arm's."""
    states: dict[str, dict[str, dict[str, float]]] = {}
    for element in robot.findall("group_state"):
        name = _text(element, "name", where)
        states.setdefault(str(element.get("group", "")), {})[name] = {
            str(joint.get("name")): number(joint.get("value"), None, f"{where}: group state {name!r}")
            for joint in element.findall("joint")
            if len(str(joint.get("value")).split()) == 1
        }
    return states


def srdf_beside(urdf: Path) -> Path | None:
    """The SRDF of the same name beside a URDF, or in the `srdf` or `config` folder there; None without."""
    found = (urdf.parent / place / f"{urdf.stem}.srdf" for place in PLACES)
    return next((path.resolve() for path in found if path.is_file()), None)
