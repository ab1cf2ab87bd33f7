"""What contacts did in a substep, read back by hand: impulse, shift, and who is lost."""

import numpy as np
import pytest

from coopenv.physics import collect
from coopenv.physics.coefficients import coefficients
from coopenv.physics.surroundings import NUM_GIVEN, WHEEL

MASS, INERTIA, REACH = 2.0, 3.0, 0.5  # [kg], [kg·m²], [m]
EXPECTED = [0.5, -0.2, 0.1, 1.0, 2.0, 0.3]  # twist and pose without contact


def collected(reported, *, wheels=False, origin=(0.0, 0.0), before=(0.0, 0.0), around=None):
    """Pose, twist, impulse, shift, and the world that is lost; what surroundings gave, added."""
    around = np.zeros((1, NUM_GIVEN)) if around is None else around
    one = np.ones(1)
    table = coefficients(
        MASS * one, INERTIA * one, 0 * one, 0 * one, 0.02, np.array([wheels]), REACH * one
    )
    pose, twist = np.zeros((1, 3)), np.zeros((1, 3))
    impulse, shift = np.array([before[0]]), np.array([before[1]])
    report = np.zeros((3, 6))
    report[2] = np.add(reported, [*origin, 0, 0, 0, 0])
    lost = collect.collect(
        np.array([2]), table, np.array([[*origin, 5.0, 4.0]]), report, np.array([EXPECTED]),
        pose, twist, impulse, shift, around, True,
    )  # fmt: skip
    return pose[0], twist[0], impulse[0], shift[0], lost


def test_without_a_contact_nothing_is_felt_and_the_pose_is_that_of_the_room():
    pose, twist, impulse, shift, lost = collected(
        [1.0, 2.0, 0.3, 0.5, -0.2, 0.1], origin=(40.0, -80.0), before=(0.25, 0.125)
    )
    np.testing.assert_allclose(pose, [1, 2, 0.3], atol=1e-12)
    np.testing.assert_allclose(twist, [0.5, -0.2, 0.1], atol=1e-15)
    assert (impulse, lost) == (0.25, -1)  # as before
    assert shift == pytest.approx(0.125, abs=1e-9)


@pytest.mark.parametrize(
    ("twist", "push"),
    [
        ((0.2, 0.2, 0.1), MASS * 0.5),  # Δ = (−0.3, 0.4): 1 N·s of push
        ((0.5, -0.2, 0.0), INERTIA * 0.1 / REACH),  # of the spin alone, at the longest lever
        ((0.2, 0.0, 0.0), max(MASS * np.hypot(0.3, 0.2), INERTIA * 0.1 / REACH)),
        ((0.44, -0.12, 0.09), max(MASS * 0.1, INERTIA * 0.01 / REACH)),
    ],
)
def test_the_impulse_is_the_least_that_explains_both_changes_of_momentum(twist, push):
    _, found, impulse, shift, _ = collected([1.0, 2.0, 0.3, *twist], before=(3.0, 0.0))
    np.testing.assert_allclose(found, twist, atol=1e-15)
    assert impulse == pytest.approx(3.0 + push)
    assert shift == 0.0


@pytest.mark.parametrize(
    ("moved", "shift"),
    [
        ((0.003, -0.004, 0.0), 0.005),
        ((0.0, 0.0, -0.02), REACH * 0.02),
        ((0.003, 0.004, 0.02), 0.005 + REACH * 0.02),
        ((0.0, 0.004, 0.0), 0.004),
        ((1e-14, 1e-14, 1e-14), 0.0),  # rounding
    ],
)
def test_the_shift_is_how_far_the_farthest_point_was_moved_off_its_path(moved, shift):
    pose = np.add([1.0, 2.0, 0.3], moved)
    _, _, impulse, found, _ = collected([*pose, 0.5, -0.2, 0.1], before=(0.0, 0.25))
    assert found == pytest.approx(0.25 + shift, abs=1e-12)
    assert impulse == 0.0


@pytest.mark.parametrize(
    ("place", "lost"),
    [
        ((4.999, 3.999), -1), ((-4.999, -3.999), -1), ((5.001, 0), 0), ((-5.001, 0), 0),
        ((0, 4.001), 0), ((0, -4.001), 0), ((np.nan, 0), 0), ((0, np.nan), 0),
    ],
)  # fmt: skip
def test_a_body_beyond_its_bounds_is_lost(place, lost):
    assert collected([*place, 0.3, 0.5, -0.2, 0.1])[-1] == lost


def test_on_wheels_the_velocity_stays_along_the_heading_and_the_impulse_grows_by_what_they_hold():
    heading = 0.3
    along = np.array([np.cos(heading), np.sin(heading)])
    rolling = along @ EXPECTED[:2]
    change = np.array([-0.1, 0.15])
    reported = [1.0, 2.0, heading, *(EXPECTED[:2] + change), 0.05]
    around = np.zeros((1, NUM_GIVEN))
    _, twist, impulse, _, _ = collected(reported, wheels=True, around=around)
    rolled, turned = along @ change, -0.05
    free = MASS * change @ change + INERTIA * turned**2
    factor = free / (MASS * rolled**2 + INERTIA * turned**2)
    delta = np.array([factor * rolled, factor * turned])
    weights = np.array([MASS, INERTIA])
    power = (weights * delta) @ [rolling, EXPECTED[2]]
    square = (weights * delta) @ delta
    part = 1.0 if power + square / 2 <= 0 else max(-power / square, 0.0)
    speed = rolling + part * delta[0]
    np.testing.assert_allclose(twist, [*(speed * along), EXPECTED[2] + part * delta[1]], atol=1e-12)
    push = factor * max(MASS * np.linalg.norm(change), INERTIA * 0.05 / REACH)
    assert impulse == pytest.approx(part * push)
    pressed = part * factor * MASS * np.array([rolled, across(heading) @ change])
    gave = MASS * (twist[:2] - EXPECTED[:2])
    np.testing.assert_allclose(around[0, 0], pressed[0], atol=1e-12)
    np.testing.assert_allclose(around[0, 1], across(heading) @ gave, atol=1e-12)
    np.testing.assert_allclose(around[0, 2], INERTIA * part * delta[1], atol=1e-12)
    # Of what is across, the wheels give what contacts do not: they hold what presses on them.
    np.testing.assert_allclose(around[0, WHEEL], around[0, 1] - pressed[1], atol=1e-12)
    assert abs(pressed[1]) > 0.1


def across(angle):
    return np.array([-np.sin(angle), np.cos(angle)])


def test_what_surroundings_gave_is_the_change_of_momentum_in_the_bodys_frame():
    around = np.ones((1, NUM_GIVEN))
    collected([1.0, 2.0, 0.3, 0.2, 0.1, -0.05], around=around)
    along = np.array([np.cos(0.3), np.sin(0.3)])
    change = MASS * np.array([-0.3, 0.3])
    wanted = [along @ change, across(0.3) @ change, INERTIA * -0.15, 0.0]
    np.testing.assert_allclose(around[0] - 1, wanted, atol=1e-12)
