"""A laboratory's habits, declared in one layout, leave the measures as they are."""

import numpy as np
import pytest

from coopenv.logs import Layout, analyse, read
from tests.logs import cases
from tests.logs.calibration import lab

MEASURES = ("internal_force_level", "internal_torque_level", "relative_cost")
HABITS = ("rotation", "offset", "bias", "handle", "order", "units")


def measured(recording, every=50):
    return analyse(recording.take(slice(None, None, every)))


def recorded(columns, path, **layout):
    return read(cases.save(columns, path), Layout(**layout))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("lab")


@pytest.fixture(scope="module")
def truth(folder):
    return recorded(dict(lab.spatial()), folder / "truth.npz")


@pytest.mark.parametrize("habits", [*((each,) for each in HABITS), HABITS])
def test_what_a_laboratory_does_to_wrenches_in_space_is_undone(habits, truth, folder):
    columns = lab.written_in_space(*habits)
    seen = recorded(columns, folder / "a.npz", **lab.layout_in_space(*habits))
    np.testing.assert_allclose(seen.applied, truth.applied, rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen.orientation, truth.orientation, rtol=0, atol=1e-12)
    if len(habits) > 1:
        got, wanted = measured(seen, 500), measured(truth, 500)
        for name in MEASURES:  # of solvers, to their own tolerance in space
            np.testing.assert_allclose(got[name], wanted[name], atol=1e-6, err_msg=name)
