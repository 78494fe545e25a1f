"""A URDF as others may write one: no masses, velocities or efforts, meshes by package, free wrists."""

from pathlib import Path

CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
    (0, 6, 4), (1, 5, 7), (1, 7, 3),
]  # fmt: skip
LENGTHS = (0.10, 0.30, 0.30, 0.06, 0.06, 0.06)
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
KINDS = ("revolute", "revolute", "revolute", "continuous", "revolute", "continuous")


def ascii_stl(size: tuple[float, float, float]) -> str:
    """A box around the z axis, from z = 0 up, in the text form of STL, which PyBullet cannot read."""
    lines = ["solid link"]
    for face in FACES:
        lines += ["facet normal 0 0 0", "outer loop"]
        for k in face:
            x, y, z = CUBE[k]
            lines.append(f"vertex {(x - 0.5) * size[0]} {(y - 0.5) * size[1]} {z * size[2]}")
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "end solid link", ""])


def linked(name: str, shape: str, origin: str = "0 0 0") -> str:
    """A link with one collision shape."""
    collision = f"<collision><origin xyz='{origin}'/><geometry>{shape}</geometry></collision>"
    return f"<link name='{name}'>{collision}</link>"


def written(folder: Path, *, fingers: bool = False) -> Path:
    """Write a six-joint arm of boxes with a flange `tool0`, and two fingers on it where wanted."""
    meshes = folder / "my_arm" / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    text = "<robot name='my arm'><link name='world'/>" + linked("foot", "<box size='0.12 0.12 0.02'/>")
    text += "<joint name='mount' type='fixed'><parent link='world'/><child link='foot'/></joint>"
    parent, height = "foot", 0.02
    for k, (length, axis, kind) in enumerate(zip(LENGTHS, AXES, KINDS, strict=True)):
        (meshes / f"link{k}.stl").write_text(ascii_stl((0.06, 0.06, 0.9 * length)))
        limit = "<limit lower='-2.6' upper='2.6'/>" if kind == "revolute" else ""
        text += linked(f"link{k}", f"<mesh filename='package://my_arm/meshes/link{k}.stl'/>")
        text += f"<joint name='j{k}' type='{kind}'><parent link='{parent}'/><child link='link{k}'/>"
        text += f"<origin xyz='0 0 {height}'/><axis xyz='{axis}'/>{limit}</joint>"
        parent, height = f"link{k}", length
    text += f"<link name='tool0'/><joint name='flange' type='fixed'><parent link='{parent}'/>"
    text += f"<child link='tool0'/><origin xyz='0 0 {height}'/></joint>"
    for side, sign in (("left", 1), ("right", -1)) if fingers else ():
        text += linked(side, "<box size='0.02 0.01 0.08'/>", f"0 {0.005 * sign} 0.04")
        text += linked(f"{side}_pad", "<box size='0.02 0.002 0.02'/>")
        text += f"<joint name='{side}_fixed' type='fixed'><parent link='{side}'/><child link='{side}_pad'/>"
        text += f"<origin xyz='0 {-0.001 * sign} 0.07'/></joint>"
        text += f"<joint name='{side}_slide' type='prismatic'><parent link='tool0'/><child link='{side}'/>"
        text += f"<axis xyz='0 {sign} 0'/><limit lower='0.002' upper='0.042'/></joint>"
    (folder / "my_arm" / "arm.urdf").write_text(text + "<drake:tag/></robot>")
    return folder / "my_arm" / "arm.urdf"
