"""The second physics engine: MuJoCo, or one line on how to get it."""

from importlib.util import find_spec
from typing import Any

from topple.topology.base.errors import NotInstalled

if find_spec("mujoco") is None:
    raise NotInstalled("this engine is MuJoCo", "mujoco")

import mujoco as _mujoco

mujoco: Any = _mujoco
"""Without its types: they differ from one version to the next."""

__all__ = ["mujoco"]
