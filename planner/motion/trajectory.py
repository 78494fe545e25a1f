"""Paths to trajectories: joint positions over time, within velocity and acceleration limits."""

import numpy as np

from topple.planner.motion.tolerances import CORNER_SHARE, PERIOD
from topple.robots.arm.arm import Arm
from topple.robots.driver import Trajectory
from topple.topology.base.arrays import FloatArray


def retime(arm: Arm, path: FloatArray, speed: float = 0.5) -> Trajectory:
    """Give a path the shortest times that keep joint limits, starting and ending at rest.

    The path is followed exactly: straight edges from waypoint to waypoint. Along it the speed is limited by
    the joints' velocities and accelerations on each edge, and at a waypoint by the jump of joint velocities
    that the accelerations can absorb within one sampling period; a real corner is passed almost at rest. Both
    may fall on one sample, so speeding up takes three quarters of the acceleration and corners take the last
    quarter.

    Args:
        arm: For its limits.
        path: (k, n) waypoints.
        speed: Share of the velocity limits, and its square of the acceleration limits.

    Returns:
        The trajectory, sampled every 1/240 s.
    """
    path = np.asarray(path, dtype=float)
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    kept = np.concatenate([[True], lengths > 1e-9])
    path, lengths = path[kept], lengths[lengths > 1e-9]
    if not len(lengths):
        return Trajectory(np.zeros(1), path[:1], np.zeros_like(path[:1]))
    directions = np.diff(path, axis=0) / lengths[:, None]
    steep = np.maximum(np.abs(directions), 1e-9)
    fastest = np.min(speed * arm.velocity / steep, axis=1)
    hardest = np.min((1 - CORNER_SHARE) * speed**2 * arm.acceleration / steep, axis=1)
    nodes = _node_speeds(arm, directions, lengths, fastest, hardest, speed)
    times, ways, speeds = _profile(lengths, nodes, fastest, hardest)
    return _sample(path, directions, lengths, times, ways, speeds)


def _node_speeds(
    arm: Arm,
    directions: FloatArray,
    lengths: FloatArray,
    fastest: FloatArray,
    hardest: FloatArray,
    speed: float,
) -> FloatArray:
    """Path speed at each waypoint: what the corner allows, then what can be reached and braked from."""
    nodes = np.zeros(len(lengths) + 1)
    jump = np.abs(np.diff(directions, axis=0))
    absorbed = CORNER_SHARE * speed**2 * arm.acceleration * PERIOD
    corner = np.min(absorbed / np.maximum(jump, 1e-9), axis=1, initial=np.inf)
    nodes[1:-1] = np.minimum(corner, np.minimum(fastest[:-1], fastest[1:]))
    for i in range(len(lengths)):
        nodes[i + 1] = min(nodes[i + 1], np.sqrt(nodes[i] ** 2 + 2 * hardest[i] * lengths[i]))
    for i in reversed(range(len(lengths))):
        nodes[i] = min(nodes[i], np.sqrt(nodes[i + 1] ** 2 + 2 * hardest[i] * lengths[i]))
    return nodes


def _profile(
    lengths: FloatArray, nodes: FloatArray, fastest: FloatArray, hardest: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Knots of a piecewise linear speed: speed up, cruise, slow down on every edge."""
    times, ways, speeds = [0.0], [0.0], [float(nodes[0])]
    for length, start, end, top, accel in zip(lengths, nodes[:-1], nodes[1:], fastest, hardest, strict=True):
        peak = min(top, np.sqrt((2 * accel * length + start**2 + end**2) / 2))
        up, down = (peak**2 - start**2) / (2 * accel), (peak**2 - end**2) / (2 * accel)
        cruise = max(length - up - down, 0.0)
        pieces = ((up, start, peak), (cruise, peak, peak), (down, peak, end))
        for way, before, after in pieces:
            if way > 1e-12:
                times.append(times[-1] + 2 * way / (before + after))
                ways.append(ways[-1] + way)
                speeds.append(after)
    return np.array(times), np.array(ways), np.array(speeds)


def _sample(
    path: FloatArray,
    directions: FloatArray,
    lengths: FloatArray,
    times: FloatArray,
    ways: FloatArray,
    speeds: FloatArray,
) -> Trajectory:
    count = max(int(np.ceil(times[-1] / PERIOD)), 1) + 1
    sample = np.minimum(np.arange(count) * PERIOD, times[-1])
    knot = np.clip(np.searchsorted(times, sample, side="right") - 1, 0, len(times) - 2)
    since = sample - times[knot]
    span = np.maximum(times[knot + 1] - times[knot], 1e-12)
    slope = (speeds[knot + 1] - speeds[knot]) / span
    way = np.minimum(ways[knot] + speeds[knot] * since + slope * since**2 / 2, ways[-1])
    rate = speeds[knot] + slope * since
    ends = np.cumsum(lengths)
    edge = np.clip(np.searchsorted(ends, way, side="right"), 0, len(lengths) - 1)
    before = way - (ends[edge] - lengths[edge])
    positions = path[edge] + before[:, None] * directions[edge]
    velocities = rate[:, None] * directions[edge]
    positions[-1], velocities[-1] = path[-1], 0.0
    return Trajectory(sample, positions, velocities)
