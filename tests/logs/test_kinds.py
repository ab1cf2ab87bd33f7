"""Recorded files of every kind on the page are read as the page says."""

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from coopenv.logs import Layout, read
from tests.logs import cases
from tests.logs.kinds import KINDS, recorded

LAYOUT = {"grips": cases.BEAM}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_file_of_this_kind_is_read(kind, tmp_path):
    if kind.needs:
        pytest.importorskip(kind.needs)
    path = kind.write(tmp_path)
    found = read(path, Layout(**LAYOUT, **kind.layout))
    rows = list(kind.rows)
    if len(found) < len(rows):  # markers end a sample before analog channels
        assert kind.name == "C3D"
        rows = rows[: len(found)]
    wanted = {name: values[rows] for name, values in recorded().items()}
    assert found.time is not None
    np.testing.assert_allclose(found.time - found.time[0], wanted["time"], atol=3e-7)
    tolerance = 1e-6 if kind.name in ("C3D", "Parquet, lists of one length") else 1e-9  # float32
    np.testing.assert_allclose(found.applied, cases.wrench(wanted), rtol=tolerance, atol=tolerance)
    assert found.good.all()


def test_there_are_as_many_kinds_as_the_page_promises():
    names = [kind.name for kind in KINDS]
    assert len(set(names)) == len(names) >= 30
