"""A parallel jaw of a URDF, measured: two fingers that close on each other.

What a jaw needs to be known for (where its pads are, how far they open at which joint values) follows from
the finger joints and the fingers' collision geometry.
"""

from collections.abc import Mapping, Sequence
from typing import NoReturn

import numpy as np

from topple.robots.arm.gripper import Tool
from topple.robots.arm.gripper_file import Jaw, pose_of_offset
from topple.robots.arm.jaw import ParallelJaw
from topple.robots.arm.kinematics import joint_value, pose_of_joint
from topple.robots.arm.urdf import Model
from topple.robots.collision.convex import section
from topple.robots.hands.fingers import Fingers, moves, rigid_groups
from topple.robots.hands.tolerances import (
    FLAT,
    FORCE,
    LEAST_PAD,
    LEAST_STROKE,
    LONGEST_PAD,
    OVERLAP,
    SAMPLES,
    SNAP,
    STRONGEST,
    TIP,
    USUAL_PAD,
)
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points


def measured_jaw(model: Model, fingers: Fingers, given: Jaw | None = None) -> Tool:
    """Measure a jaw.

    Args:
        model: The URDF.
        fingers: Its moving part.
        given: What is known of it and need not be measured.

    Returns:
        The tool "fingers".

    Raises:
        InvalidInput: The parts are no two fingers that close on each other, or have no shape; the message
            names them.
    """
    given = given or Jaw(joints=list(fingers.drivers))
    hand = _Hand(model, fingers)
    if given.links is None:
        links = hand.closing_pair()
    else:
        links = (hand.carrier(given.links[0]), hand.carrier(given.links[1]))
    if links is None:
        hand.refuse_parts()
    return hand.tool(links, *hand.ends(links, given), given)


class _Hand:
    """The links of a hand in the frame of its palm."""

    def __init__(self, model: Model, fingers: Fingers) -> None:
        self._model, self._fingers = model, fingers
        self._groups = rigid_groups(model, fingers)
        self._drivers = [model.joint(name) for name in fingers.drivers]

    def carrier(self, link: str) -> str:
        """The moving link that a link is fixed to."""
        for carrier, links in self._groups.items():
            if link in links:
                if not len(self._shape(carrier)):
                    raise InvalidInput(
                        f"{self._model.path.name}: the finger {link!r} has no collision geometry: add some"
                    )
                return carrier
        raise InvalidInput(
            f"{self._model.path.name}: the joints {', '.join(self._fingers.drivers)} do not move {link!r}; "
            f"they move {', '.join(self._groups)}"
        )

    def refuse_parts(self) -> NoReturn:
        """Refuse a hand of which no two parts close on each other, by what keeps them from it."""
        groups, drivers = [*self._groups], ", ".join(self._fingers.drivers)
        if bare := [carrier for carrier in groups if not self._shape(carrier)]:
            raise InvalidInput(
                f"{self._model.path.name}: what {drivers} would close has no shape, "
                f"neither collision geometry nor a drawn one: add <collision> to {', '.join(bare)}"
            )
        if len(groups) == 1:
            self._refuse(f"are {groups[0]!r} alone, which closes on nothing that moves: add the other, or")
        last = self._model.joints[groups[-1]].name
        self._refuse(
            f"({', '.join(groups)}) keep their distance: turn the <axis> or the <mimic> of {last!r} round, or"
        )

    def _shape(self, carrier: str) -> list[FloatArray]:
        """Vertices (V, 3) of the convex parts of a rigid group in the frame of its moving link."""
        poses = {carrier: np.eye(4)}
        found = [*self._model.links[carrier].parts]
        for link in self._groups[carrier][1:]:
            joint = self._model.joints[link]
            poses[link] = poses[joint.parent] @ joint.pose_child_to_parent
            found += [move_points(part, poses[link]) for part in self._model.links[link].parts]
        return found

    def _parts(self, carrier: str, values: Mapping[str, float]) -> list[FloatArray]:
        """The parts of a rigid group in the palm's frame at values of the driven joints."""
        pose, link = np.eye(4), carrier
        while link != self._fingers.palm:
            joint = self._model.joints[link]
            pose, link = pose_of_joint(joint, joint_value(joint, values)) @ pose, joint.parent
        return [move_points(part, pose) for part in self._shape(carrier)]

    def _middle(self, carrier: str, values: Mapping[str, float]) -> FloatArray:
        """Middle of a group's extent (3,) in the palm's frame."""
        return _middle_of(self._parts(carrier, values))

    def _corners(self) -> list[dict[str, float]]:
        """The driven joints at their limits, in all combinations."""
        found: list[dict[str, float]] = [{}]
        for joint in self._drivers:
            found = [{**values, joint.name: end} for values in found for end in (joint.lower, joint.upper)]
        return found

    def closing_pair(self) -> tuple[str, str] | None:
        """The two groups farthest out of the palm that move towards each other, None where there are none."""
        shaped = [carrier for carrier in self._groups if len(self._shape(carrier))]
        best: tuple[float, tuple[str, str]] | None = None
        centre, corners = self._palm_middle(), self._corners()
        for i, a in enumerate(shaped):
            for b in shaped[:i]:
                if self._branch(a) == self._branch(b):
                    continue
                apart = [self._middle(a, values) - self._middle(b, values) for values in corners]
                ways = [float(np.linalg.norm(way)) for way in apart]
                if max(ways) - min(ways) < LEAST_STROKE:
                    continue
                across = apart[int(np.argmax(ways))] / max(ways)
                values = corners[int(np.argmin(ways))]
                middle = (self._middle(a, values) + self._middle(b, values)) / 2.0 - centre
                out = float(np.linalg.norm(middle - across * float(across @ middle)))
                if best is None or out > best[0] + 1e-6:
                    best = (out, (b, a))
        return None if best is None else best[1]

    def _branch(self, carrier: str) -> str:
        """The child of the palm that a group hangs on."""
        link = carrier
        while self._model.joints[link].parent != self._fingers.palm:
            link = self._model.joints[link].parent
        return link

    def _palm_middle(self) -> FloatArray:
        return _middle_of(self._model.links[self._fingers.palm].parts)

    def ends(self, links: tuple[str, str], given: Jaw) -> tuple[dict[str, float], dict[str, float]]:
        """Values of the driven joints with the fingers together and apart."""
        names = self._fingers.drivers
        if given.closed is not None and given.open is not None:
            return dict(zip(names, given.closed, strict=True)), dict(zip(names, given.open, strict=True))
        corners = self._corners()
        apart = [
            float(np.linalg.norm(self._middle(links[0], values) - self._middle(links[1], values)))
            for values in corners
        ]
        wide = corners[int(np.argmax(apart))]
        shut = {joint.name: joint.lower + joint.upper - wide[joint.name] for joint in self._drivers}
        if given.closed is not None:
            shut = dict(zip(names, given.closed, strict=True))
        if given.open is not None:
            wide = dict(zip(names, given.open, strict=True))
        return shut, wide

    def tool(
        self, links: tuple[str, str], shut: dict[str, float], wide: dict[str, float], given: Jaw
    ) -> Tool:
        """The measured tool; what is given goes before what is measured."""
        first, second = links
        across = self._middle(first, wide) - self._middle(second, wide)
        across -= self._middle(first, shut) - self._middle(second, shut)
        if np.linalg.norm(across) < LEAST_STROKE:
            self._refuse("do not move against each other:")
        across = snap_to_axis(across)
        if float((self._middle(first, wide) - self._middle(second, wide)) @ across) < 0.0:
            first, second = second, first
        between = (self._middle(first, wide) + self._middle(second, wide)) / 2.0 - self._palm_middle()
        out = snap_to_axis(between - across * float(across @ between))
        out -= across * float(across @ out)
        out /= np.linalg.norm(out)
        turn = np.column_stack([np.cross(across, out), across, out])
        share = np.linspace(0.0, 1.0, SAMPLES)
        states = [{name: shut[name] + s * (wide[name] - shut[name]) for name in shut} for s in share]
        tips = [self._tips(first, second, values, turn) for values in states]
        gaps = np.array([_gap(*each) for each in tips])
        ends = np.array([max(float(tip[:, 2].max()) for tip in each) for each in tips])
        if given.links is None and (third := self._third(links, wide)):
            self._refuse(f"are three, {first}, {second} and {third}, where two are expected to close:")
        if given.opening is not None:
            gaps = np.interp(share, [0.0, 1.0], given.opening)
        keep = np.flatnonzero(gaps > -OVERLAP)
        keep = keep[max(np.count_nonzero(gaps[keep] <= 0.0) - 1, 0) :]  # closed in one state
        if len(keep) < 2 or not (np.diff(gaps[keep]) > 0).all() or np.ptp(gaps[keep]) < LEAST_STROKE:
            self._refuse("do not close on each other:")
        half = int(keep[len(keep) // 2])
        pose, pads = self._frame(first, second, states[half], turn)
        arc = np.round(ends[keep] - ends[half], 6)
        link, pose = self._mount(given, pose)
        moving = self._moving_joints(shut, wide)
        jaw = ParallelJaw(
            joints=moving,
            links=(first, second),
            openings=np.maximum(gaps[keep], 0.0),
            joint_values=np.array([[self._value(name, states[k]) for name in moving] for k in keep]),
            force=self._force(gaps, states) if given.force is None else given.force,
            pad_size=pads if given.pads is None else (given.pads[0], given.pads[1]),
            friction=given.friction,
            arc=arc if arc.any() else None,
        )
        hand = tuple(carrier for carrier in self._groups if carrier not in jaw.links)
        return Tool.of(jaw, link, pose, *hand)

    def _third(self, links: tuple[str, str], values: Mapping[str, float]) -> str | None:
        """A part of the open hand as far out as its two fingers, and on neither's branch."""
        centre, taken = self._palm_middle(), {self._branch(link) for link in links}
        ends = {
            carrier: max(float(np.linalg.norm(part - centre, axis=1).max()) for part in parts)
            for carrier in self._groups
            if (parts := self._parts(carrier, values))
        }
        least = min(ends[link] for link in links) - LEAST_STROKE
        return next((c for c, end in ends.items() if end > least and self._branch(c) not in taken), None)

    def _tips(
        self, first: str, second: str, values: Mapping[str, float], turn: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Vertices of the outer part of both fingers, along the axes of the tool frame."""
        found: list[FloatArray] = []
        for carrier in (first, second):
            parts = [part @ turn for part in self._parts(carrier, values)]
            low, high = min(part[:, 2].min() for part in parts), max(part[:, 2].max() for part in parts)
            found.append(np.concatenate([_above(part, high - TIP * (high - low)) for part in parts]))
        return found[0], found[1]

    def _frame(
        self, first: str, second: str, values: Mapping[str, float], turn: FloatArray
    ) -> tuple[FloatArray, tuple[float, float]]:
        """Pose of the tool frame in the palm and extents of the pads along x and z [m]."""
        inner, outer = self._tips(first, second, values, turn)
        y, other = inner[:, 1], outer[:, 1]
        low, high = np.zeros(3), np.zeros(3)
        for flat in FLAT:
            faces = [inner[y <= y.min() + flat], outer[other >= other.max() - flat]]
            low = np.max([face.min(axis=0) for face in faces], axis=0)
            high = np.min([face.max(axis=0) for face in faces], axis=0)
            if (high - low)[[0, 2]].min() >= USUAL_PAD:
                break
        low[2] = max(low[2], high[2] - LONGEST_PAD)
        centre = (low + high) / 2.0
        centre[1] = (y.min() + other.max()) / 2.0
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, turn @ centre
        size = np.maximum(high - low, LEAST_PAD)
        return pose, (float(size[0]), float(size[2]))

    def _mount(self, given: Jaw, pose_in_palm: FloatArray) -> tuple[str, FloatArray]:
        """The tool link and the frame's pose in it."""
        palm = self._fingers.palm
        if given.link is None or given.link == palm:
            pose = pose_in_palm if given.offset is None else pose_of_offset(given.offset)
            return palm, pose
        if given.offset is not None:
            return given.link, pose_of_offset(given.offset)
        (anchor, to_anchor), (other, palm_to_anchor) = self._anchor(given.link), self._anchor(palm)
        if anchor != other:
            self._refuse(f"are not fixed to the link {given.link!r}, so its `offset` must be given:")
        return given.link, inverse(to_anchor) @ palm_to_anchor @ pose_in_palm

    def _anchor(self, link: str) -> tuple[str, FloatArray]:
        """The moving link that a link is fixed to, and its pose (4, 4) there."""
        pose = np.eye(4)
        while link in self._model.joints and self._model.joints[link].kind == "fixed":
            joint = self._model.joints[link]
            pose, link = joint.pose_child_to_parent @ pose, joint.parent
        return link, pose

    def _moving_joints(self, shut: Mapping[str, float], wide: Mapping[str, float]) -> tuple[str, ...]:
        """The driven joints and those that mimic them, as far as they move."""
        hand = [joint.name for joint in self._model.joints.values() if moves(joint, self._fingers)]
        ordered = [*self._fingers.drivers, *(name for name in hand if name not in self._fingers.drivers)]
        return tuple(
            name for name in ordered if abs(self._value(name, wide) - self._value(name, shut)) > 1e-6
        )

    def _value(self, name: str, values: Mapping[str, float]) -> float:
        return joint_value(self._model.joint(name), values)

    def _force(self, gaps: FloatArray, states: Sequence[Mapping[str, float]]) -> float:
        """Convert the joint's effort to a force at the pads [N]: of a turning joint over its lever."""
        joint = self._drivers[0]
        if not joint.effort > 0.0:
            return FORCE
        lever = 1.0
        if joint.kind != "prismatic":
            turned = abs(states[-1][joint.name] - states[0][joint.name])
            lever = max(float(gaps[-1] - gaps[0]) / 2.0 / turned, 1e-3)
        return float(min(joint.effort / lever, STRONGEST))

    def _refuse(self, words: str) -> NoReturn:
        raise InvalidInput(
            f"{self._model.path.name}: the fingers moved by {', '.join(self._fingers.drivers)} {words} "
            "see `joints`, `links`, `closed`, `open`, `opening` of [jaw] in a gripper file"
        )


def _middle_of(parts: Sequence[FloatArray]) -> FloatArray:
    """Middle (3,) of the extent of some parts; the origin where there are none."""
    points = np.concatenate([np.zeros((0 if parts else 1, 3)), *parts])
    return (points.min(axis=0) + points.max(axis=0)) / 2.0


def _gap(inner: FloatArray, outer: FloatArray) -> float:
    return float(inner[:, 1].min() - outer[:, 1].max())


def _above(points: FloatArray, z: float) -> FloatArray:
    """Points that span the part of a convex body above z."""
    return np.concatenate([points[points[:, 2] > z], section(points, z)])


def snap_to_axis(direction: FloatArray) -> FloatArray:
    """A unit direction, that of an axis where one is near."""
    unit = direction / np.linalg.norm(direction)
    axis = int(np.argmax(np.abs(unit)))
    return np.sign(unit[axis]) * np.eye(3)[axis] if abs(unit[axis]) > SNAP else unit
