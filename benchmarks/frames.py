"""Real camera frames acted out: rebuilt as bodies, and the order carried out by an arm in that world."""

from collections import Counter
from pathlib import Path

import networkx as nx

from topple.benchmarks.recorded import Frame, recorded_frames
from topple.planner.execution.rehearsal import Rehearsal
from topple.planner.execution.run import run
from topple.planner.formats.run_record import RunRecord
from topple.robots.catalog import robot

ARM = "panda-suction"
"""Boxes of the frames are wider than a hand opens."""


def frames_in(folder: Path) -> tuple[str, ...]:
    """Names of the annotated frames of a folder.

    Args:
        folder: See `topple.benchmarks.recorded.recorded_frames`.

    Raises:
        InvalidInput: There is none.
    """
    return tuple(frame.name for frame in recorded_frames(folder))


def wanted_of(frame: Frame) -> str:
    """What is freed: what, by the annotation, most others have to go before.

    Args:
        frame: The frame.
    """
    needed = nx.transitive_closure(nx.DiGraph(sorted(frame.needed)))
    waiting = Counter(then for _, then in needed.edges)
    return min(waiting, key=lambda name: (-waiting[name], name))


def act_out(folder: Path, name: str, seed: int, cameras: int) -> tuple[RunRecord, float, int]:
    """Rebuild a frame, and free the object that most others have to go before.

    Args:
        folder: Holds the frames.
        name: Of the frame.
        seed: Of sensor noise and every search.
        cameras: How many depth cameras look on in the rebuilt world.

    Returns:
        The run, how far the body that moved most got before it was at rest [m], and how many can move.
    """
    (frame,) = (frame for frame in recorded_frames(folder) if frame.name == name)
    with Rehearsal.of(frame.scene, robot(ARM)) as stage:
        sagged = max(stage.sagged.values())
        movable = len(stage.world.movable)
    record = run(frame.scene, [wanted_of(frame)], ARM, cameras=cameras, seed=seed)
    return record, sagged, movable
