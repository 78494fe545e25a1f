"""What a hand can hold: the weight of a thing and its moment against what pads and cups resist."""

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr

from topple.planner.grasp.tolerances import HOLD_SPREAD, WEIGHT_SPREAD
from topple.robots.arm.tolerances import GRAVITY
from topple.topology.base.arrays import FloatArray
from topple.topology.statics.tolerances import DENSITY

if TYPE_CHECKING:
    from topple.planner.grasp.hand import HandShape
    from topple.robots.arm.arm import Arm


HOLD = "hold"
"""The term of a grasp's score that says how surely its weight is held."""


def weight_of(volume: float, mass: float | None = None) -> float:
    """Weight [N] of a thing.

    Args:
        volume: What it fills [m3].
        mass: In [kg]; where it was not weighed, its volume at the density bodies are made with.
    """
    return GRAVITY * (DENSITY * volume if mass is None else mass)


def beyond_arm(mass: float, arm: "Arm") -> str:
    """Why an arm is not to carry a mass [kg]; empty where it is rated to."""
    words = f"{mass:g} kg are more than {arm.name} carries ({arm.payload:g} kg beside its hand)"
    return words if mass > arm.payload else ""


def jaw_load(
    arm: FloatArray,
    down: FloatArray,
    weight: float,
    width: FloatArray,
    depth: FloatArray,
    hand: "HandShape",
    friction: float,
) -> FloatArray:
    """How much of what two pads hold a weight takes, in P grasps.

    Friction carries the weight and resists turning about the line through the pads; both at once use it up
    as the radius of an ellipse. Turning about the other axes is resisted by the pressure, which can move from
    the middle of what the pads touch to its edge, and by friction along the pads, which are `width` apart.

    Args:
        arm: (P, 3) from between the pads to the centre of mass in the hand's axes [m].
        down: (P, 3) unit vectors of gravity in the hand's axes.
        weight: In [N].
        width: (P,) distance of the pads [m].
        depth: (P,) how far the tips are below the object's top: what the pads touch [m].
        hand: Its force, its pads and how they give.
        friction: Coefficient between pads and object.

    Returns:
        (P,) shares; above 1 the thing turns or slips.
    """
    moment = weight * np.cross(arm, down)
    slide = 2.0 * friction * hand.force
    turning = np.hypot(weight / slide, moment[:, 1] / (slide * hand.give))
    across = hand.force * (np.minimum(depth, hand.pad_length) + friction * width)
    return np.asarray(np.maximum(turning, np.hypot(moment[:, 0], moment[:, 2]) / across), dtype=np.float64)


def chance_to_hold(load: FloatArray | float, weighed: bool = False) -> FloatArray:
    """Chance that a grasp under a load holds: the share of its score that it keeps.

    Weights are guessed within a factor of two nine times in ten, up or down. Pads on flat faces resist
    turning several times as much as on round ones, which is what their lever is given for: that is a reserve.

    Args:
        load: Shares, of any shape.
        weighed: Whether the weight is known.

    Returns:
        1 for none, 0.95 at a half of a guessed weight, 0.5 where the likely weight takes all of what holds
        it, of the same shape.
    """
    spread = HOLD_SPREAD if weighed else WEIGHT_SPREAD
    return np.asarray(ndtr(-np.log(np.maximum(load, 1e-6)) / spread), dtype=np.float64)


def in_words(load: float) -> str:
    """Say how heavy a load is, after other words; nothing where it is surely held."""
    return f"; its weight takes {100 * load:.0f} % of what surely holds it" if load > 1.0 else ""
