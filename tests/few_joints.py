"""Arms of four joints, as URDF files: a SCARA and a gantry, each with a jaw that points straight down."""

from pathlib import Path

LINK = """<link name="{name}"><inertial><origin xyz="{at}"/><mass value="{mass}"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision></link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{at}" rpy="{rpy}"/><axis xyz="{axis}"/>
<limit lower="{low}" upper="{high}" effort="200" velocity="{speed}"/></joint>"""


def _link(name: str, at: str, size: str, mass: float = 1.0) -> str:
    return LINK.format(name=name, at=at, size=size, mass=mass)


def _joint(
    name: str, kind: str, pair: str, at: str, axis: str, low: float, high: float, rpy: str = "0 0 0"
) -> str:
    parent, child = pair.split()
    return JOINT.format(
        name=name, kind=kind, parent=parent, child=child, at=at, axis=axis, low=low, high=high, rpy=rpy,
        speed=0.2 if parent == "hand" else 1.5,
    )  # fmt: skip


HAND = (
    _link("flange", "0 0 0.005", "0.04 0.04 0.01")
    + _joint("mount", "fixed", "flange hand", "0 0 0", "0 0 1", 0, 0, "3.14159265 0 0")
    + _link("hand", "0 0 0.02", "0.05 0.12 0.04")
    + _link("left", "0 0.006 0.03", "0.02 0.012 0.06", 0.05)
    + _link("right", "0 -0.006 0.03", "0.02 0.012 0.06", 0.05)
    + _joint("jaw_left", "prismatic", "hand left", "0 0 0.04", "0 1 0", 0.0, 0.04)
    + _joint("jaw_right", "prismatic", "hand right", "0 0 0.04", "0 -1 0", 0.0, 0.04)
)
SCARA = (
    _link("base", "0 0 0.2", "0.15 0.15 0.4")
    + _joint("shoulder", "revolute", "base upper", "0 0 0.42", "0 0 1", -2.3, 2.3)
    + _link("upper", "0.15 0 0.03", "0.36 0.1 0.05")
    + _joint("elbow", "revolute", "upper fore", "0.3 0 0.06", "0 0 1", -2.5, 2.5)
    + _link("fore", "0.13 0 0.03", "0.33 0.1 0.05")
    + _joint("quill", "prismatic", "fore ram", "0.26 0 -0.04", "0 0 -1", 0.0, 0.22)
    + _link("ram", "0 0 0.1", "0.03 0.03 0.25")
    + _joint("wrist", "revolute", "ram flange", "0 0 -0.04", "0 0 1", -3.1, 3.1)
)
GANTRY = (
    _link("frame", "0 -0.6 0.9", "1.4 0.05 0.05")
    + _joint("x", "prismatic", "frame bridge", "0 0 0.95", "1 0 0", -0.45, 0.45)
    + _link("bridge", "0 0 0.05", "0.06 1.2 0.06")
    + _joint("y", "prismatic", "bridge cart", "0.08 0 0", "0 1 0", -0.45, 0.45)
    + _link("cart", "0 0 0.05", "0.08 0.1 0.1")
    + _joint("z", "prismatic", "cart ram", "0.08 0 0", "0 0 -1", 0.0, 0.55)
    + _link("ram", "0 0 0.25", "0.05 0.05 0.6")
    + _joint("yaw", "revolute", "ram flange", "0 0 -0.06", "0 0 1", -3.1, 3.1)
)


def written(name: str, folder: Path) -> Path:
    """Write the file of "scara" or "gantry" into a folder."""
    path = folder / f"{name}.urdf"
    path.write_text(f'<robot name="{name}">{ {"scara": SCARA, "gantry": GANTRY}[name] }{HAND}</robot>')
    return path
