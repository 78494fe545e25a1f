"""A URDF of one's own made fit for PyBullet: the collision geometry that was read, and nothing left out.

PyBullet skips meshes it does not find, reads neither ASCII STL nor `package://` of other folders, invents a
mass of 1 kg where there is none, and drives no joint without an effort. What it is given instead is what
`topple.robots.arm.urdf` read: the same hulls that motions are checked with, masses from them where the file
has none, and drives that move.
"""

import hashlib
import xml.etree.ElementTree as ElementTree
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from topple.robots.arm.compose import scratch_file
from topple.robots.arm.shapes import find_mesh
from topple.robots.arm.tolerances import DENSITY, EFFORT, SPEED, TORQUE, TURNING
from topple.robots.arm.urdf import Model, model_of
from topple.robots.collision.convex import hull_of
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.geometry.rigid import move_points

SHOWN = (".obj", ".stl", ".dae")  # visual meshes that PyBullet draws
LIGHTEST, HEAVIEST = 0.01, 20.0  # [kg] of such a link


def prepare_urdf(
    robot: ElementTree.Element, path: Path, groups: Mapping[str, tuple[str, ...]], fine: Collection[str] = ()
) -> tuple[Path, tuple[str, ...]]:
    """Write a URDF that PyBullet loads as it was read.

    Args:
        robot: The `<robot>` element, with what was added to it.
        path: The file it is from.
        groups: Link -> links fixed to it whose collision geometry becomes part of its own: a finger with its
            pad.
        fine: Links whose meshes are cut finely.

    Returns:
        The file, in the user's own temporary folder, and what had to be assumed, a sentence each.
    """
    model = model_of(robot, path, fine=fine)
    name = str(robot.get("name", path.stem)) or path.stem
    made = ElementTree.Element("robot", name=name)
    carried = _carrying_links(model, groups)
    massless: list[str] = []
    for element in robot.findall("link"):
        made.append(_link(element, model, carried, massless, path))
    assumed = [] if not massless else [f"no masses in {path.name}, estimated: {', '.join(massless)}"]
    slow: list[str] = []
    weak: list[str] = []
    for element in robot.findall("joint"):
        made.append(_joint(element, slow, weak))
    if slow:
        limits = f"{TURNING:g} rad/s or {SPEED['prismatic']:g} m/s assumed"
        assumed.append(f"no velocity limits in {path.name}, {limits}: {', '.join(slow)}")
    if weak:
        limits = f"{TORQUE:g} N m or {EFFORT['prismatic']:g} N assumed"
        assumed.append(f"no efforts in {path.name}, {limits}: {', '.join(weak)}")
    made.extend(robot.findall("material"))
    for material in made.iter("material"):
        for texture in material.findall("texture"):
            material.remove(texture)
    return scratch_file(ElementTree.tostring(made, encoding="unicode"), _plain(name), ".urdf"), tuple(assumed)


def _carrying_links(model: Model, groups: Mapping[str, tuple[str, ...]]) -> dict[str, tuple[str, FloatArray]]:
    """Link -> the link that takes over its collision geometry, and its pose (4, 4) there."""
    found: dict[str, tuple[str, FloatArray]] = {}
    for carrier, links in groups.items():
        poses = {carrier: np.eye(4)}
        for link in links[1:]:
            joint = model.joints[link]
            poses[link] = poses[joint.parent] @ joint.pose_child_to_parent
            found[link] = carrier, poses[link]
    return found


def _link(
    element: ElementTree.Element,
    model: Model,
    carried: Mapping[str, tuple[str, FloatArray]],
    massless: list[str],
    path: Path,
) -> ElementTree.Element:
    """A link with its masses, with visuals that are there, and with the hulls that were read."""
    name = str(element.get("name"))
    made = ElementTree.Element("link", name=name)
    made.extend(element.findall("contact"))
    own = [] if name in carried else list(model.links[name].parts)
    for link, (carrier, pose) in carried.items():
        if carrier == name:
            own += [move_points(part, pose) for part in model.links[link].parts]
    hulls = [hull_of(part) for part in own if len(part)]
    inertial = element.find("inertial")
    if inertial is not None and _has_mass(inertial):
        made.append(inertial)
    else:
        made.append(_inertial([vertices for vertices, _ in hulls]))
        if name in model.joints and hulls:
            massless.append(name)
    for visual in element.findall("visual"):
        mesh = visual.find("geometry/mesh")
        if mesh is not None:
            file = find_mesh(str(mesh.get("filename")), path)
            if file is None or file.suffix.lower() not in SHOWN:
                continue
            mesh.set("filename", str(file))
        made.append(visual)
    for vertices, faces in hulls:
        collision = ElementTree.SubElement(made, "collision")
        geometry = ElementTree.SubElement(collision, "geometry")
        ElementTree.SubElement(geometry, "mesh", filename=str(_mesh_file(vertices, faces)))
    return made


def _has_mass(inertial: ElementTree.Element) -> bool:
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        return False
    numbers = [mass.get("value"), *(inertia.get(key) for key in ("ixx", "iyy", "izz"))]
    try:
        return all(float(number or 0.0) > 0.0 for number in numbers)
    except ValueError:
        return False


def _inertial(hulls: list[FloatArray]) -> ElementTree.Element:
    """Mass and inertia of the box around hulls, with the density of an arm."""
    points = np.concatenate([np.zeros((1, 3))] if not hulls else hulls)
    size, centre = np.ptp(points, axis=0), (points.min(axis=0) + points.max(axis=0)) / 2.0
    mass = float(np.clip(DENSITY * np.prod(size) / 2.0, LIGHTEST, HEAVIEST))
    square = np.maximum(size, 0.02) ** 2
    inertia = mass / 12.0 * (square.sum() - square)
    made = ElementTree.Element("inertial")
    ElementTree.SubElement(made, "origin", xyz=" ".join(f"{x:.6g}" for x in centre))
    ElementTree.SubElement(made, "mass", value=f"{mass:.6g}")
    axes = zip(("ixx", "iyy", "izz"), inertia, strict=True)
    ElementTree.SubElement(
        made, "inertia", {key: f"{value:.6g}" for key, value in axes} | {"ixy": "0", "ixz": "0", "iyz": "0"}
    )
    return made


def _joint(element: ElementTree.Element, slow: list[str], weak: list[str]) -> ElementTree.Element:
    """A joint that moves: with a velocity limit and an effort."""
    kind, name = str(element.get("type")), str(element.get("name"))
    if kind == "fixed":
        return element
    limit = element.find("limit")
    if limit is None:
        limit = ElementTree.SubElement(element, "limit")
    driven = element.find("mimic") is None
    if not float(limit.get("velocity") or 0.0) > 0.0:
        limit.set("velocity", str(SPEED.get(kind, TURNING)))
        slow += [name] if driven else []
    if not float(limit.get("effort") or 0.0) > 0.0:
        limit.set("effort", str(EFFORT.get(kind, TORQUE)))
        weak += [name] if driven else []
    return element


def _mesh_file(vertices: FloatArray, faces: IntArray) -> Path:
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return scratch_file("\n".join(lines) + "\n", "hull", ".obj")


def _plain(name: str) -> str:
    """A name that is safe as a file's."""
    plain = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in name)
    return plain or hashlib.sha256(name.encode()).hexdigest()[:8]
