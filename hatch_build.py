"""Build hook: puts the front door above the packages, and links all of them for an editable install."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FRONT = "planner/topple.py"
"""Installed as `topple/__init__.py`."""


class Layout(BuildHookInterface):  # type: ignore[type-arg]
    """Lays `topple` out: `__init__.py`, `topology`, `robots`, `planner`, `benchmarks`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the front door in a wheel; make links in `.dev/topple` for an editable install."""
        if self.target_name != "wheel":
            return
        if version != "editable":
            build_data["force_include"][FRONT] = "topple/__init__.py"
            return
        package = Path(self.root, ".dev", "topple")
        package.mkdir(parents=True, exist_ok=True)
        for source in (FRONT, "topology", "robots", "planner", "benchmarks"):
            link = package / ("__init__.py" if source == FRONT else source)
            if not link.is_symlink():
                link.symlink_to(Path("..", "..", source), target_is_directory=source != FRONT)
