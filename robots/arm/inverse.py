"""Inverse kinematics by batched damped least squares: all distinct solutions found from many seeds."""

from ctypes import CDLL
from dataclasses import dataclass

import numpy as np

from topple.robots.arm.kinematics import Chain, rotation_vectors
from topple.robots.arm.tolerances import FULL_DOF
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.kernels.compiled import address, kernels


@dataclass(frozen=True)
class InverseTolerances:
    """When a solution counts.

    Attributes:
        position: Residual in [m]. Far below what an arm repeats (0.1 mm), so that rounding is all that is
            left.
        rotation: Residual in [rad], for the same reason.
        deficient_position: Residual in [m] of a kinematically deficient arm, of less than six joints, once it
            comes no nearer: as much as an arm repeats. Of all poses it reaches next to none, not even a hand
            that points straight down where its file rounds angles to 1e-5 rad.
        deficient_rotation: The same in [rad]: the underside of a block, completed from what is seen of it,
            leans by two degrees, and comes level as it is let go.
        distinct: Two solutions closer than this in every joint, in [rad] or [m], are the same: a redundant
            arm has a continuum of them, and planners profit from spread ones only.
        iterations: Steps before a seed is given up: of the seeds that ever converge on a Panda, 99 % do
            within 20.
        step: Largest joint change in one step in [rad]; beyond it the linearisation says nothing.
    """

    position: float = 1e-6
    rotation: float = 1e-6
    deficient_position: float = 1e-4
    deficient_rotation: float = 0.05
    distinct: float = 0.1
    iterations: int = 20
    step: float = 0.6


TOLERANCES = InverseTolerances()


def solve(
    chain: Chain,
    targets: FloatArray,
    seeds: FloatArray,
    tolerances: InverseTolerances = TOLERANCES,
    *,
    tool_point: FloatArray | None = None,
) -> tuple[FloatArray, IntArray]:
    """Joint values that bring the chain's last frame to the targets.

    Args:
        chain: The chain.
        targets: (k, 4, 4) wanted poses of the last frame in the base.
        seeds: (k, s, n) starts, or (s, n) for the same starts at every target.
        tolerances: When a solution counts.
        tool_point: (3,) the point of the last frame [m] that a deficient arm brings to where it shall be,
            whatever it cannot turn; the frame's origin where None.

    Returns:
        (r, n) all solutions found within the joint limits, and (r,) the index of the target each belongs to;
        in no order.
    """
    n, compiled = chain.size, kernels()
    point = tool_point if n < FULL_DOF else None
    q = np.array(np.broadcast_to(seeds, (len(targets), *seeds.shape[-2:])), dtype=np.float64).reshape(-1, n)
    if compiled is not None and len(q):
        return _solve(compiled, chain, targets, q, tolerances, np.zeros(3) if point is None else point)
    owner = np.repeat(np.arange(len(targets)), len(q) // max(len(targets), 1))
    solved: list[FloatArray] = []
    owners: list[IntArray] = []
    for _ in range(tolerances.iterations):
        frames = chain.frames(q)
        wanted = targets[owner]
        error = _pose_errors(frames[:, -1], wanted, point)
        near = _within(error, tolerances.position, tolerances.rotation)
        if near.any():
            solved.append(q[near])
            owners.append(owner[near])
            keep = ~near
            q, owner, frames, error = q[keep], owner[keep], frames[keep], error[keep]
        if not len(q):
            break
        q = _step(chain, q, frames, error, tolerances.step, point)
    if n < FULL_DOF and len(q):
        error = _pose_errors(chain.frames(q)[:, -1], targets[owner], point)
        near = _within(error, tolerances.deficient_position, tolerances.deficient_rotation)
        solved.append(q[near])
        owners.append(owner[near])
    if not solved:
        return np.empty((0, n)), np.empty(0, dtype=np.int64)
    return np.concatenate(solved), np.concatenate(owners)


def _solve(
    compiled: CDLL,
    chain: Chain,
    targets: FloatArray,
    starts: FloatArray,
    tolerances: InverseTolerances,
    point: FloatArray,
) -> tuple[FloatArray, IntArray]:
    """Solve as `solve` does, with the kernel."""
    within = np.array([
        tolerances.position, tolerances.rotation, tolerances.deficient_position, tolerances.deficient_rotation
    ])  # fmt: skip
    if chain.size >= FULL_DOF:
        within[2:] = 0.0
    wanted, point = np.ascontiguousarray(targets, dtype=np.float64), np.ascontiguousarray(point)
    found, owners = np.empty_like(starts), np.empty(len(starts), dtype=np.int64)
    given = chain.terms, chain.axes, chain.revolute, chain.lower, chain.upper
    count = compiled.chain_solve(
        *map(address, given), chain.size, address(wanted), len(wanted), address(starts),
        len(starts) // len(wanted), address(point), address(within), tolerances.iterations, tolerances.step,
        address(found), address(owners),
    )  # fmt: skip
    return found[:count], owners[:count]


def _within(errors: FloatArray, position: float, rotation: float) -> BoolArray:
    return (np.linalg.norm(errors[:, :3], axis=1) < position) & (
        np.linalg.norm(errors[:, 3:], axis=1) < rotation
    )


def _pose_errors(poses: FloatArray, wanted: FloatArray, point: FloatArray | None) -> FloatArray:
    relative = np.matmul(wanted[:, :3, :3], poses[:, :3, :3].transpose(0, 2, 1))
    way = _at(wanted, point) - _at(poses, point)
    return np.concatenate([way, rotation_vectors(relative)], axis=1)


def _at(poses: FloatArray, point: FloatArray | None) -> FloatArray:
    """Where a point (3,) of a frame is in each of its poses; the origin where None."""
    return poses[:, :3, 3] if point is None else poses[:, :3, :3] @ point + poses[:, :3, 3]


def _step(
    chain: Chain,
    q: FloatArray,
    frames: FloatArray,
    error: FloatArray,
    largest: float,
    point: FloatArray | None,
) -> FloatArray:
    """One damped step; joints that push against a limit are left out, so that the others do the work."""
    jacobian = chain.jacobian(frames, _at(frames[:, -1], point))
    # damping that fades with the error (Sugihara 2011): robust far away, quadratic near the solution
    damping = 0.05 * np.sum(error * error, axis=1) + 1e-7
    delta = _damped_step(jacobian, error, damping)
    blocked = ((q <= chain.lower) & (delta < 0)) | ((q >= chain.upper) & (delta > 0))
    again = np.flatnonzero(blocked.any(axis=1))
    if len(again):
        reduced = jacobian[again] * ~blocked[again][:, None, :]
        delta[again] = _damped_step(reduced, error[again], damping[again])
    size = np.abs(delta).max(axis=1, keepdims=True)
    delta *= np.minimum(1.0, largest / np.maximum(size, 1e-12))
    return np.clip(q + delta, chain.lower, chain.upper)


def _damped_step(jacobian: FloatArray, error: FloatArray, damping: FloatArray) -> FloatArray:
    transposed = jacobian.transpose(0, 2, 1)
    normal = np.matmul(jacobian, transposed)
    normal[:, np.arange(6), np.arange(6)] += damping[:, None]
    return np.matmul(transposed, np.linalg.solve(normal, error[..., None]))[..., 0]


def distinct(solutions: FloatArray, spacing: float = TOLERANCES.distinct) -> FloatArray:
    """The solutions that differ from all kept before them by more than `spacing` in some joint.

    Args:
        solutions: (r, n).
        spacing: In [rad] or [m].

    Returns:
        (s, n) in the order given.
    """
    kept: list[int] = []
    for i in range(len(solutions)):
        if not kept or (np.abs(solutions[kept] - solutions[i]).max(axis=1) > spacing).all():
            kept.append(i)
    return solutions[kept]
