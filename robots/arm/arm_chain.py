"""Which joints of a robot are the arm: the others are held still, as brakes or another controller hold them.

A URDF may describe wheels, a torso, a head and a second arm as well. The arm is what a gripper file or an
SRDF names; where neither does, the one long chain of joints, if there is one.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.arm.elements import number, numbers, origin_of
from topple.robots.arm.gripper_file import ArmPart
from topple.robots.arm.srdf import Group, Semantics
from topple.robots.arm.tolerances import SERIES
from topple.robots.arm.tree import Edge, Tree
from topple.robots.arm.urdf import DRIVABLE
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput


@dataclass(frozen=True)
class ArmChain:
    """The joints that are the arm.

    Attributes:
        joints: Their names, base first.
        tip: The link behind the last one.
        still: Names of the joints that do not move.
    """

    joints: tuple[str, ...]
    tip: str
    still: tuple[str, ...]


def arm_chain(
    tree: Tree, part: ArmPart | None, semantics: Semantics | None, group: str | None
) -> ArmChain | None:
    """Find the arm among the joints of a robot.

    Args:
        tree: The robot.
        part: What a gripper file says of it: goes first.
        semantics: What an SRDF says.
        group: The SRDF's group that is the arm.

    Returns:
        The arm; None where all that moves is one arm with its hand, and nothing was said.

    Raises:
        InvalidInput: A name is unknown, the joints named are not one behind the other, or there are several
            arms and nothing says which; the message says which there are.
    """
    named = part is not None and (part.joints is not None or part.tip is not None)
    if named and group is not None:
        raise InvalidInput(
            f"{tree.name}: group={group} and [arm] of the gripper file both name the arm: give one"
        )
    if part is not None and named:
        joints = _named_joints(tree, part)
    elif semantics is not None and (group is not None or _arm_groups(tree, semantics)):
        joints = _of_group(tree, semantics, group)
    elif group is not None:
        raise InvalidInput(f"{tree.name}: group={group} needs an SRDF that has the group: give srdf=FILE")
    else:
        joints = _longest(tree, semantics)
    rest: Collection[str] = () if part is None else part.rest
    if joints is None:
        if not rest:
            return None
        joints = tuple(e.joint for e in _joints_to_branch(tree) if e.joint not in rest)
    last = tree.edge(joints[-1])
    assert last is not None
    kept = {*joints, *(e.joint for e in tree.below(last.child))} - set(rest)
    still = tuple(e.joint for e in tree.edges.values() if e.moves and e.joint not in kept)
    return ArmChain(joints, last.child, still)


def _named_joints(tree: Tree, part: ArmPart) -> tuple[str, ...]:
    """The joints that a gripper file names."""
    if part.joints is None:
        if part.tip not in tree.links:
            raise InvalidInput(f"`$.arm.tip` names {part.tip!r}: {tree.name} has {', '.join(tree.links)}")
        path = [e.joint for e in tree.above(part.tip) if e.moves and e.joint not in part.rest]
        if not path:
            raise InvalidInput(f"`$.arm.tip` names {part.tip!r}: no joint of {tree.name} moves it")
        return tuple(path)
    for name in part.joints:
        if tree.edge(name) is None:
            known = ", ".join(e.joint for e in tree.edges.values() if e.moves)
            raise InvalidInput(f"`$.arm.joints` names {name!r}: {tree.name} moves {known}")
    return _in_series(tree, part.joints, "`$.arm.joints`")


def _in_series(tree: Tree, names: Sequence[str], where: str) -> tuple[str, ...]:
    """Joints, base first, each beyond the one before."""
    edges = [edge for edge in (tree.edge(name) for name in names) if edge is not None]
    deepest = max(edges, key=lambda edge: len(tree.above(edge.child)))
    path = [edge.joint for edge in tree.above(deepest.child) if edge.joint in names]
    beside = [edge.joint for edge in edges if edge.joint not in path]
    if beside:
        raise InvalidInput(f"{where}: {', '.join(beside)} of {tree.name} not in one series with {path[-1]}")
    return tuple(path)


def _joints_of(tree: Tree, semantics: Semantics, group: Group) -> list[Edge]:
    """All joints of a group that move of their own."""
    found: list[Edge] = [edge for edge in map(tree.edge, group.joints) if edge is not None]
    found += [tree.edges[link] for link in group.links if link in tree.edges]
    for base, tip in group.chains:
        path = tree.above(tip)
        starts = [i for i, edge in enumerate(path) if edge.parent == base]
        found += path[starts[0] :] if starts else []
    for name in group.groups:
        found += _joints_of(tree, semantics, semantics.groups[name])
    return list({e.joint: e for e in found if e.kind in DRIVABLE and e.follows is None}.values())


def _arm_groups(tree: Tree, semantics: Semantics) -> list[str]:
    """The groups that can be an arm: joints in one series, at least as many as an arm has."""
    found: dict[str, frozenset[str]] = {}
    for name, group in semantics.groups.items():
        names = [edge.joint for edge in _joints_of(tree, semantics, group)]
        try:
            series = _in_series(tree, names, name) if names else ()
        except InvalidInput:
            continue
        if len(series) >= SERIES:
            found[name] = frozenset(series)
    # one that adds a torso or a hand to another is no arm of its own
    return [name for name, joints in found.items() if not any(other < joints for other in found.values())]


def _of_group(tree: Tree, semantics: Semantics, group: str | None) -> tuple[str, ...]:
    """The joints of the SRDF's group that is the arm."""
    where = semantics.path.name
    arms = _arm_groups(tree, semantics)
    if group is None:
        parents = [e.parent_group for e in semantics.end_effectors if e.parent_group in arms]
        candidates = list(dict.fromkeys(parents)) or arms
        if len(candidates) > 1:
            raise InvalidInput(
                f"{where} has several arms: say which with group=NAME, one of {', '.join(candidates)}; "
                "for one that it does not name write arm = {tip = LINK} in a gripper file"
            )
        group = str(candidates[0])
    if group not in semantics.groups:
        known = ", ".join(arms or semantics.groups) or "none"
        raise InvalidInput(f"{where}: no group {group!r}; groups that are an arm: {known}")
    names = [edge.joint for edge in _joints_of(tree, semantics, semantics.groups[group])]
    if not names:
        raise InvalidInput(
            f"{where}: no joint of {tree.name} is in group {group!r}: expected those of an arm"
        )
    return _in_series(tree, names, f"{where}: group {group!r}")


def _joints_to_branch(tree: Tree) -> list[Edge]:
    """The moving joints from the root to where moving parts branch."""
    path: list[Edge] = []
    link = tree.root
    while link is not None and len(tree.branches(link)) == 1 and len(path) <= len(tree.edges):
        path += tree.branches(link)
        link = path[-1].child
    return [edge for edge in path if edge.moves]


def _arms(tree: Tree, link: str) -> list[Edge]:
    """The branches at a link that are arms: a finger has fewer joints, one behind the other, than its arm."""
    carrying = sum(edge.moves for edge in tree.above(link))
    return [edge for edge in tree.branches(link) if tree.series(edge) >= max(SERIES, carrying + 1)]


def _longest(tree: Tree, semantics: Semantics | None) -> tuple[str, ...] | None:
    """The joints of the one branch that is an arm; None where nothing else moves but its hand."""
    link, path, alone = tree.root, list[Edge](), True
    while link is not None and len(path) <= len(tree.edges):
        branches, arms = tree.branches(link), _arms(tree, link)
        if len(branches) > 1 and len(arms) > 1:
            other = "srdf=FILE and group=NAME" if semantics is None else "group=NAME"
            raise InvalidInput(
                f"{tree.name} has several arms: say which with arm = {{tip = LINK}} in a gripper file, "
                f"LINK one of {', '.join(_tips(tree, arms))}, or with {other}"
            )
        if len(branches) > 1 and not arms and sum(edge.moves for edge in path) < 2:
            raise InvalidInput(
                f"{tree.name}: {link!r} carries {len(branches)} moving parts and none is an arm, which has "
                f"{SERIES} joints or more, one behind the other: name its joints in [arm] of a gripper file"
            )
        if len(branches) > 1 and len(arms) == 1:
            branches, alone = arms, False
        if len(branches) != 1:
            break
        path += branches
        link = branches[0].child
    moving = [edge for edge in path if edge.moves]
    # two joints or more beneath all that has a shape are no arm's: they stand for wheels on a floor
    if len(wheels := list(takewhile(lambda edge: edge.parent in tree.bare, moving))) > 1:
        moving, alone = moving[len(wheels) :], False
    return None if alone or not moving else tuple(edge.joint for edge in moving)


def _tips(tree: Tree, arms: Sequence[Edge]) -> list[str]:
    """The links behind the last joints before arms branch into fingers; a torso branches into arms."""
    found = list[str]()
    for edge in arms:
        tip = edge.child
        while len(branches := tree.branches(tip)) == 1:
            tip = branches[0].child
        found += _tips(tree, _arms(tree, tip)) or [tip]
    return found


def hold_still(
    robot: ElementTree.Element, still: Collection[str], values: Mapping[str, float], name: str
) -> dict[str, float]:
    """Make joints of a URDF fixed where they stand.

    Args:
        robot: The `<robot>` element, changed.
        still: Names of the joints.
        values: Where they stand [rad] or [m]; zero, or the limit next to it, where not given.
        name: What to call the file in messages.

    Returns:
        The values they stand at.

    Raises:
        InvalidInput: A value is beyond the joint's limits, or a number in the file is none.
    """
    elements = {str(element.get("name")): element for element in robot.findall("joint")}
    stand: dict[str, float] = {}

    def value_of(joint: str, depth: int = 0) -> float:
        element = elements[joint]
        mimic, limit = element.find("mimic"), element.find("limit")
        where = f"{name}: joint {joint!r}"
        if mimic is not None and mimic.get("joint") in elements and depth < len(elements):
            followed = value_of(str(mimic.get("joint")), depth + 1)
            followed *= number(mimic.get("multiplier"), 1.0, where)
            return followed + number(mimic.get("offset"), 0.0, where)
        if limit is None or element.get("type") not in ("revolute", "prismatic"):
            return values.get(joint, 0.0)
        low, high = number(limit.get("lower"), 0.0, where), number(limit.get("upper"), 0.0, where)
        if joint in values and not low <= values[joint] <= high:
            raise InvalidInput(
                f"{where} cannot stand at {values[joint]:g}: its limits are {low:g} and {high:g}"
            )
        return values.get(joint, min(max(0.0, low), high))

    for joint in still:
        stand[joint] = value_of(joint)
    for joint, value in stand.items():
        _fix(elements[joint], value, f"{name}: joint {joint!r}")
    return stand


def _fix(element: ElementTree.Element, value: float, where: str) -> None:
    """Make a joint a fixed one, its child where the value puts it."""
    pose = origin_of(element, where)
    axis_element = element.find("axis")
    axis = numbers(None if axis_element is None else axis_element.get("xyz"), 3, (1.0, 0.0, 0.0), where)
    length = float(np.linalg.norm(axis))
    motion: FloatArray = np.eye(4)
    if length > 0.0 and element.get("type") == "prismatic":
        motion[:3, 3] = value * axis / length
    elif length > 0.0 and element.get("type") in DRIVABLE:
        motion[:3, :3] = Rotation.from_rotvec(value * axis / length).as_matrix()
    pose = pose @ motion
    for child in ("origin", "axis", "limit", "mimic", "dynamics", "safety_controller", "calibration"):
        for found in element.findall(child):
            element.remove(found)
    xyz, rpy = pose[:3, 3], Rotation.from_matrix(pose[:3, :3]).as_euler("xyz")
    element.set("type", "fixed")
    ElementTree.SubElement(
        element,
        "origin",
        xyz=" ".join(f"{x:.12g}" for x in xyz),
        rpy=" ".join(f"{angle:.12g}" for angle in rpy),
    )
