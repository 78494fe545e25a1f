"""Build hook: lays the packages out below one front door, and compiles the kernels."""

import sysconfig
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FRONT = {
    "planner/topple.py": "__init__.py",
    "planner/testing.py": "testing.py",
    "planner/stability/predicates.py": "predicates.py",
    "planner/cli/__main__.py": "__main__.py",
    "planner/py.typed": "py.typed",
}
"""Files of the checkout, and their names in `topple`."""
KERNELS = "topology/kernels"


class Layout(BuildHookInterface):  # type: ignore[type-arg]
    """Lays `topple` out: its own files, `topology`, `robots`, `planner`, and in a checkout `benchmarks`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the front door in a wheel and tag it; make links in `.dev/topple` for an editable install.

        A wheel with compiled kernels is of this platform, and of any Python 3, of which they know nothing.
        Where they could not be compiled the numpy twins run, and the wheel is of any platform.
        """
        if self.target_name != "wheel":
            return
        library = self._compiled()
        if version != "editable":
            build_data["force_include"].update({file: f"topple/{name}" for file, name in FRONT.items()})
            if library is not None:
                build_data["force_include"][str(library)] = f"topple/{KERNELS}/{library.name}"
                build_data["pure_python"] = False
                platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
                build_data["tag"] = f"py3-none-{platform}"
            return
        package = Path(self.root, ".dev", "topple")
        package.mkdir(parents=True, exist_ok=True)
        folders = {name: name for name in ("topology", "robots", "planner", "benchmarks")}
        for source, name in {**FRONT, **folders}.items():
            link = package / name
            if not link.is_symlink():
                link.symlink_to(Path("..", "..", source), target_is_directory=source == name)

    def _compiled(self) -> Path | None:
        """The library of the kernels, compiled now; None where it cannot be, which is no failure."""
        spec = spec_from_file_location("build", Path(self.root, KERNELS, "build.py"))
        assert spec is not None and spec.loader is not None
        building = module_from_spec(spec)
        spec.loader.exec_module(building)
        why = building.build()
        if why is not None:
            self.app.display_warning(f"the numpy twins of the kernels will run, which are slower: {why}")
            return None
        return building.library()
