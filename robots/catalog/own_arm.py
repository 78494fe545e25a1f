"""An arm from a URDF file of one's own, with the jaw it has or the tool a gripper file gives it."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import msgspec
import numpy as np
from scipy.spatial import QhullError

from topple.robots.arm.arm import Arm
from topple.robots.arm.arm_chain import arm_chain, hold_still
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.elements import first_of
from topple.robots.arm.gripper import FINGERS, SUCTION, Tool, ToolState
from topple.robots.arm.gripper_file import (
    ArmPart,
    Cup,
    GripperFile,
    Hand,
    Jaw,
    check_names,
    check_values,
    pose_of_offset,
    read_gripper,
)
from topple.robots.arm.home import home_of
from topple.robots.arm.prepared import prepare_urdf
from topple.robots.arm.shapes import geometry_parts
from topple.robots.arm.srdf import Semantics, read_srdf, srdf_beside
from topple.robots.arm.tolerances import ACCELERATION, ANGULAR_ACCELERATION, SHORTEST_ROD
from topple.robots.arm.torques import springs
from topple.robots.arm.tree import Tree
from topple.robots.arm.urdf import Model, model_of, urdf_root
from topple.robots.catalog.data import data_path
from topple.robots.catalog.described import find_urdf
from topple.robots.collision.convex import hull_of
from topple.robots.collision.tolerances import GAIN
from topple.robots.hands.fingers import Fingers, find_fingers, lone_finger, palm_of, rigid_groups
from topple.robots.hands.hinged import hinged_jaw, last_hinge
from topple.robots.hands.jaws import measured_jaw
from topple.robots.hands.mounted import WSG50, flange_of, mount
from topple.robots.hands.suction_hand import CUP_JOINT, CUP_LINK, CupDesign, cup_xml
from topple.robots.hands.tolerances import FORCE
from topple.topology.base.errors import InvalidInput, ToppleError


def arm_from_file(
    path: str | Path,
    gripper: str | Path | GripperFile | Jaw | Cup | None = None,
    *,
    srdf: str | Path | None = None,
    group: str | None = None,
) -> Arm:
    """Make an arm from a URDF file.

    Args:
        path: The URDF.
        gripper: A gripper file or what it would hold, the URDF of a hand, its name, or `wsg50`. Where it
            says nothing of a jaw one is recognised: two fingers at the end of the arm that close on each
            other, driven by one joint which others mimic, or by two sliding joints.
        srdf: Says which joints are the arm and which links are not checked against each other; the file of
            the same name beside the URDF, or in the folder `srdf` or `config` there, where not given.
        group: Name of the SRDF's group that is the arm, where it has several.

    Returns:
        The arm; without a tool where nothing was given and no jaw was recognised. Its home has the hand in
        front of the base, pointing down. Joints that are not the arm's or its hand's hold still.

    Raises:
        InvalidInput: The URDF, the SRDF or the gripper cannot be used; the message says where and what was
            expected.
    """
    path = Path(path).expanduser().resolve()
    robot = urdf_root(path)
    wanted, where = _gripper(gripper)
    # what is put down to the last joint, as in a plan, is not looked for again
    settled = wanted.arm is not None and wanted.arm.joints is not None
    beside = None if settled else srdf_beside(path)
    semantics = read_srdf(srdf) if srdf is not None else None if beside is None else read_srdf(beside)
    wanted, assumed = _whole(robot, path, wanted, semantics, group)
    assumed += _visual_as_collision(robot, path)
    model = model_of(robot, path)
    if not any(link.parts for link in model.links.values()):
        raise InvalidInput(
            f"{path.name}: none of its links has collision geometry, so nothing would keep the arm "
            "clear of anything: expected <collision> in its links, or a <visual> at least that can be read"
        )
    check_names(wanted, model, where)
    model, jaw, fingers = _hinged_jaw(robot, model, wanted)
    fine = () if jaw is None else jaw.links
    if jaw is None:
        fingers = _fingers(model, wanted.jaw)
        jaw = None if fingers is None else measured_jaw(model, fingers, wanted.jaw)
    tools: dict[str, Tool] = {} if jaw is None else {FINGERS: jaw}
    if wanted.cup is not None:
        if CUP_LINK in model.links:
            raise InvalidInput(f"{path.name}: it has a link {CUP_LINK!r} of its own: rename it")
        design, origin = _cup_design(wanted.cup)
        robot.extend(ElementTree.fromstring(f"<robot>{cup_xml(design, wanted.cup.link, origin)}</robot>"))
        tools[SUCTION] = _suction(wanted.cup, design, jaw)
    made, estimated = prepare_urdf(robot, path, {} if fingers is None else rigid_groups(model, fingers), fine)
    frame = _tool_frame(model, fingers, wanted)
    kinds = [joint.kind for joint in model.path_to(frame) if joint.kind != "fixed"]
    acceleration = [ACCELERATION.get(kind, ANGULAR_ACCELERATION) for kind in kinds]
    assumed += (*estimated, _accelerations(path.name), *_guessed_force(model, fingers, wanted))
    arm = Arm.from_urdf(made, frame, tools, name=model.name, acceleration=acceleration, source=path)
    if wanted.arm is not None:
        arm = replace(arm, apart=frozenset(frozenset(pair) for pair in wanted.arm.apart))
    arm = replace(arm, home=home_of(arm, next(iter(tools), None)))
    if weak := springs(arm):
        assumed += (f"springs bear the arm's own weight at {', '.join(weak)}: efforts in {path.name} do not",)
    given = wanted if wanted != GripperFile() else None
    return replace(arm, gripper=given, assumptions=assumed)


def _visual_as_collision(robot: ElementTree.Element, path: Path) -> tuple[str, ...]:
    """Give links that are drawn and have no collision geometry the shapes that they are drawn with.

    Returns:
        What is assumed: that these shapes are theirs, or that they meet nothing where none can be read.
    """
    taken, left = list[str](), list[str]()
    for link in robot.findall("link"):
        visuals = [] if link.find("collision") is not None else link.findall("visual")
        shapes = [visual for visual in visuals if _is_solid(visual, path)]
        for visual in shapes:
            shape = ElementTree.SubElement(link, "collision")
            shape.extend(part for part in visual if part.tag in ("origin", "geometry"))
        if visuals:
            (taken if shapes else left).append(link.get("name", ""))
    links = f"links of {path.name} that are drawn and have no collision geometry"
    return (
        *_said(f"{links} have the shapes that they are drawn with", taken),
        *_said(f"{links} that can be read meet nothing", left),
    )


def _is_solid(visual: ElementTree.Element, path: Path) -> bool:
    """Whether a visual is there and has a volume."""
    missing = list[str]()
    try:
        parts = geometry_parts(visual.find("geometry"), path, path.name, missing, gain=GAIN)
        return bool(parts) and all(len(hull_of(part)[0]) for part in parts)
    except (ToppleError, QhullError):
        return False


def _said(what: str, links: list[str]) -> tuple[str, ...]:
    return (f"{what}: {first_of(links)}",) if links else ()


def _whole(
    robot: ElementTree.Element,
    path: Path,
    wanted: GripperFile,
    semantics: Semantics | None,
    group: str | None,
) -> tuple[GripperFile, tuple[str, ...]]:
    """Hold still what is not the arm, mount the hand, and say what was settled and what was assumed."""
    tree = Tree(robot, path.name)
    part, assumed = wanted.arm, ()
    chain = arm_chain(tree, part, semantics, group)
    if chain is not None:
        rest = {} if part is None else part.rest
        stand = hold_still(robot, chain.still, rest, path.name)
        guessed = [joint for joint in chain.still if joint not in rest]
        if guessed:
            where = ", ".join(f"{joint} at {stand[joint]:g}" for joint in guessed)
            assumed = (f"joints of {path.name} that are not the arm's hold still: {where}",)
    if semantics is not None or part is not None or group is not None:
        apart = [] if part is None else list(part.apart)
        if semantics is not None:
            pairs = {tuple(sorted(two)) for two in semantics.apart if len(two) == 2 and two <= {*tree.links}}
            apart += [(a, b) for a, b in sorted(pairs) if (a, b) not in apart]
        joints = None if chain is None else list(chain.joints)
        rest = {} if part is None else dict(part.rest)
        settled = ArmPart(joints=joints, rest=rest, apart=apart)
        wanted = msgspec.structs.replace(wanted, arm=settled if settled != ArmPart() else None)
    if wanted.hand is not None:
        ends = () if semantics is None else semantics.end_effectors
        links = [end.parent_link for end in ends if end.parent_link in tree.links]
        tip = None if chain is None else chain.tip
        link = wanted.hand.link or (links[0] if len(links) == 1 and chain is None else flange_of(tree, tip))
        data = data_path() if wanted.hand.urdf == WSG50 else None
        wanted = msgspec.structs.replace(wanted, hand=mount(robot, path.name, wanted.hand, link, data))
    return wanted, assumed


def check_tool(arm: Arm) -> None:
    """Refuse an arm that has nothing to take hold with.

    Args:
        arm: The arm.

    Raises:
        InvalidInput: It has no tool; the message says what to write in a gripper file.
    """
    if not arm.tools:
        raise InvalidInput(tool_advice(arm))


def tool_advice(arm: Arm) -> str:
    """Advise what to write in a gripper file for an arm that has no tool."""
    line = f'cup = {{link = "{_last(arm)}", offset = [0.0, 0.0, 0.1], radius = 0.015}}'
    finger = lone_finger(arm.model)
    missing = (
        f"beyond {arm.joints[-1]!r}, its last joint that moves, no finger moves"
        if finger is None
        else f"the finger {finger.child!r}, moved by {finger.name!r}, has none to close on: add the other, or"
    )
    return (
        f"{arm.source.name}: {missing}, so nothing to take hold with: write "
        f"{line} (the lip in the link's frame [m]), or [jaw] with its joints, in a file and give it with "
        "gripper=FILE.toml; gripper=HAND.urdf or wsg50 mounts a hand"
    )


def _last(arm: Arm) -> str:
    """The link farthest down the chain."""
    last = max(arm.frame_of_link)
    return [link for link, frame in zip(arm.links, arm.frame_of_link, strict=True) if frame == last][-1]


def _gripper(gripper: str | Path | GripperFile | Jaw | Cup | None) -> tuple[GripperFile, str]:
    """Read a gripper in any of the accepted forms; also its name in messages."""
    if gripper is None:
        return GripperFile(), "gripper"
    if isinstance(gripper, str | Path):
        named = str(gripper) == WSG50 or str(gripper).endswith(".urdf")
        hand = gripper if named else find_urdf(str(gripper))
        found = read_gripper(gripper) if hand is None else GripperFile(hand=Hand(urdf=str(hand)))
        return found, str(gripper)
    if not isinstance(gripper, GripperFile):  # one part of it, under its name
        gripper = msgspec.structs.replace(GripperFile(), **{type(gripper).__name__.lower(): gripper})
    check_values(gripper, "gripper")
    return gripper, "gripper"


def _fingers(model: Model, jaw: Jaw | None) -> Fingers | None:
    """The moving part of the hand: named, or recognised."""
    return find_fingers(model) if jaw is None else Fingers(palm_of(model, jaw.joints), tuple(jaw.joints))


def _hinged_jaw(
    robot: ElementTree.Element, model: Model, wanted: GripperFile
) -> tuple[Model, Tool | None, Fingers | None]:
    """The model, cut for the jaw of which one finger turns where such is at the end, and that jaw."""
    joint = last_hinge(model)
    if joint is None or (wanted.jaw is not None and wanted.jaw.joints != [joint.name]):
        return model, None, None
    cut = model_of(robot, model.path, fine=(joint.child, joint.parent))
    jaw = hinged_jaw(cut, joint, wanted.jaw)
    return (model, None, None) if jaw is None else (cut, jaw, Fingers(joint.parent, (joint.name,)))


def _cup_design(cup: Cup) -> tuple[CupDesign, str]:
    """The cup's dimensions, lip at the origin, and the attributes of its joint's origin."""
    pose = pose_of_offset(cup.offset)
    area = np.pi * cup.radius**2
    force = 60e3 * area if cup.force is None else cup.force
    height = 4.0 / 3.0 * cup.radius  # of the bellows
    lip = float(pose[:3, 2] @ pose[:3, 3])  # along the cup's axis from the link
    design = CupDesign(
        retracted_lip=-cup.stroke,
        finger_tips=0.0,
        beyond=0.0,
        radius=cup.radius,
        height=height,
        rod_radius=0.4 * cup.radius,
        rod_length=max(lip - height, SHORTEST_ROD),
        vacuum=force / area,
        push=max(60.0, 2.0 * force),
    )
    numbers = [*cup.offset, 0.0, 0.0, 0.0][:6]
    x, y, z = pose[:3, 3] - cup.stroke * pose[:3, 2]
    return design, f"xyz='{x:.9g} {y:.9g} {z:.9g}' rpy='{numbers[3]} {numbers[4]} {numbers[5]}'"


def _suction(cup: Cup, design: CupDesign, jaw: Tool | None) -> Tool:
    """The cup as a tool: a sprung plunger, but drawn in by a drive where fingers are beside it."""
    opening = 0.0 if jaw is None else jaw.ready.opening
    made = SuctionCup(
        CUP_LINK,
        CUP_JOINT,
        stroke=cup.stroke,
        radius=cup.radius,
        max_force=design.holding_force,
        retracts=jaw is not None,
        friction=cup.friction,
    )
    ready = ToolState(opening, cup.stroke)
    return Tool(SUCTION, cup.link, pose_of_offset(cup.offset), made, (CUP_LINK,), ready)


def _tool_frame(model: Model, fingers: Fingers | None, gripper: GripperFile) -> str:
    """The link whose moving ancestors are the arm's joints."""
    if fingers is not None:
        return fingers.palm
    if gripper.cup is not None:
        return gripper.cup.link
    parents = {joint.parent for joint in model.joints.values()}
    leaves = [link for link in model.links if link not in parents]
    return max(leaves, key=lambda link: sum(joint.kind != "fixed" for joint in model.path_to(link)))


def _accelerations(name: str) -> str:
    limits = f"{ANGULAR_ACCELERATION:g} rad/s2 and {ACCELERATION['prismatic']:g} m/s2"
    return f"{name} states no accelerations, as no URDF does: {limits} assumed"


def _guessed_force(model: Model, fingers: Fingers | None, gripper: GripperFile) -> tuple[str, ...]:
    if fingers is None or (gripper.jaw is not None and gripper.jaw.force is not None):
        return ()
    if model.joint(fingers.drivers[0]).effort > 0.0:
        return ()
    return (f"{model.path.name} states no effort of its fingers: {FORCE:g} N assumed",)
