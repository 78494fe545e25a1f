"""The moving part of a hand in a URDF: where an arm ends and fingers begin, and which links move together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from topple.robots.arm.elements import first_of
from topple.robots.arm.tolerances import SERIES
from topple.robots.arm.urdf import Joint, Model
from topple.robots.hands.tolerances import LONGEST_STROKE
from topple.topology.base.errors import InvalidInput


@dataclass(frozen=True)
class Fingers:
    """The moving part of a hand.

    Attributes:
        palm: Link the fingers are mounted on.
        drivers: Names of the joints that are driven, one or two; others mimic them.
    """

    palm: str
    drivers: tuple[str, ...]


def find_fingers(model: Model) -> Fingers | None:
    """Find where the arm ends and a jaw begins.

    The arm is the chain from the root to the first link at which moving parts branch; all that moves beyond
    has to hang on one joint, or on two sliding ones.

    Args:
        model: The URDF.

    Returns:
        The fingers, or None where moving parts branch nowhere behind the second joint.

    Raises:
        InvalidInput: Parts branch there, and are no two fingers on one drive; the message names the joint.
    """
    children = children_of(model)
    link, above = model.root, 0
    while True:
        branches = [child for child in children[link] if _moving_joints(model, children, child)]
        if len(branches) != 1:
            break
        link = branches[0]
        above += model.joints[link].kind != "fixed"
    if not branches or above < 2:
        return None
    joints = [joint for branch in branches for joint in _moving_joints(model, children, branch)]
    drivers = [joint for joint in joints if joint.mimic is None]
    names = [joint.name for joint in drivers]
    for joint in joints:
        if joint.mimic is None and not joint.lower < joint.upper:
            raise InvalidInput(
                f"{model.path.name}: the finger joint {joint.name!r} has limits of {joint.lower:g} and "
                f"{joint.upper:g}, so {joint.child!r} cannot move: expected how far it does"
            )
        if joint.mimic is not None and joint.mimic.joint not in names:
            raise InvalidInput(
                f"{model.path.name}: the finger joint {joint.name!r} mimics {joint.mimic.joint!r}: expected "
                f"a joint of the hand that is driven itself, one of {', '.join(names) or 'none'}"
            )
    pair = len(drivers) == 2 == len(joints) and all(joint.kind == "prismatic" for joint in joints)
    if not pair and (len(drivers) != 1 or len(joints) < 2):
        raise InvalidInput(
            f"{model.path.name}: {link!r} carries {len(branches)} moving parts, driven by {first_of(names)}: "
            "expected two fingers on one joint which others <mimic>, or on two that slide; name those that "
            "close in [jaw] joints of a gripper file, or the arm's in [arm] joints, and these hold still"
        )
    return Fingers(link, tuple(names))


def lone_finger(model: Model) -> Joint | None:
    """The last joint of an arm, if it slides no farther than a finger does; None if not."""
    joints = [joint for joint in model.joints.values() if joint.kind != "fixed"]
    last = max(joints, key=lambda joint: len(model.path_to(joint.child)))
    short = last.kind == "prismatic" and last.upper - last.lower <= LONGEST_STROKE
    return last if short and len(joints) > SERIES else None


def palm_of(model: Model, drivers: Sequence[str]) -> str:
    """The link nearest the tip that carries all joints which some joints drive."""
    joints = [model.joint(name) for name in drivers]
    joints += [j for j in model.joints.values() if j.mimic is not None and j.mimic.joint in drivers]
    paths = [[model.root, *(joint.child for joint in model.path_to(joint.parent))] for joint in joints]
    shared = [links[0] for links in zip(*paths, strict=False) if len(set(links)) == 1]
    return shared[-1]


def rigid_groups(model: Model, fingers: Fingers) -> dict[str, tuple[str, ...]]:
    """Moving link of the hand -> the links which are fixed to it, itself among them."""
    children = children_of(model)
    groups: dict[str, list[str]] = {}
    waiting = [(child, "") for child in children[fingers.palm]]
    while waiting:
        link, carrier = waiting.pop(0)
        carrier = link if moves(model.joints[link], fingers) else carrier
        if carrier:
            groups.setdefault(carrier, []).append(link)
        waiting += [(child, carrier) for child in children[link]]
    return {carrier: tuple(links) for carrier, links in groups.items()}


def moves(joint: Joint, fingers: Fingers) -> bool:
    """Whether a joint is driven by, or mimics, one of the fingers' joints."""
    followed = joint.name if joint.mimic is None else joint.mimic.joint
    return joint.kind != "fixed" and (joint.name in fingers.drivers or followed in fingers.drivers)


def children_of(model: Model) -> dict[str, list[str]]:
    """Link -> the links whose joints hang on it."""
    children: dict[str, list[str]] = {link: [] for link in model.links}
    for child, joint in model.joints.items():
        children[joint.parent].append(child)
    return children


def _moving_joints(model: Model, children: Mapping[str, Sequence[str]], link: str) -> list[Joint]:
    """The joints that move in the branch of a link, its own among them."""
    found: list[Joint] = []
    waiting = [link]
    while waiting:
        name = waiting.pop(0)
        if model.joints[name].kind != "fixed":
            found.append(model.joints[name])
        waiting += children[name]
    return found
