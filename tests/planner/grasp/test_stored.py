"""Dicts of arrays come back as numpy stored them; whatever else a pickle asks for is refused and not run."""

import io
import os
import pickle
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib import format as npy

from topple.planner.grasp import stored
from topple.planner.grasp.stored import read_stored
from topple.topology.base.errors import InvalidInput


def wrapped(payload: bytes) -> bytes:
    """An .npy file that says it holds one object, with these bytes for it."""
    file = io.BytesIO()
    npy.write_array_header_1_0(file, {"descr": "|O", "fortran_order": False, "shape": ()})
    return file.getvalue() + payload


def saved(value: Any, protocol: int) -> bytes:
    array = np.empty((), dtype=object)
    array[()] = value
    return wrapped(pickle.dumps(array, protocol=protocol))


@pytest.mark.parametrize("protocol", [2, 3, 4, 5])
def test_dicts_of_arrays_come_back_as_they_were(protocol):
    rng = np.random.default_rng(0)
    given = {
        1: rng.normal(size=(300, 4, 4)).astype(np.float32),
        2.0: np.asfortranarray(rng.normal(size=(5, 3))),
        np.float32(3.0): np.arange(4, dtype=">i2"),
        "cup": np.zeros((0, 4, 4)),
        np.int64(-1): np.array(0.5),
        7: np.array([True, False]),
    }
    found = read_stored(saved(given, protocol), "g")
    assert isinstance(found, dict)
    assert list(found) == list(given)
    for key, array in given.items():
        assert found[key].dtype == array.dtype
        assert np.array_equal(found[key], array)


class Calls:
    """Pickles as a call."""

    def __init__(self, function: Any, *arguments: Any) -> None:
        self.call = function, arguments

    def __reduce__(self) -> Any:
        return self.call


def touching(path: Path) -> dict[str, bytes]:
    """Pickles that make a file, should anyone run them."""
    command, code = f"touch {path}", f"open({str(path)!r}, 'w')"
    array = np.zeros(3)
    state = b"\x80\x02cnumpy\nndarray\n}(X\x01\x00\x00\x00aK\x01ub."
    return {
        "a command": saved({1: Calls(os.system, command)}, 4),
        "a command for a key": saved({Calls(os.system, command): array}, 4),
        "evaluated text": saved({1: Calls(eval, code)}, 4),
        "executed text": saved({1: Calls(exec, code)}, 2),
        "a call in a call": saved({1: Calls(getattr, Calls(__import__, "os"), "system")}, 4),
        "a function of numpy": saved({1: Calls(np.save, str(path), array)}, 4),
        "a file mapped by numpy": saved({1: Calls(np.memmap, str(path), "u1", "w+", 0, (1,))}, 4),
        "what numpy imports": wrapped(
            b"\x80\x02cnumpy\nos.system\nX" + struct.pack("<I", len(command)) + command.encode() + b"\x85R."
        ),
        "an instance": wrapped(f"(S'{command}'\nios\nsystem\n.".encode()),
        "an object": wrapped(f"(cos\nsystem\nS'{command}'\no.".encode()),
        "a new object": wrapped(b"\x80\x02cnumpy\nndarray\n)\x81."),
        "a class that is changed": wrapped(state),
        "an extension": wrapped(b"\x80\x02\x82\x01."),
        "a persistent name": wrapped(b"\x80\x02X\x01\x00\x00\x00aQ."),
    }


@pytest.mark.parametrize("attack", list(touching(Path("x"))))
def test_what_is_no_dict_of_arrays_is_refused_and_not_run(tmp_path, attack):
    path = tmp_path / "made"
    with pytest.raises(InvalidInput, match="holds a pickle that is no dict of arrays") as refused:
        read_stored(touching(path)[attack], "g.npz")
    assert not path.exists()
    assert len(str(refused.value)) < 200


def test_the_attacks_do_what_they_say_where_they_are_unpickled(tmp_path):
    path = tmp_path / "made"
    file = io.BytesIO(touching(path)["a command"])
    np.load(file, allow_pickle=True)
    assert path.exists()


HEADER = b"\x80\x02"
HUGE = {
    "an array larger than its bytes": saved({1: Calls(np.ndarray, (1 << 40,))}, 4),
    "tuples in tuples": wrapped(HEADER + b"}" + b"(" + b")" + b"\x85" * 200_000 + b"K\x01u."),
    "tuples that double": wrapped(
        HEADER
        + b"}()"
        + b"".join(b"q" + bytes([k]) + b"h" + bytes([k]) + b"\x86" for k in range(60))
        + b"K\x01u."
    ),
    "no end of lists": wrapped(HEADER + b"]" * 3_000_000 + b"."),
    "nothing": wrapped(b""),
    "half a pickle": saved({1: np.zeros(100)}, 4)[:-40],
    "nothing on the stack": wrapped(HEADER + b"."),
    "no mark": wrapped(HEADER + b"}u."),
    "a number": saved(3, 4),
    "a list of arrays": saved([np.zeros(3), np.zeros(3)], 4),
    "itself": wrapped(HEADER + b"}q\x00K\x01h\x00s."),
    "no pickle": wrapped(b"\xff\xff\xff"),
}


@pytest.mark.parametrize("kind", list(HUGE))
def test_broken_and_endless_pickles_are_refused_in_a_line(kind):
    with pytest.raises(InvalidInput, match=r"g\.npz"):
        read_stored(HUGE[kind], "g.npz")


def test_arrays_that_together_are_too_large_are_refused(monkeypatch):
    shared = np.zeros(1000)
    data = saved(dict.fromkeys(range(200), shared), 4)
    monkeypatch.setattr(stored, "MOST_BYTES", 100_000)
    assert len(data) < 100_000
    with pytest.raises(InvalidInput, match="together"):
        read_stored(data, "g")
    with pytest.raises(InvalidInput, match="expected at most"):
        read_stored(bytes(100_001), "g")


def test_headers_that_claim_more_than_there_is_are_refused():
    file = io.BytesIO()
    npy.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (1 << 40, 17)})
    with pytest.raises(InvalidInput, match="no array"):
        read_stored(file.getvalue() + bytes(16), "g")


def test_a_far_place_in_the_memo_takes_no_memory():
    assert read_stored(wrapped(HEADER + b"}r\xff\xff\xff\xff."), "g") == {}


def test_a_header_that_does_not_end_is_refused_in_a_line():
    file = io.BytesIO()
    np.save(file, np.tile(np.eye(4), (2, 1, 1)))
    with pytest.raises(InvalidInput, match=r"^grasps\.npy: is no stored array: "):
        read_stored(file.getvalue().replace(b"}", b"(", 1), "grasps.npy")
