"""Lengths and limits of grasping, each with the reason for its value."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GraspTolerances:
    """Lengths in metres, angles in radians.

    Attributes:
        spacing: Clouds are thinned to this; a quarter of a finger pad's width keeps every edge a pad feels.
        hidden_spacing: Grid on inferred sides: finer than a finger is thick.
        hidden_gap: An inferred side counts where nothing was seen within it: depth noise and thinning.
        normal_radius: Surface normals are fitted within it: wide enough to average 1-2 mm of depth noise,
            narrower than the curvature of fruit.
        side_clearance: Free room wanted beside each pad on the way in: depth noise (2 mm), the arm's
            tracking error (1-2 mm) and the pixel at a mask's edge (2 mm).
        least_side_clearance: Below this the fingers would be driven into the object they are to pass.
        under_clearance: Distance kept between the finger tips and what lies beneath.
        stray_points: So many points in the way count as noise (flying pixels), not as a thing.
        depths: Tried depths of the finger tips below the object's top between the pads, least first.
        tilts: Tried angles between the approach and straight down, about the closing axis.
        steep_tilts: Tried where those find fewer than `enough` grasps.
        enough: So many grasps leave the arm a choice.
        reach: Only points this close to a grasp can touch the hand.
        into_solid: A finger this deep in the object's own hull would be driven into it: twice the depth
            noise, and more than hulls stand out from a surface between its points.
        friction: Coefficient assumed between pad and object (rubber on glazed ceramics or steel: 0.5-0.8).
        lever: Distance between the pads' line and the centre of mass at which half the score is gone: a
            0.1 kg object then turns in the pads of a 20 N gripper.
        seal_tolerance: Unevenness under a suction cup's lip that its bellows takes up.
        least_seal: Suction scored below this would leak or peel off.
        sure: Score from which a suction grasp is sure to hold: a good seal near the centre of mass.
        enough_sealed: With so many sure suction grasps no pinch is looked for.
        seal_tilt: Angle between a cup, which is set square on a surface, and straight down: beyond it most of
            the weight pulls along the lip.
    """

    spacing: float = 0.004
    hidden_spacing: float = 0.005
    hidden_gap: float = 0.007
    normal_radius: float = 0.010
    side_clearance: float = 0.008
    least_side_clearance: float = 0.004
    under_clearance: float = 0.0015
    stray_points: int = 2
    depths: tuple[float, ...] = (0.004, 0.006, 0.008, 0.012, 0.018, 0.025, 0.035, 0.045)
    tilts: tuple[float, ...] = (0.0, 0.26, -0.26)
    steep_tilts: tuple[float, ...] = (0.52, -0.52)
    enough: int = 20
    reach: float = 0.16
    into_solid: float = 0.005
    friction: float = 0.5
    lever: float = 0.05
    seal_tolerance: float = 0.0015
    least_seal: float = 0.2
    sure: float = 0.6
    enough_sealed: int = 4
    seal_tilt: float = 0.7


GRASP_TOLERANCES = GraspTolerances()
