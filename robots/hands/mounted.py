"""A hand that has a URDF of its own, mounted on a link of an arm."""

import hashlib
import math
import xml.etree.ElementTree as ElementTree
from copy import deepcopy
from pathlib import Path

import msgspec

from topple.robots.arm.gripper_file import Hand
from topple.robots.arm.shapes import find_mesh
from topple.robots.arm.tree import Tree
from topple.robots.arm.urdf import urdf_root
from topple.robots.hands.wsg50 import wsg50_xml
from topple.topology.base.errors import InvalidInput

WSG50 = "wsg50"
FLANGE = "tool0"
"""Where tools are mounted by REP 199, z out of the flange."""


def flange_of(tree: Tree, tip: str | None) -> str:
    """The link that a hand is mounted on where none is named.

    Args:
        tree: The arm.
        tip: The link behind its last joint; None: the one with the most moving joints before it.

    Returns:
        `tool0`, if there is such a link, or else the last link that is fixed to the tip.
    """
    if tip is None:
        tip = max(tree.links, key=lambda link: sum(edge.moves for edge in tree.above(link)))
    fixed, waiting = [tip], [tip]
    while waiting:
        link = waiting.pop(0)
        hanging = [edge.child for edge in tree.below(link) if edge.parent == link and not edge.moves]
        fixed += hanging
        waiting += hanging
    return FLANGE if FLANGE in fixed else fixed[-1]


def mount(robot: ElementTree.Element, name: str, hand: Hand, link: str, data: Path | None) -> Hand:
    """Add a hand's links and joints to an arm's.

    Args:
        robot: The arm's `<robot>` element, added to.
        name: What to call the arm's file in messages.
        hand: The hand.
        link: The link it is mounted on.
        data: The folder of pybullet_data, for `wsg50` alone.

    Returns:
        The hand, with the link and the digest of its file.

    Raises:
        InvalidInput: The hand's URDF cannot be read, is not the one it should be, or has no one root link, or
            the arm has no such link.
    """
    links = [str(element.get("name")) for element in robot.findall("link")]
    if link not in links:
        raise InvalidInput(f"`$.hand.link` names {link!r}: {name} has {', '.join(links)}")
    if hand.urdf == WSG50:
        assert data is not None
        # its palm is mounted by a joint of ours: the offset is to be heeded
        added = ElementTree.fromstring(f"<robot name='{WSG50}'>{wsg50_xml(data, link, 0.0)}</robot>")
        added.remove(next(e for e in added.findall("joint") if e.get("name") == "wsg50_mount"))
        digest, turned = None, math.pi / 2.0
    else:
        path = Path(hand.urdf).expanduser().resolve()
        added = deepcopy(urdf_root(path))
        digest, turned = hashlib.sha256(path.read_bytes()).hexdigest(), 0.0
        if hand.sha256 not in (None, digest):
            raise InvalidInput(
                f"{path} is not the hand that was meant (sha256 {digest[:12]}, "
                f"expected {str(hand.sha256)[:12]})"
            )
        for mesh in added.iter("mesh"):
            found = find_mesh(str(mesh.get("filename")), path)
            if found is not None:
                mesh.set("filename", str(found))
    root = Tree(added, hand.urdf).root
    if root is None:
        raise InvalidInput(f"{hand.urdf}: expected one root link to mount it by")
    prefix = _prefix(robot, added)
    for element in added:
        _rename(element, prefix)
    numbers = [*(hand.offset or [0.0, 0.0, 0.0]), 0.0, 0.0, 0.0][:6]
    joint = ElementTree.SubElement(robot, "joint", name=f"{prefix}{root}_mount", type="fixed")
    ElementTree.SubElement(joint, "parent", link=link)
    ElementTree.SubElement(joint, "child", link=f"{prefix}{root}")
    x, y, z, roll, pitch, yaw = numbers
    ElementTree.SubElement(joint, "origin", xyz=f"{x} {y} {z}", rpy=f"{roll} {pitch} {yaw + turned}")
    robot.extend(element for element in added if element.tag in ("link", "joint", "material"))
    return msgspec.structs.replace(hand, link=link, sha256=digest)


def _prefix(robot: ElementTree.Element, added: ElementTree.Element) -> str:
    """Find a prefix with which none of the hand's names is one of the arm's too."""
    taken = {(element.tag, element.get("name")) for element in robot}
    names = [(e.tag, str(e.get("name"))) for e in added if e.tag in ("link", "joint", "material")]
    prefix = ""
    while any((tag, prefix + name) in taken for tag, name in names):
        prefix += "hand_"
    return prefix


def _rename(element: ElementTree.Element, prefix: str) -> None:
    """Put a prefix before the names of links, joints and materials."""
    if not prefix or element.tag not in ("link", "joint", "material"):
        return
    element.set("name", prefix + str(element.get("name")))
    for tag, key in (("parent", "link"), ("child", "link"), ("mimic", "joint")):
        for found in element.findall(tag):
            found.set(key, prefix + str(found.get(key)))
    for material in element.findall("visual/material"):
        if material.get("name"):
            material.set("name", prefix + str(material.get("name")))
