"""Compile the kernels into one shared library: `python -m topple.topology.kernels.build`.

The build hook does so where there is a compiler; installs without one run the numpy twins. It imports nothing
of topple, so that the hook can run it before anything is installed.
"""

import os
import shutil
import subprocess
import sys
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

FOLDER = Path(__file__).parent
FLAGS = "-std=c++17 -O3 -ffp-contract=off -fno-math-errno -fno-trapping-math -fPIC".split()
"""The same arithmetic everywhere: no instructions beyond the platform's least, no fused products."""
COMPILERS = ("c++", "g++", "clang++")


def sources() -> list[Path]:
    """The files that are compiled and those these include, by name."""
    return sorted(FOLDER.glob("*.?pp"))


def library() -> Path:
    """The shared library of these sources, there or not: another's is never taken for it."""
    digest = zlib.crc32(b"".join(path.read_bytes() for path in sources()))
    return FOLDER / f"kernels_{digest:08x}.so"


def compiler() -> str | None:
    """The C++ compiler: that of the environment variable CXX, else what is found; None where none is."""
    named = os.environ.get("CXX")
    return next(filter(None, map(shutil.which, [named] if named else COMPILERS)), None)


def build(flags: tuple[str, ...] = (), target: Path | None = None) -> str | None:
    """Compile the library and remove those of other sources.

    Args:
        flags: What the compiler is told besides.
        target: Where to write it; beside the sources where None.

    Returns:
        Why there is none, in a line; None where it was compiled.
    """
    command = compiler()
    if command is None:
        return "no C++ compiler was found (CXX names one)"
    path = target or library()
    fresh = path.with_suffix(f".{os.getpid()}")  # a process that loads meanwhile finds it whole or not at all

    def run(*words: Path | str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([command, *FLAGS, *flags, *words], capture_output=True, text=True, check=False)

    with TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        units = {Path(folder, f"{each.stem}.o"): each for each in sources() if each.suffix == ".cpp"}
        parts = pool.map(lambda unit: run("-c", units[unit], "-o", unit), units)
        done = next((part for part in parts if part.returncode), None) or run("-shared", *units, "-o", fresh)
    if done.returncode or not fresh.exists():
        fresh.unlink(missing_ok=True)
        last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return f"{command} failed: {last}"
    if target is None:
        for old in FOLDER.glob("kernels_*.so"):
            old.unlink()
    fresh.replace(path)
    return None


if __name__ == "__main__":
    sys.exit(build())
