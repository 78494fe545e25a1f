"""A bench as the contract's document: the rows, and the machine they were measured on."""

import importlib
import inspect
import os
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from topple.benchmarks.row import Progress
from topple.topology.base.errors import DISTRIBUTION, InvalidInput

BENCHES = ("relate", "order", "build", "rearrange", "motion", "paper", "run", "demo")
"""Names; each is a module of this package with a function `rows(quick, seed, progress)`."""

CHECKS = (
    "check", "towers", "libero", "assemblies", "textbook", "cans", "clutternav", "kinder", "mbm", "tamp",
    "engines", "reliability", "speed", "truth",
)  # fmt: skip
"""Benches that compare topple with itself, not with others: run where they are named."""

_LIBRARIES = (DISTRIBUTION, "numpy", "scipy", "pybullet", "python-fcl", "ompl")

ALONE = ("part", "scenario")
"""Options that measure one part of a bench alone: they name its table."""


def bench(
    name: str, *, quick: bool = False, seed: int = 0, progress: Progress | None = None, **options: Any
) -> dict[str, Any]:
    """Run a bench.

    Args:
        name: One of `BENCHES` or `CHECKS`.
        quick: Smaller and fewer cases: below two minutes.
        seed: Seed of everything that is drawn.
        progress: Called with a few words before each part.
        options: What only this bench takes, see `options_of`.

    Returns:
        A `topple.bench` document.

    Raises:
        InvalidInput: There is no such bench.
    """
    measured = _rows_of(name)(quick=quick, seed=seed, progress=progress or (lambda text: None), **options)
    alone = {key: options[key] for key in ALONE if options.get(key) is not None}
    return {
        "format": "topple.bench",
        "format_version": 1,
        "bench": name,
        **alone,
        "quick": quick,
        "seed": seed,
        "machine": machine(),
        "rows": measured,
    }


def options_of(name: str) -> tuple[str, ...]:
    """What a bench takes besides quick, seed and progress.

    Args:
        name: One of `BENCHES` or `CHECKS`.

    Returns:
        Names of keyword arguments.

    Raises:
        InvalidInput: There is no such bench.
    """
    return tuple(inspect.signature(_rows_of(name)).parameters)[3:]


def _rows_of(name: str) -> Callable[..., list[dict[str, Any]]]:
    known = (*BENCHES, *CHECKS)
    if name not in known:
        raise InvalidInput(f"there is no bench {name!r}: expected one of {', '.join(known)}")
    module = "truth.gate" if name == "truth" else name
    return importlib.import_module(f"topple.benchmarks.{module}").rows


def machine() -> dict[str, Any]:
    """What the figures were measured on: processor, cores, threads of the linear algebra, versions."""
    return {
        "system": platform.platform(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "blas_threads": os.environ.get("OMP_NUM_THREADS"),
        "python": platform.python_version(),
        "libraries": {library: version(library) for library in _LIBRARIES},
    }


def _processor() -> str:
    """The processor's name, as the kernel gives it where it does."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, "") or platform.processor() or platform.machine()
