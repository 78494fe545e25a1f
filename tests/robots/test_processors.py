"""The same seed is the same scene with the linear algebra of other processors."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SEEN = """
import hashlib
from topple.benchmarks.plans import seen
from topple.robots import scenario
for name, seed in (("dishes", 0), ("pile", 1)):
    with scenario(name, seed) as stage:
        clouds = seen(stage).clouds
    print(name, hashlib.sha256(b"".join(clouds[one].tobytes() for one in sorted(clouds))).hexdigest())
"""


def printed(kernels: str) -> str:
    """What a process that is told which kernels of OpenBLAS to use makes of the scenes."""
    told = {**os.environ, "OPENBLAS_CORETYPE": kernels}
    return subprocess.run(
        [sys.executable, "-c", SEEN], env=told, check=True, capture_output=True, text=True, timeout=300
    ).stdout


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/cpuinfo").exists() or "avx512dq" not in Path("/proc/cpuinfo").read_text(),
    reason="this processor has not the instructions of the others",
)
def test_scenes_are_the_same_to_the_bit():
    assert printed("SkylakeX") == printed("Haswell") != ""
