"""Build hook: links the three folders as one package for an editable install."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class EditableLinks(BuildHookInterface):  # type: ignore[type-arg]
    """Makes `.dev/topple/{topology,robots,planner}`: an editable install cannot follow a source mapping."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the links for the editable version; a wheel needs none."""
        if version != "editable":
            return
        package = Path(self.root, ".dev", "topple")
        package.mkdir(parents=True, exist_ok=True)
        for folder in ("topology", "robots", "planner"):
            link = package / folder
            if not link.is_symlink():
                link.symlink_to(Path("..", "..", folder), target_is_directory=True)
