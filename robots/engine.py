"""The physics engine: PyBullet, imported without its greeting, or one line on how to get it.

Everything that simulates imports `pybullet` from here. CPython 3.10 to 3.13 on Linux x86-64 have a wheel of
it, the latter two of the fork pybullet-arm64; where it is not installed, importing this module
raises `NotInstalled`.
"""

import importlib
import os
import sys
from importlib.util import find_spec
from typing import TYPE_CHECKING

from topple.topology.base.errors import NotInstalled

if TYPE_CHECKING:
    import pybullet

__all__ = ["pybullet"]


def _quietly(module: str) -> None:
    """Import a module that greets on stderr from C."""
    if sys.stderr is None or module in sys.modules:
        importlib.import_module(module)
        return
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        importlib.import_module(module)
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


if find_spec("pybullet") is None:
    raise NotInstalled("simulation needs PyBullet", "sim")
_quietly("pybullet")
pybullet = sys.modules["pybullet"]
