"""References: interpolation, minimum jerk, and files."""

import numpy as np
import pytest

from coopenv import Reference, TrackingTask
from coopenv.errors import InvalidInput
from coopenv.tasks.reference import minimum_jerk, minimum_jerk_motion
from tests.helpers import LOOP

PLAN = np.array([[0.0, 0.0, 0.0, 1.0, 2.0, -1.0, 1.0, 0.0, 3.0]])  # two segments


def derivatives(motion_at, times, step=1e-5):
    """Central differences of the pose, and of the twist."""
    ahead, behind = motion_at(times + step), motion_at(times - step)
    return (ahead[:, :6] - behind[:, :6]) / (2 * step)


def segments(times):
    return minimum_jerk_motion(np.repeat(PLAN, len(times), axis=0), times, 4.0)


def test_a_table_passes_through_its_rows_and_rests_before_and_after():
    motion = LOOP.motion(np.array([-1.0, 0.0, 2.0, 4.0, 6.0, 9.0]))
    np.testing.assert_allclose(motion[1:5, :3], LOOP.poses, atol=1e-12)
    np.testing.assert_allclose(motion[[0, 5], :3], [LOOP.poses[0], LOOP.poses[-1]])
    assert not motion[[0, 1, 4, 5], 3:6].any()


@pytest.mark.parametrize("motion_at", [LOOP.motion, segments], ids=["table", "minimum jerk"])
def test_twist_and_acceleration_are_the_derivatives_of_the_pose(motion_at):
    times = np.random.default_rng(0).uniform(0.01, 3.99, 300)
    times = times[np.abs(times - 2.0) > 1e-3]  # a table's acceleration jumps at its rows
    np.testing.assert_allclose(motion_at(times)[:, 3:], derivatives(motion_at, times), atol=1e-6)


def test_minimum_jerk_goes_from_rest_to_rest_and_its_rates_are_its_derivatives():
    s = np.linspace(0, 1, 2001)
    share, rate, change = minimum_jerk(s)
    assert [share[0], share[-1], rate[0], rate[-1], change[0], change[-1]] == [0, 1, 0, 0, 0, 0]
    np.testing.assert_allclose(np.gradient(share, s)[1:-1], rate[1:-1], atol=1e-5)
    np.testing.assert_allclose(np.gradient(rate, s)[1:-1], change[1:-1], atol=1e-4)


def test_minimum_jerk_rests_at_its_way_points_and_peaks_in_between():
    motion = segments(np.array([0.0, 2.0, 4.0, 7.0]))
    np.testing.assert_allclose(motion[:3, :3], PLAN.reshape(3, 3), atol=1e-12)
    np.testing.assert_allclose(motion[3, :3], PLAN[0, 6:])
    np.testing.assert_allclose(motion[:, 3:], 0, atol=1e-12)
    assert segments(np.array([1.0]))[0, 4] == pytest.approx(1.875 * 2.0 / 2.0)


def test_a_smooth_motion_is_met_closely_between_its_rows():
    times = np.linspace(0, 4, 41)
    table = Reference(times=times.tolist(), poses=segments(times)[:, :3].tolist())
    between = np.linspace(0, 4, 397)
    np.testing.assert_allclose(table.motion(between)[:, :3], segments(between)[:, :3], atol=3e-3)


def test_an_angle_that_wraps_goes_on_smoothly():
    table = Reference(times=(0, 1, 2), poses=((0, 0, 3.0), (0, 0, -3.0), (0, 0, -2.8)))
    middle = table.motion(np.array([0.5]))[0, 2]
    assert 3.0 < middle < 2 * np.pi - 3.0
    assert np.abs(table.motion(np.linspace(0, 2, 50))[:, 5]).max() < 1.0


@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_a_file_gives_the_same_reference_as_its_table(tmp_path, kind):
    path = tmp_path / f"loop.{kind}"
    times, poses = np.array(LOOP.times) + 5.0, np.array(LOOP.poses)  # its clock began earlier
    if kind == "csv":
        rows = np.column_stack([poses[:, 2], times, poses[:, :2], poses[:, 0]])
        header = "theta, time, x, y, remark"
        np.savetxt(path, rows, delimiter=",", header=header, comments="")
    else:
        np.savez(path, time=times, x=poses[:, 0], y=poses[:, 1], theta=poses[:, 2])
    assert Reference.load(path) == LOOP
    assert TrackingTask(reference=path) == TrackingTask(reference=str(path))
    assert TrackingTask(reference=str(path)).reference == LOOP


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,x,y\n0,0,0\n1,0,0\n", r"columns time, x, y, theta, got time, x, y .*add theta"),
        ("", r"must have the columns"),
        ("time,x,y,theta\n0,0,0,0\n1,0,zero,0\n", r"number in every column, .* in line 3"),
        ("time,x,y,theta\n0,0,0,0\n1,0,0\n", r"number in every column, .* in line 3"),
        ("time,x,y,theta\n0,0,0,0\n2,0,0,0\n1,0,0,0\n", r"times must increase, got 1.0 after 2.0"),
        ("time,x,y,theta\n0,0,0,0\n0,0,0,0\n", r"times must increase"),
        ("time,x,y,theta\n0,0,0,0\n", r"two or more rows"),
        ("time,x,y,theta\n0,0,0,nan\n1,0,0,0\n", r"reference\.poses must be finite"),
    ],
)
def test_a_broken_file_is_refused_with_its_fault(tmp_path, text, said):
    path = tmp_path / "broken.csv"
    path.write_text(text)
    with pytest.raises(InvalidInput, match=said):
        Reference.load(path)


def test_columns_of_different_lengths_are_refused(tmp_path):
    np.savez(tmp_path / "odd.npz", time=[0, 1], x=[0, 1], y=[0, 1], theta=[0, 1, 2])
    with pytest.raises(InvalidInput, match="columns of one length"):
        Reference.load(tmp_path / "odd.npz")
