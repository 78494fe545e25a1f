"""URDF files made at run time: an arm of another package with links of ours added, mesh paths absolute."""

import hashlib
import os
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from topple.robots.arm.shapes import find_mesh


def composed(source: Path, name: str, addition: str) -> Path:
    """Write a URDF with links and joints added.

    Args:
        source: The URDF to add to.
        name: Name of the robot and of the file.
        addition: XML of the added elements; mesh paths in it are absolute.

    Returns:
        Path of the file, in the user's own temporary folder; its name carries a digest of its content.
    """
    robot = ElementTree.parse(source).getroot()
    robot.set("name", name)
    for mesh in robot.iter("mesh"):
        named = str(mesh.get("filename"))
        found = find_mesh(named, source) or source.parent / named.removeprefix("package://")
        mesh.set("filename", str(found))
    robot.extend(ElementTree.fromstring(f"<robot>{addition}</robot>"))
    return stored(ElementTree.tostring(robot, encoding="unicode"), name, ".urdf")


def stored(text: str, name: str, suffix: str) -> Path:
    """Write a file into the user's own temporary folder.

    Args:
        text: Its content.
        name: Of the file; a digest of the content is added.
        suffix: Of the file.

    Returns:
        Its path.
    """
    digest = hashlib.sha256(text.encode()).hexdigest()[:12]
    folder = Path(tempfile.gettempdir()) / f"topple-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    path = folder / f"{name}-{digest}{suffix}"
    # always written anew: what someone else left under this name is not trusted, and a reader never sees a
    # part
    handle, partial = tempfile.mkstemp(dir=folder, suffix=suffix)
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        stream.write(text)
    os.replace(partial, path)
    return path
