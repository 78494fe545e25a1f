"""What gravity asks of an arm's joints as it stands in a state with a load in its hand."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.tolerances import GRAVITY
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.axes import cross


class Strain(NamedTuple):
    """The joint that is asked the most, measured by what it can.

    Attributes:
        share: Of its effort limit that it takes; above 1 it gives way.
        joint: Its name.
        torque: What it takes, [N m] or [N].
        limit: Its effort limit in the URDF, in the same unit.
        state: Index of the state.
    """

    share: float
    joint: str
    torque: float
    limit: float
    state: int

    def __str__(self) -> str:
        """In words, as after "lift: "."""
        return f"{self.joint} takes {self.torque:.0f} of {self.limit:g} N m"


def strain(
    arm: Arm,
    q: FloatArray,
    up: FloatArray,
    mass: float = 0.0,
    centre: Sequence[float] | FloatArray = (0, 0, 0),
) -> Strain:
    """Weigh an arm and its load on its joints: J^T of the weights, for many states at once.

    Joints of which the URDF states no effort hold whatever there is; links of which it states no mass weigh
    nothing. (An arm of one's own has both, assumed where they are not there.) Joints with `springs` bear the
    load alone.

    Args:
        arm: The arm.
        q: (m, n) joint values in [rad] or [m].
        up: (3,) unit vector against gravity in the base's frame.
        mass: Of what is in the hand [kg].
        centre: (3,) its centre of mass in the last frame of the chain, the flange [m].

    Returns:
        The joint and the state in which most of a limit is taken.
    """
    limits = _limits(arm)
    asked = gravity_torques(arm, q, up, mass, centre)
    if (sprung := np.isin(arm.joints, springs(arm))).any():
        asked -= sprung * gravity_torques(arm, q, up, 0.0, centre)
    torques = np.abs(asked)
    shares = torques / np.where(limits > 0.0, limits, np.inf)
    state, joint = np.unravel_index(int(shares.argmax()), shares.shape)
    torque, limit = float(torques[state, joint]), float(limits[joint])
    return Strain(float(shares[state, joint]), arm.joints[joint], torque, limit, int(state))


def gravity_torques(
    arm: Arm, q: FloatArray, up: FloatArray, mass: float, centre: Sequence[float] | FloatArray
) -> FloatArray:
    """Compute the load of each joint as the arm stands still, as for `strain`: (m, n) in [N m] or [N]."""
    masses, moments = _lumps(arm)
    masses, moments = masses.copy(), moments.copy()
    masses[-1] += mass
    moments[-1] += mass * np.asarray(centre)
    frames = arm.chain.frames(np.atleast_2d(q))[:, 1:]
    origins = frames[..., :3, 3]
    placed = np.matmul(frames[..., :3, :3], moments[..., None])[..., 0] + masses[:, None] * origins
    # what is behind a joint weighs on it: sums from the hand inwards
    behind = np.cumsum(placed[:, ::-1], axis=1)[:, ::-1]
    weighs = np.cumsum(masses[::-1])[::-1]
    axes = np.matmul(frames[..., :3, :3], arm.chain.axes[:, :, None])[..., 0]
    turning = np.einsum("mnk,mnk->mn", axes, cross(behind - weighs[:, None] * origins, up))
    return GRAVITY * np.where(arm.chain.revolute, turning, weighs * (axes @ up))


@lru_cache(maxsize=16)
def springs(arm: Arm) -> tuple[str, ...]:
    """Joints that by their efforts could not hold the arm itself as it rests: something else bears it there.

    A URDF cannot state springs and counterweights; the PR2 has them.
    """
    borne = np.abs(gravity_torques(arm, arm.home, np.array([0.0, 0.0, 1.0]), 0.0, np.zeros(3)))[0]
    return tuple(np.array(arm.joints)[(0.0 < _limits(arm)) & (_limits(arm) < borne)].tolist())


def _limits(arm: Arm) -> FloatArray:
    return np.array([arm.model.joint(name).effort for name in arm.joints])


@lru_cache(maxsize=16)
def _lumps(arm: Arm) -> tuple[FloatArray, FloatArray]:
    """Per joint the mass (n,) [kg] of the links that move with its frame, and their moments (n, 3) there."""
    masses, moments = np.zeros(len(arm.joints)), np.zeros((len(arm.joints), 3))
    for link, frame, pose in zip(arm.links, arm.frame_of_link, arm.offsets(arm.open_hand), strict=True):
        inertial = arm.model.links[link].inertial
        if frame > 0 and inertial is not None:
            masses[frame - 1] += inertial.mass
            moments[frame - 1] += inertial.mass * (pose @ inertial.pose_inertial_to_link)[:3, 3]
    return masses, moments
