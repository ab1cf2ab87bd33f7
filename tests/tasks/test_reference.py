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


def test_a_table_rests_in_every_number_at_its_ends_and_beyond_them():
    motion = LOOP.motion(np.array([-1.0, 0.0, 6.0, 9.0]))
    rest = [(*LOOP.poses[0], *[0.0] * 6)] * 2 + [(*LOOP.poses[-1], *[0.0] * 6)] * 2
    np.testing.assert_array_equal(motion, rest)
    just = LOOP.motion(np.array([1e-9, 6.0 - 1e-9]))
    np.testing.assert_allclose(just[:, :3], [LOOP.poses[0], LOOP.poses[-1]], atol=1e-6)
    np.testing.assert_allclose(just[:, 3:6], 0.0, atol=1e-6)


def test_between_uneven_rows_it_is_the_cubic_through_velocities_of_finite_differences():
    table = Reference(times=(1.0, 2.0, 5.0), poses=((0, 0, 0), (1, -2, 0.3), (7, 4, 0.9)))
    assert table.times == (0.0, 1.0, 4.0)  # they count from the first
    assert table.duration == 4.0
    # Slopes 1 and 2 m/s over 1 and 3 s: the middle row moves at (3 · 1 + 1 · 2) / 4 m/s.
    rates = np.array([1.25, (3 * -2 + 1 * 2) / 4, (3 * 0.3 + 1 * 0.2) / 4])
    np.testing.assert_allclose(table.motion(np.array([1.0]))[0, 3:6], rates)
    # Half-way: mean of the ends and an eighth of the time times the difference of their speeds
    first, second = table.motion(np.array([0.5, 2.5]))
    np.testing.assert_allclose(first[:3], np.array([0.5, -1, 0.15]) - 1 / 8 * rates)
    np.testing.assert_allclose(second[:3], np.array([4, 1, 0.6]) + 3 / 8 * rates)
    np.testing.assert_allclose(first[3:6], 1.5 * np.array([1, -2, 0.3]) - rates / 4)
    np.testing.assert_allclose(second[6:], -rates / 3)  # the difference of the speeds by the time
    np.testing.assert_allclose(first[6:], rates)


def test_two_rows_are_a_table():
    line = Reference(times=(0.0, 2.0), poses=((0, 0, 0), (4, -2, 1)))
    np.testing.assert_allclose(
        line.motion(np.array([1.0]))[0], [2, -1, 0.5, 3, -1.5, 0.75, 0, 0, 0]
    )


def test_minimum_jerk_by_hand():
    np.testing.assert_allclose(minimum_jerk(0.5), (0.5, 1.875, 0.0))
    np.testing.assert_allclose(minimum_jerk(0.25), (53 / 512, 30 * 9 / 256, 60 * 3 / 32))
    # The second of two segments of 2 s, a quarter of it gone
    motion = segments(np.array([2.5]))[0]
    way = np.array([0.0, -2.0, 4.0])
    np.testing.assert_allclose(motion[:3], np.array([1, 2, -1]) + 53 / 512 * way)
    np.testing.assert_allclose(motion[3:6], 30 * 9 / 256 / 2 * way)
    np.testing.assert_allclose(motion[6:], 60 * 3 / 32 / 4 * way)


@pytest.mark.parametrize("time", [-1.0, 0.0, 4.0, 5.0])
def test_before_its_begin_and_after_its_end_minimum_jerk_rests(time):
    motion = segments(np.array([time]))[0]
    np.testing.assert_allclose(motion[:3], PLAN[0, :3] if time <= 0 else PLAN[0, 6:], atol=1e-12)
    np.testing.assert_allclose(motion[3:], 0.0, atol=1e-12)


def test_a_bad_line_after_a_blank_one_has_the_number_of_its_line(tmp_path):
    path = tmp_path / "late.csv"
    path.write_text("time,x,y,theta\n0,0,0,0\n\n1,0,0,0\n2,0,?,0\n")
    with pytest.raises(InvalidInput, match="in line 5 of"):
        Reference.load(path)
