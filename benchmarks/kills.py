"""Commands that are killed at many moments, and commands whose output finds no room: what is left of them."""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.row import Progress
from topple.benchmarks.sabotages.caught import scene_for
from topple.robots.scratch import LOCK

TOPPLE = (sys.executable, "-m", "topple.planner.cli.main")
GONE_WITHIN = 5.0  # [s] after its parent that a worker is gone
ROOM = 30_000  # [bytes] of a file that a full disk takes
LONGEST = 600.0  # [s] that a killed command is waited for to keep an episode
NEXT_START = "from topple.robots.scratch import Scratch; Scratch().close()"


@dataclass(frozen=True)
class Killed:
    """What became of a command that was killed again and again.

    Attributes:
        command: Its name.
        kills: How often.
        clean: After how many of them nothing was left.
        left: What should not have been left, in sentences.
    """

    command: str
    kills: int
    clean: int
    left: tuple[str, ...]


@dataclass(frozen=True)
class Refused:
    """What became of a command whose output could not be written.

    Attributes:
        what: The command, and why not.
        wrong: What was not as it should be; empty where it said no in one line and left nothing.
    """

    what: str
    wrong: str


def kill(kills: int, seed: int, progress: Progress) -> list[Killed]:
    """Kill commands with signal 9, each at moments spread over its run.

    Args:
        kills: In all; a quarter of more than four hit `bench run` just after it kept an episode.
        seed: Of the moments.
        progress: Called before each kill.

    Returns:
        What was left, by command.
    """
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory(prefix="topple-kills-") as name:
        place = Path(name)
        scene = _scene(place)
        commands = {
            "plan -o": ("plan", *scene, "--goal", "free lower", "-o", "plan.json"),
            "show -o": ("show", *scene, "-o", "show.html"),
            "run --report": ("run", *scene, "--goal", "free lower", "--report", "run.html"),
            "demo": ("demo", "tower", "-o", "demo"),
        }
        each = max(1, 3 * kills // 4 // len(commands))
        longest = {"plan -o": 8.0, "show -o": 3.0, "run --report": 15.0, "demo": 20.0}
        found: list[Killed] = []
        for command, arguments in commands.items():
            moments = np.sort(rng.uniform(0.1, longest[command], each))
            left: list[list[str]] = []
            for moment in moments.tolist():
                progress(f"{command}, killed after {moment:.1f} s")
                left.append(_after_kill(place, arguments, moment))
            found.append(_killed(command, left))
        if kills > each * len(commands):
            found.append(_bench(place, kills - each * len(commands), rng, progress))
    return found


def _killed(command: str, left: Sequence[Sequence[str]]) -> Killed:
    """What a command leaves, kill by kill, as a count."""
    return Killed(
        command, len(left), sum(not each for each in left), tuple(said for each in left for said in each)
    )


def _scene(place: Path) -> tuple[str, ...]:
    clouds = scene_for("free lower").clouds
    np.savez(str(place / "scene.npz"), **dict[str, Any](clouds))
    return "scene.npz", "--fixed", "table", "--up", "0", "0", "1"


def _bench(place: Path, kills: int, rng: np.random.Generator, progress: Progress) -> Killed:
    """`bench run`, killed soon after each episode that it keeps."""
    journal = place / "runs.jsonl"
    left: list[list[str]] = []
    for number in range(kills):
        progress(f"bench run, killed after episode {number + 1}")
        before = _lines(journal)
        arguments = ("bench", "run", "--journal", journal.name)
        with _started(place, arguments) as process:
            until = time.monotonic() + LONGEST
            while _lines(journal) == before and time.monotonic() < until and process.poll() is None:
                time.sleep(0.1)
            time.sleep(float(rng.uniform(0.0, 1.0)))
            left.append(_ended(place, process))
    text = journal.read_text(encoding="utf-8") if journal.exists() else ""
    kept = Counter(json.dumps(json.loads(line)["episode"], sort_keys=True) for line in text.splitlines())
    if not kept:
        left[-1].append(f"bench run kept no episode in {kills} times {LONGEST:.0f} s")
    left[-1] += [f"bench run counted twice: {episode}" for episode, count in kept.items() if count > 1]
    return _killed(f"bench run, {len(kept)} episodes kept meanwhile", left)


def _lines(journal: Path) -> int:
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def _started(place: Path, arguments: Sequence[str]) -> "subprocess.Popen[bytes]":
    scratch = place / "tmp"
    scratch.mkdir(exist_ok=True)
    return subprocess.Popen(
        [*TOPPLE, *arguments], cwd=place, env={**os.environ, "TMPDIR": str(scratch)},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def _after_kill(place: Path, arguments: Sequence[str], moment: float) -> list[str]:
    """What is left of a command that is killed after some seconds."""
    with _started(place, arguments) as process:
        try:
            process.wait(moment)
        except subprocess.TimeoutExpired:
            pass
        return _ended(place, process)


def _ended(place: Path, process: "subprocess.Popen[bytes]") -> list[str]:
    workers = _descendants(process.pid)
    process.send_signal(signal.SIGKILL)
    process.wait()
    until = time.monotonic() + GONE_WITHIN
    while any(map(_alive, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    left = [f"worker {pid} outlived its parent" for pid in workers if _alive(pid)]
    subprocess.run(
        [sys.executable, "-c", NEXT_START], env={**os.environ, "TMPDIR": str(place / "tmp")}, check=True
    )
    left += [f"a folder was left: {lock.parent.name}" for lock in (place / "tmp").glob(f"*/{LOCK}")]
    return left + _halves(place)


def _halves(place: Path) -> list[str]:
    """Files that are not whole, and sets of which a part is missing."""
    found = [f"{path.name} was left" for path in place.rglob("*.part")]
    for path in (*place.glob("*.json"), *place.glob("demo/*.json")):
        try:
            json.loads(path.read_text(encoding="utf-8"))
        except ValueError:
            found.append(f"{path.name} is no JSON")
    for path in (*place.glob("*.html"), *place.glob("demo/*.html")):
        if not path.read_text(encoding="utf-8").rstrip().endswith("</html>"):
            found.append(f"{path.name} has no end")
    files = sorted(path.name for path in place.glob("demo/*"))
    return found + ([f"of a demo there is only {', '.join(files)}"] if len(files) not in (0, 5) else [])


def _descendants(pid: int) -> list[int]:
    parents: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and (fields := _stat(int(entry.name))):
            parents.setdefault(int(fields[1]), []).append(int(entry.name))
    found, waiting = list[int](), [pid]
    while waiting:
        children = parents.get(waiting.pop(), [])
        found += children
        waiting += children
    return found


def _stat(pid: int) -> list[str]:
    """State, parent and more of a process; empty where it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except (OSError, UnicodeDecodeError):
        return []


def _alive(pid: int) -> bool:
    return bool(fields := _stat(pid)) and fields[0] != "Z"


def refuse(quick: bool, progress: Progress) -> list[Refused]:
    """Run commands whose output finds no room, is a folder, or goes to a pipe that nobody reads.

    Args:
        quick: Only those that take seconds.
        progress: Called before each.

    Returns:
        What became of them.
    """
    with tempfile.TemporaryDirectory(prefix="topple-full-") as name:
        place = Path(name)
        scene = _scene(place)
        (place / "folder.html").mkdir()
        goal = ("--goal", "free lower")
        cases = [
            ("show -o FILE, disk full", ("show", *scene, "-o", "new.html"), ROOM, None),
            ("show -o FILE, which is a folder", ("show", *scene, "-o", "folder.html"), None, None),
            ("show -o FILE, no such folder", ("show", *scene, "-o", "no/new.html"), None, None),
            ("show -o FILE, in /proc", ("show", *scene, "-o", "/proc/new.html"), None, None),
            ("relate > /dev/full", ("relate", *scene), None, "/dev/full"),
            ("relate to a closed pipe", ("relate", *scene), None, "|"),
            ("bench run --journal /dev/full", ("bench", "run", "--journal", "/dev/full"), None, None),
            ("plan -o /dev/full", ("plan", *scene, *goal, "-o", "/dev/full"), None, None),
            ("run --report /dev/full", ("run", *scene, *goal, "--report", "/dev/full"), None, None),
            ("demo, disk full", ("demo", "tower", "-o", "new-demo"), 10 * ROOM, None),
        ]
        found: list[Refused] = []
        for what, arguments, room, output in cases[:7] if quick else cases:
            progress(what)
            found.append(Refused(what, _refusal(place, arguments, room, output)))
    return found


def _refusal(place: Path, arguments: Sequence[str], room: int | None, output: str | None) -> str:
    """What a command did that it should not; empty where it said no in a line and left nothing."""
    if output == "|":
        reading, writing = os.pipe()
        os.close(reading)
    else:
        writing = os.open(output or os.devnull, os.O_WRONLY)

    def limited() -> None:
        if room is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    before = _files_in(place)
    done = subprocess.run(
        [*TOPPLE, *arguments], cwd=place, stdout=writing, stderr=subprocess.PIPE, text=True,
        preexec_fn=limited, check=False,
    )  # fmt: skip
    os.close(writing)
    said = [line for line in done.stderr.splitlines() if not line.endswith(" s)")]  # those are of progress
    wanted, lines = (0, 0) if output == "|" else (2, 1)
    wrong = f"exit code {done.returncode}, " if done.returncode != wanted else ""
    wrong += f"{len(said)} lines: {said[-3:]}, " if len(said) != lines else ""
    made = _files_in(place) - before
    return (wrong + (f"left {sorted(made)}" if made else "")).strip(", ")


def _files_in(place: Path) -> set[str]:
    return {str(path.relative_to(place)) for path in place.rglob("*") if path.is_file()}
