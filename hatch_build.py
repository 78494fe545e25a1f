"""Build hook: puts the front door above the packages, and links all of them for an editable install."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FRONT = {
    "planner/topple.py": "__init__.py",
    "planner/cli/__main__.py": "__main__.py",
    "planner/py.typed": "py.typed",
}
"""Files of the checkout, and their names in `topple`."""


class Layout(BuildHookInterface):  # type: ignore[type-arg]
    """Lays `topple` out: its own files, `topology`, `robots`, `planner`, and in a checkout `benchmarks`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the front door in a wheel; make links in `.dev/topple` for an editable install."""
        if self.target_name != "wheel":
            return
        if version != "editable":
            build_data["force_include"].update({file: f"topple/{name}" for file, name in FRONT.items()})
            return
        package = Path(self.root, ".dev", "topple")
        package.mkdir(parents=True, exist_ok=True)
        folders = {name: name for name in ("topology", "robots", "planner", "benchmarks")}
        for source, name in {**FRONT, **folders}.items():
            link = package / name
            if not link.is_symlink():
                link.symlink_to(Path("..", "..", source), target_is_directory=source == name)
