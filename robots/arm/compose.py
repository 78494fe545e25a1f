"""URDF files made at run time: an arm of another package with links of ours added, mesh paths absolute."""

import atexit
import hashlib
import os
import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path

from topple.robots.arm.shapes import find_mesh
from topple.robots.scratch import Scratch


def compose_urdf(source: Path, name: str, addition: str) -> Path:
    """Write a URDF with links and joints added.

    Args:
        source: The URDF to add to.
        name: Name of the robot and of the file.
        addition: XML of the added elements; mesh paths in it are absolute.

    Returns:
        Path of the file, in a temporary folder that ends with the process; its name carries a digest of
        its content.
    """
    robot = ElementTree.parse(source).getroot()
    robot.set("name", name)
    for mesh in robot.iter("mesh"):
        named = str(mesh.get("filename"))
        found = find_mesh(named, source) or source.parent / named.removeprefix("package://")
        mesh.set("filename", str(found))
    robot.extend(ElementTree.fromstring(f"<robot>{addition}</robot>"))
    return scratch_file(ElementTree.tostring(robot, encoding="unicode"), name, ".urdf")


def scratch_file(text: str, name: str, suffix: str) -> Path:
    """Write a file into a temporary folder that ends with the process.

    Args:
        text: Its content.
        name: Of the file; a digest of the content is added.
        suffix: Of the file.

    Returns:
        Its path.
    """
    digest = hashlib.sha256(text.encode()).hexdigest()[:12]
    path = _scratch(os.getpid()).path / f"{name}-{digest}{suffix}"
    path.write_text(text, encoding="utf-8")
    return path


@cache
def _scratch(process: int) -> Scratch:  # a forked child has one of its own
    scratch = Scratch()
    atexit.register(lambda: os.getpid() == process and scratch.close())
    return scratch
