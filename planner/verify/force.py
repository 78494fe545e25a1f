"""What the weight in a hand asks of pads or cup, of the arm's rating and of its joints, all along a plan."""

from collections.abc import Mapping

import numpy as np

from topple.planner.grasp.load import weight_of
from topple.planner.grasp.shape import shapes_of
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.replay import Finding, Piece, Replay
from topple.planner.verify.tolerances import COARSE
from topple.robots.arm.tolerances import GRAVITY
from topple.robots.arm.torques import Strain, strain
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import move_parts
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import volume_and_centre


class Weights:
    """What weights ask of hand, arm and joints in every piece of a replay.

    What was weighed is a claim: more of it than the hand, the arm or a joint bears refutes a step. Of a
    weight that is guessed, by a factor of two, more than they bear only leaves the step unproven.

    Args:
        replay: The replay; without a scene everything is guessed.
    """

    def __init__(self, replay: Replay) -> None:
        scene = replay.weighing_scene()
        self.replay, self.arm, self._up = replay, replay.arm, replay.up
        self._base_up = replay.base[:3, :3].T @ self._up
        self.masses: Mapping[str, float] = {} if scene is None else scene.masses
        self._friction: Mapping[str, float] = {} if scene is None else scene.friction
        self._centres: Mapping[str, FloatArray] = {} if scene is None else scene.centres
        self.loads: dict[int, float] = {}
        """By index of a step, the share of what pads or cup resist; above 1 what is held slips or turns."""
        self.guessed: dict[int, str] = {}
        """By index of a step, what it is if weights are as they are guessed that is more than is borne."""
        self.heavy, self.overload, self.torques = list[Finding](), list[Finding](), list[Finding]()
        """Weights beyond what the hand holds [N], masses beyond the arm's rating [kg], shares of torques."""
        for piece in replay.pieces:
            self._weigh(piece)

    def _weigh(self, piece: Piece) -> None:
        """Weigh what is in the hand: as it closes, and on the joints all along."""
        to_pads = inverse(self.replay.pads(piece))
        parts = {name: move_parts(self.replay.parts[name], to_pads @ to) for name, to in piece.held.items()}
        lumps = {name: volume_and_centre(np.vstack(each), each) for name, each in parts.items()}
        known = {name: self.masses.get(name, 0.0) for name in lumps}
        likely = {
            name: weight_of(volume, self.masses.get(name)) / GRAVITY for name, (volume, _) in lumps.items()
        }
        centres = {name: centre for name, (_, centre) in lumps.items()}
        for name in centres.keys() & self._centres.keys():
            (centres[name],) = move_parts([self._centres[name][None]], to_pads @ piece.held[name])[0]
        asked = self._strain(piece, known, centres)
        self.torques.append(piece.finds(asked.share, str(asked)))
        if known != likely and (asked := self._strain(piece, likely, centres)).share > 1.0:
            self.guessed.setdefault(piece.index, str(asked))
        if piece.segment.kind != SegmentKind.GRASP or piece.step.object not in piece.held:
            return
        self._rate(piece, sum(known.values()))
        if sum(likely.values()) > self.arm.payload:
            self.guessed.setdefault(piece.index, f"{sum(likely.values()):.2g} of {self.arm.payload:g} kg")
        if sum(likely.values()) > 0.0:
            self._hold_load(piece, likely, centres, np.vstack(parts[piece.step.object]))

    def _rate(self, piece: Piece, mass: float) -> None:
        """A mass that is known against what the arm is rated for, and against the most that a hand holds."""
        words = f"{mass:g} kg, {self.arm.name} carries {self.arm.payload:g} kg"
        self.overload.append(piece.finds(mass - self.arm.payload, words))
        hand = shapes_of(self.arm)[piece.segment.tool]
        most = hand.max_weight(self._friction.get(piece.step.object))
        words = f"{GRAVITY * mass:.0f} N, the {piece.segment.tool} hold {most:.0f} N"
        self.heavy.append(piece.finds(GRAVITY * mass - most, words))

    def _strain(self, piece: Piece, masses: Mapping[str, float], centres: Mapping[str, FloatArray]) -> Strain:
        """Compare weights with the joints' limits along a segment."""
        mass, centre = sum(masses.values()), np.zeros(3)
        if mass > 0.0:
            middle = np.average(list(centres.values()), axis=0, weights=list(masses.values()))
            to_flange = self.arm.tool_to_flange(piece.segment.tool) @ self.replay.pads(piece)
            centre = move_points(middle[None], to_flange)[0]
        return strain(self.arm, piece.states[::-COARSE], self._base_up, mass, centre)

    def _hold_load(
        self,
        piece: Piece,
        masses: Mapping[str, float],
        centres: Mapping[str, FloatArray],
        own: FloatArray,
    ) -> None:
        """How much of what pads or cup resist the weight takes, by the model that grasps are chosen by."""
        weight = GRAVITY * sum(masses.values())
        centre = np.average(list(centres.values()), axis=0, weights=list(masses.values()))
        down = np.array(piece.step.grasp.pose_tool_to_world)[:3, :3].T @ -self._up
        hand, width = shapes_of(self.arm)[piece.segment.tool], piece.step.grasp.width
        self.loads[piece.index] = hand.load(weight, centre, down, width, own)
