"""Other planners on the same problems: each runs in a Python of its own, on the arm and boxes we hand over.

Environments are looked for in the folder that the variable `TOPPLE_PEERS` names, else in `.peers`: a peer
runs where `FOLDER/NAME/bin/python` exists. `make peers` sets up all but VAMP, of which no wheel is published.
"""

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.motion_problems import Problem
from topple.benchmarks.peers.handover import handed_over
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError

PEERS = {
    "pybullet-planning": "pybullet_planning_peer.py",
    "mplib": "mplib_peer.py",
    "vamp": "vamp_peer.py",
    "roboplan": "roboplan_peer.py",
}
"""Scripts by the name of the package that each drives."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a peer made of a problem.

    Attributes:
        seconds: CPU time of planning and its own shortening; loading arm and scene is not counted.
        path: (k, n) waypoints; None where it found none.
    """

    seconds: float
    path: FloatArray | None


def python_of(peer: str) -> Path | None:
    """The Python a peer is installed for, None where there is none."""
    folder = Path(os.environ.get("TOPPLE_PEERS", ".peers"))
    python = folder / peer / "bin" / "python"
    return python.absolute() if python.exists() else None


def answers(peer: str, python: Path, problems: Sequence[Problem], seed: int, budget: float) -> list[Answer]:
    """Let a peer solve problems.

    Args:
        peer: One of `PEERS`.
        python: The Python it is installed for.
        problems: All with the same arm.
        seed: For its random numbers.
        budget: Seconds for one problem.

    Returns:
        One answer for each problem.

    Raises:
        ToppleError: If the peer's process fails; the message ends with what it said.
    """
    script = Path(__file__).with_name(PEERS[peer])
    with tempfile.TemporaryDirectory() as folder:
        handed_over(Path(folder), problems, seed, budget)
        run = subprocess.run(
            [str(python), str(script), folder], capture_output=True, text=True, cwd=folder, check=False
        )
        if run.returncode:
            said = run.stderr.strip().splitlines()[-1:] or ["nothing"]
            raise ToppleError(f"{peer} in {python} failed; it said: {said[0]}")
        found: list[dict[str, Any]] = json.loads((Path(folder) / "answers.json").read_text(encoding="utf-8"))
    return [
        Answer(answer["seconds"], None if answer["path"] is None else np.array(answer["path"]))
        for answer in found
    ]
