"""Versions of topple to compare: this tree or a commit's, each kept as a folder that a process can import."""

import ast
import hashlib
import io
import os
import shutil
import subprocess
import sys
import tarfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from topple.topology.base.errors import InvalidInput
from topple.topology.kernels.build import FOLDER, library, sources

LAYERS = ("topology", "robots", "planner")
FRONT, BUILD = "planner/topple.py", "build.py"
ROOT = Path(__file__).resolve().parents[1]
"""The checkout, or where the packages are installed."""


@dataclass(frozen=True)
class Version:
    """A version whose files no edit changes any more.

    Attributes:
        name: For a reader: a commit, with a + where files differ from it.
        key: Digest of the code of the three packages.
        folder: Holds the package `topple`; to be put on PYTHONPATH.
    """

    name: str
    key: str
    folder: Path


def today(cache: Path) -> Version:
    """This tree as it is now, uncommitted changes included.

    Args:
        cache: Folder of such folders.
    """
    return _kept(ROOT, commit_now() or "this tree", cache)


def of_commit(commit: str, cache: Path) -> Version:
    """A commit of the checkout that this is.

    Args:
        commit: As git knows it.
        cache: Folder of such folders.

    Raises:
        InvalidInput: This is no checkout, or git does not know the commit.
    """
    found = git("archive", f"{commit}^{{commit}}", *LAYERS)
    if found is None:
        raise InvalidInput(f"{commit} is no commit of a checkout at {ROOT}: give one that git log shows")
    scratch = cache / f".{commit.replace('/', '-')}-{os.getpid()}"
    with tarfile.open(fileobj=io.BytesIO(found)) as archive:
        archive.extractall(scratch, filter="data")
    try:
        name = (git("rev-parse", "--short=7", f"{commit}^{{commit}}") or b"").decode().strip()
        return _kept(scratch, name, cache)
    finally:
        shutil.rmtree(scratch)


def commit_now() -> str | None:
    """The commit of this checkout, with a + where the packages differ from it; None where it is none."""
    found = git("rev-parse", "--short=7", "HEAD")
    if found is None:
        return None
    return found.decode().strip() + ("+" if git("status", "--porcelain", "--", *LAYERS) else "")


@cache
def code_key(root: Path = ROOT) -> str:
    """Digest of the code of the three packages below a folder; comments and docstrings do not count."""
    digest = hashlib.sha256()
    for path in sorted(_files(root)):
        content = _bare(path) if path.suffix == ".py" else path.read_bytes()
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + content + b"\0")
    return digest.hexdigest()[:12]


def _bare(path: Path) -> bytes:
    """A module's syntax tree without its docstrings."""
    tree = ast.parse(path.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            node.body = [part for part in node.body if not _is_text(part)]
    return ast.dump(tree).encode()


def _is_text(part: ast.stmt) -> bool:
    return (
        isinstance(part, ast.Expr)
        and isinstance(part.value, ast.Constant)
        and isinstance(part.value.value, str)
    )


def git(*words: str) -> bytes | None:
    """What git says in this checkout; None where it fails or there is none."""
    try:
        done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, check=False)
    except OSError:
        return None
    return done.stdout if done.returncode == 0 else None


def _files(root: Path) -> list[Path]:
    found = [path for layer in LAYERS for path in (root / layer).rglob("*") if path.is_file()]
    return [path for path in found if "__pycache__" not in path.parts and path.suffix != ".so"]


def _same(ours: Path, theirs: Path) -> bool:
    return theirs.is_file() and theirs.read_bytes() == ours.read_bytes()


def _kept(root: Path, name: str, cache: Path) -> Version:
    """Copy the packages below a folder into the cache, unless they are there."""
    version = Version(name, key := code_key(root), cache.resolve() / key)
    if not version.folder.is_dir():
        scratch = cache.resolve() / f".{key}-{os.getpid()}"
        package = scratch / "topple"
        for path in _files(root):
            place = package / path.relative_to(root)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, place)
        front = root / FRONT
        (package / "__init__.py").write_text(front.read_text() if front.is_file() else "")
        kernels, built = package / "topology" / "kernels", library()
        if built.is_file() and all(_same(path, kernels / path.name) for path in (*sources(), FOLDER / BUILD)):
            shutil.copyfile(built, kernels / built.name)
        elif (kernels / BUILD).is_file():
            subprocess.run([sys.executable, str(kernels / BUILD)], check=False)
        scratch.rename(version.folder)
    return version
