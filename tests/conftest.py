import json
import re
import signal
from collections import Counter
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import settings
from pytest import Item

settings.register_profile("topple", deadline=None)  # a busy machine is no failure
settings.load_profile("topple")

# What a shell starts in the background ignores interrupts, and so would every program that a test interrupts.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Where PyBullet has no wheel, only what does not simulate is tested: a file that imports one of these does.
SIMULATES = re.compile(r"^ *from topple\..* import .*\b(World|scenario|brick_wall)\b", re.MULTILINE)
collect_ignore = [
    str(path)
    for path in (Path(__file__).parent / "topology").rglob("test_*.py")
    if not find_spec("pybullet") and SIMULATES.search(path.read_text())
]


def pytest_collection_modifyitems(items: list[Item]) -> None:
    """Begin with the files that take longest: all of what is left at the end goes to idle processes."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: (item.path.parent != Path(__file__).parent, -slow[item.path]))


class Said(NamedTuple):
    """What a command printed."""

    out: str
    err: str

    @property
    def document(self) -> Any:
        return json.loads(self.out)


@pytest.fixture
def typed(capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Runs a command of topple in this process, holds it to its exit code and gives what it printed."""

    def run(*argv: object, code: int = 0) -> Said:
        from topple.planner.cli.main import main

        assert main([str(word) for word in argv]) == code
        return Said(*capsys.readouterr())

    return run
