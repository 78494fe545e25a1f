"""Folders for temporary files go with their process, or are cleared away by the next one."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from topple.robots.scratch import Scratch

HOLD = """
import time
from topple.robots.scratch import Scratch
scratch = Scratch()
print(scratch.path, flush=True)
time.sleep(60)
"""
MAKE = "from topple.robots.scratch import Scratch; s = Scratch(); s.close()"


def test_a_folder_is_removed_when_it_is_closed():
    scratch = Scratch()
    (scratch.path / "file").write_text("x")
    scratch.close()
    scratch.close()
    assert not scratch.path.exists()


def test_the_next_start_clears_away_what_killed_processes_left_and_nothing_else(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    tempfile.tempdir = None
    try:
        holders = [
            subprocess.Popen([sys.executable, "-c", HOLD], stdout=subprocess.PIPE, text=True)
            for _ in range(2)
        ]
        killed, living = (Path(str(holder.stdout and holder.stdout.readline()).strip()) for holder in holders)
        (tmp_path / "topple-other").mkdir()
        holders[0].send_signal(signal.SIGKILL)
        holders[0].wait()
        assert killed.exists()
        subprocess.run([sys.executable, "-c", MAKE], check=True)
        assert not killed.exists()
        assert living.exists()
        assert (tmp_path / "topple-other").exists()
        assert sorted(os.listdir(tmp_path)) == sorted([living.name, "topple-other"])
    finally:
        for holder in holders:
            holder.kill()
            holder.communicate()
        tempfile.tempdir = None
