"""Elements of MATLAB 5 files are checked before SciPy reads them, which some would bring down."""

import io

import numpy as np
import pytest

pytest.importorskip("scipy")

from scipy.io import savemat
from scipy.sparse import csc_matrix

from coopenv.errors import InvalidInput
from coopenv.logs import read
from coopenv.logs.formats import open_source

EVERYTHING = {
    "time": np.arange(5.0),
    "cell": np.array([1.0, "a", np.ones(3)], dtype=object),
    "trial": {"left": np.arange(5.0), "more": {"text": "calm", "square": np.eye(2)}},
    "records": np.array([(1, 2.0), (3, 4.0)], dtype=[("p", "O"), ("q", "O")]),
    "wave": np.arange(5) * 1j,
    "sparse": csc_matrix(np.eye(3)),
    "counts": np.arange(5, dtype=np.int16),
    "nothing": np.zeros((0, 0)),
    "is": np.array([True, False]),
}


def content(**said) -> bytes:
    made = io.BytesIO()
    savemat(made, EVERYTHING, **said)
    return made.getvalue()


def kind_of_data(of: bytes | bytearray, name: bytes) -> int:
    """Where the data of a variable says its kind."""
    at = of.index(name)
    return at + len(name) + (-len(name) % 4 if len(name) <= 4 else -len(name) % 8)


@pytest.mark.parametrize("compressed", [False, True])
def test_whatever_matlab_writes_is_gone_through(compressed, tmp_path):
    path = tmp_path / "a.mat"
    path.write_bytes(content(do_compression=compressed))
    source = open_source(path)
    assert {"time", "trial.left", "counts"} <= set(source.columns)


@pytest.mark.parametrize("kind", [0, 8, 10, 11, 14, 15, 19, 200])
def test_a_kind_that_is_none_is_refused_and_does_not_end_the_interpreter(kind, tmp_path):
    data = bytearray(content())
    data[kind_of_data(data, b"time")] = kind
    path = tmp_path / "a.mat"
    path.write_bytes(bytes(data))
    says = r"a.mat, variable at byte 128 must be whole .* got an element of kind \d+ before byte"
    with pytest.raises(InvalidInput, match=says):
        open_source(path)


def deep(levels: int) -> bytes:
    """Cells within one another."""
    value = np.ones(2)
    for _ in range(levels):
        outer = np.empty((1, 1), dtype=object)
        outer[0, 0] = value
        value = outer
    made = io.BytesIO()
    savemat(made, {"time": np.arange(3.0), "a": value})
    return made.getvalue()


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (content()[:-3], r"got \d+ of \d+ bytes from byte"),
        (deep(40), "matrices nested more than 32 deep"),
        (
            content().replace(b"\x01\x00\x00\x00\x03\x00\x00\x00", b"\x01\0\0\0\0\0\1\0", 1),
            "more than",
        ),
    ],
)
def test_matrices_that_are_not_whole_are_refused(data, says, tmp_path):
    path = tmp_path / "a.mat"
    path.write_bytes(data)
    with pytest.raises(InvalidInput, match=says) as raised:
        open_source(path)
    assert "; save it again" in str(raised.value)


def test_a_name_of_several_lines_is_told_in_one(tmp_path):
    arrays = {"time": np.arange(5.0), **{f"abc{axis}": np.arange(5.0) for axis in "xyz"}}
    made = io.BytesIO()
    savemat(made, arrays, format="4")
    path = tmp_path / "a.mat"
    path.write_bytes(made.getvalue().replace(b"abcx", b"f1\nx"))
    with pytest.raises(
        InvalidInput, match=r"column f1x must be there, .* --map f1x=f1 x;"
    ) as raised:
        read(path)
    assert "\n" not in str(raised.value)
