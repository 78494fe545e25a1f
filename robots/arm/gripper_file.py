"""The small file that says what an arm of one's own holds with, and which part of a robot is the arm."""

import importlib
import math
import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from topple.robots.arm.elements import pose_from_xyz_rpy
from topple.robots.arm.tolerances import CUP_FRICTION, MOST_BYTES
from topple.robots.arm.urdf import Model
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import open_file

EXAMPLE = (
    '[cup] with link = "LINK", offset = [0, 0, 0.1] and radius = 0.015, or [jaw] with joints = ["JOINT"]'
)


class Jaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A parallel jaw; what is left out is measured on the fingers' collision geometry.

    Attributes:
        joints: The joint that moves the fingers, or both of them; joints that mimic these follow.
        links: The two finger links that touch what is held.
        link: Tool link, which carries the frame; the link the fingers are mounted on where left out.
        offset: Pose of the tool frame in it, x y z [m] or x y z roll pitch yaw [m, rad]: origin between the
            pads, z out of the hand, y the closing direction.
        closed: Values of `joints` with the pads together [m] or [rad].
        open: The same with the pads apart.
        opening: Distance of the pads closed and open [m].
        pads: Extent of a pad along the frame's x and z [m].
        force: Largest closing force held continuously [N].
        friction: Of the pads against common goods.
    """

    joints: list[str]
    links: list[str] | None = None
    link: str | None = None
    offset: list[float] | None = None
    closed: list[float] | None = None
    open: list[float] | None = None
    opening: list[float] | None = None
    pads: list[float] | None = None
    force: float | None = None
    friction: float = 1.0


class Cup(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A suction cup on a sprung plunger, added to a link.

    Attributes:
        link: Tool link, which the cup is mounted on.
        offset: Pose of the lip in it with nothing pressing, x y z [m] or x y z roll pitch yaw [m, rad]; z is
            the direction in which the cup points.
        radius: Of the lip [m].
        force: Pull at which it lets go [N]; 60 kPa on the lip's area where left out.
        stroke: How far the plunger gives way [m].
        friction: Between lip and common goods, dry.
    """

    link: str
    offset: list[float]
    radius: float
    force: float | None = None
    stroke: float = 0.02
    friction: float = CUP_FRICTION


class Hand(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A hand that is described apart from the arm, mounted on a link of it.

    Attributes:
        urdf: Its file, relative to the gripper file; or `wsg50`, which comes with topple.
        link: The arm's link it is mounted on; `tool0`, or the last link of the arm, where left out.
        offset: Pose of its root link there, x y z [m] or x y z roll pitch yaw [m, rad].
        sha256: Digest of the file, where it is to be that very one.
    """

    urdf: str
    link: str | None = None
    offset: list[float] | None = None
    sha256: str | None = None


class ArmPart(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Which joints of a robot are the arm; all others hold still. Found in the URDF or SRDF where left out.

    Attributes:
        tip: Its last link: every moving joint before it is the arm's, but those in `rest`.
        joints: Names of its joints, in place of the tip.
        rest: Where joints that hold still do so [rad] or [m]; zero, or the limit next to it, where left out.
        apart: Pairs of links that are not checked against each other.
    """

    tip: str | None = None
    joints: list[str] | None = None
    rest: dict[str, float] = {}
    apart: list[tuple[str, str]] = []


class GripperFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What a gripper file holds.

    Attributes:
        jaw: The parallel jaw; recognised from the URDF where left out.
        cup: The suction cup.
        hand: A hand from a file of its own.
        arm: Which part of the robot is the arm.
    """

    jaw: Jaw | None = None
    cup: Cup | None = None
    hand: Hand | None = None
    arm: ArmPart | None = None


def read_gripper(path: str | Path) -> GripperFile:
    """Read a gripper file.

    Args:
        path: A TOML file with tables `[jaw]`, `[cup]`, `[hand]`, `[arm]`, at least one of them; see `Jaw`,
            `Cup`, `Hand` and `ArmPart` for their keys.

    Returns:
        What it says, lengths and signs checked.

    Raises:
        InvalidInput: The file cannot be read or is not TOML, a key is unknown or missing, or a value has the
            wrong type, length or sign; the message has the path of the key.
    """
    tomllib: Any = importlib.import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
    path = Path(path)
    try:
        with open_file(path, str(path)) as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise InvalidInput(
            f"{path}: cannot be read ({error.strerror}); give the path of a TOML file"
        ) from error
    if len(content) > MOST_BYTES:
        raise InvalidInput(
            f"{path}: more than {MOST_BYTES} bytes: expected a file that describes one gripper"
        )
    try:
        document: dict[str, Any] = tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:  # broken, no text, numbers without end, nested without end
        raise InvalidInput(f"{path}: not TOML ({error})") from error
    try:
        gripper = msgspec.convert(document, GripperFile)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"{path}: {error}") from error
    check_values(gripper, str(path))
    hand = gripper.hand
    if hand is not None and hand.urdf.endswith(".urdf"):
        found = path.parent / Path(hand.urdf).expanduser()
        gripper = msgspec.structs.replace(gripper, hand=msgspec.structs.replace(hand, urdf=str(found)))
    return gripper


def check_values(gripper: GripperFile, where: str) -> None:
    """Refuse values that types cannot exclude.

    Args:
        gripper: The gripper.
        where: What to call it in messages.

    Raises:
        InvalidInput: A list has the wrong length, or a number is not finite or not positive.
    """
    jaw, cup, arm = gripper.jaw, gripper.cup, gripper.arm
    if gripper == GripperFile():
        raise InvalidInput(f"{where}: no tool in it: write {EXAMPLE}")
    if jaw is not None:
        if len(jaw.joints) not in (1, 2):
            raise InvalidInput(f"{where}: `$.jaw.joints` names {len(jaw.joints)} joints, expected 1 or 2")
        if jaw.links is not None and len(set(jaw.links)) != 2:
            raise InvalidInput(f"{where}: `$.jaw.links` is {jaw.links}, expected the two finger links")
        _offset(jaw.offset, f"{where}: `$.jaw.offset`")
        for key, ends in (("closed", jaw.closed), ("open", jaw.open)):
            _numbers(ends, (len(jaw.joints),), f"{where}: `$.jaw.{key}`", "one value for each joint")
        if jaw.closed is not None and jaw.open is not None and not _differ(jaw.closed, jaw.open):
            raise InvalidInput(f"{where}: `$.jaw.open` and `$.jaw.closed` are the same for a joint")
        _numbers(jaw.opening, (2,), f"{where}: `$.jaw.opening`", "the pads' distance closed and open")
        if jaw.opening is not None and not 0.0 <= jaw.opening[0] < jaw.opening[1]:
            raise InvalidInput(f"{where}: `$.jaw.opening` is {jaw.opening}, expected 0 <= closed < open [m]")
        _numbers(jaw.pads, (2,), f"{where}: `$.jaw.pads`", "a pad's extent along x and z")
        for key, value in (("friction", jaw.friction), ("force", jaw.force), *_each("pads", jaw.pads)):
            _positive(value, f"{where}: `$.jaw.{key}`")
    if cup is not None:
        _offset(cup.offset, f"{where}: `$.cup.offset`")
        for key in ("radius", "force", "stroke", "friction"):
            _positive(getattr(cup, key), f"{where}: `$.cup.{key}`")
    if gripper.hand is not None:
        _offset(gripper.hand.offset, f"{where}: `$.hand.offset`")
    if arm is not None:
        if arm.tip is not None and arm.joints is not None:
            raise InvalidInput(f"{where}: `$.arm` has a tip and joints, expected one of them")
        if arm.joints is not None and not arm.joints:
            raise InvalidInput(f"{where}: `$.arm.joints` is empty, expected the arm's joints, base first")
        for joint, value in arm.rest.items():
            if not math.isfinite(value):
                raise InvalidInput(f"{where}: `$.arm.rest.{joint}` is {value}, expected a finite number")


def check_names(gripper: GripperFile, model: Model, where: str) -> None:
    """Refuse links and joints that are not there.

    Args:
        gripper: The gripper.
        model: The arm's URDF.
        where: What to call the gripper in messages.

    Raises:
        InvalidInput: A name is unknown; the message lists the known ones.
    """
    jaw, cup = gripper.jaw, gripper.cup
    joints = [joint.name for joint in model.joints.values() if joint.kind != "fixed"]
    if jaw is not None:
        for name in jaw.joints:
            if name not in joints:
                raise InvalidInput(
                    f"{where}: `$.jaw.joints` names {name!r}: {model.path.name} moves {', '.join(joints)}"
                )
    named = [] if jaw is None else [("jaw.links", name) for name in jaw.links or ()]
    named += [] if jaw is None or jaw.link is None else [("jaw.link", jaw.link)]
    named += [] if cup is None else [("cup.link", cup.link)]
    for key, name in named:
        if name not in model.links:
            raise InvalidInput(
                f"{where}: `$.{key}` names {name!r}: {model.path.name} has {', '.join(model.links)}"
            )


def pose_of_offset(offset: list[float]) -> FloatArray:
    """The (4, 4) pose of an offset: x y z [m], or x y z roll pitch yaw [m, rad]."""
    numbers = np.array([*offset, 0.0, 0.0, 0.0][:6])
    return pose_from_xyz_rpy(numbers[:3], numbers[3:])


def _offset(offset: list[float] | None, where: str) -> None:
    _numbers(offset, (3, 6), where, "x y z [m] or x y z roll pitch yaw [m, rad]")


def _numbers(numbers: list[float] | None, lengths: tuple[int, ...], where: str, words: str) -> None:
    if numbers is None:
        return
    if len(numbers) not in lengths or not all(math.isfinite(number) for number in numbers):
        many = " or ".join(map(str, lengths))
        raise InvalidInput(f"{where} is {numbers}, expected {many} finite numbers: {words}")


def _positive(value: float | None, where: str) -> None:
    if value is not None and not (math.isfinite(value) and value > 0.0):
        raise InvalidInput(f"{where} is {value}, expected a finite number above 0")


def _differ(a: list[float], b: list[float]) -> bool:
    return all(abs(one - other) > 1e-6 for one, other in zip(a, b, strict=True))


def _each(key: str, numbers: list[float] | None) -> list[tuple[str, float | None]]:
    return [(f"{key}[{i}]", number) for i, number in enumerate(numbers or ())]
