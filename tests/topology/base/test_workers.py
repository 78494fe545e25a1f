"""Workers do not outlive the process that they work for, however it ends."""

import os
import signal
import subprocess
import sys
import time

import pytest

POOL = """
import os, time
from topple.topology.base.workers import WorkerPool
if __name__ == "__main__":
    pool = WorkerPool(2)
    print(*{pool.submit(os.getpid).result() for _ in range(2)}, flush=True)
    busy = pool.submit(time.sleep, 60)
    time.sleep(60)
"""
FORKS = """
import multiprocessing, os, time
from topple.topology.base.workers import serve
def work():
    serve()
    os.write(1, b"%d\\n" % os.getpid())  # in one piece: the other one writes at the same time
    while True:
        sum(range(10**6))
if __name__ == "__main__":
    context = multiprocessing.get_context("fork")
    for _ in range(2):
        context.Process(target=work, daemon=True).start()
    time.sleep(60)
"""


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        return file.read().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.parametrize(("program", "lines"), [(POOL, 1), (FORKS, 2)], ids=["spawned", "forked"])
def test_workers_leave_when_their_parent_is_killed(tmp_path, program, lines):
    script = os.path.join(str(tmp_path), "program.py")
    with open(script, "w", encoding="utf-8") as file:
        file.write(program)
    parent = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    workers = [int(word) for _ in range(lines) for word in parent.stdout.readline().split()]
    assert workers and all(map(alive, workers))
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    until = time.monotonic() + 5.0
    while any(map(alive, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, workers))


INTERRUPTED = """
import os, time
from topple.topology.base.workers import WorkerPool
if __name__ == "__main__":
    try:
        with WorkerPool(1) as pool:
            pool.submit(os.getpid)
            print("begun", flush=True)
            any(time.sleep(0.1) for _ in range(600))  # one long sleep does not hear a signal just before it
    except KeyboardInterrupt:
        print("ended", flush=True)
"""


@pytest.mark.parametrize("seconds", [0.02, 0.2, 0.6])
def test_ctrl_c_while_a_worker_starts_ends_it_without_a_word(tmp_path, seconds):
    script = os.path.join(str(tmp_path), "program.py")
    with open(script, "w", encoding="utf-8") as file:
        file.write(INTERRUPTED)
    parent = subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert parent.stdout is not None and parent.stdout.readline() == "begun\n"
    time.sleep(seconds)
    os.killpg(parent.pid, signal.SIGINT)  # as a terminal does
    out, err = parent.communicate(timeout=60)
    assert (out, err) == ("ended\n", "")
