"""Friction on the ground: Coulomb's law for what slides and spins, and rest that is rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from coopenv import Body, Scene
from coopenv.errors import InvalidInput
from coopenv.physics.friction import held, mean_distance, rubbed
from coopenv.physics.world import World

G, DT = 9.81, 0.05  # [m/s²], [s]
HALL = Scene(size=(80.0, 80.0))  # [m]; nothing to touch


def sliding(friction=0.3, **values):
    return Body(**{"ground_friction": friction, "linear_drag": 0.0, "angular_drag": 0.0, **values})


def moved(body, steps, *, twist=(0.0, 0.0, 0.0), wrench=(0.0, 0.0, 0.0), substeps=2, scene=HALL):
    """Poses and twists after each step, from rest at the origin or with a twist."""
    one = World([body], [scene], dt=DT, substeps=substeps)
    one.place(np.array([0]), np.zeros((1, 3)))
    one.twist = np.array([twist], dtype=float)
    seen = []
    for step in range(steps):
        one.step(np.array([wrench(step) if callable(wrench) else wrench], dtype=float))
        seen.append(np.concatenate([one.pose[0], one.twist[0]]))
    return np.array(seen)


@pytest.mark.parametrize("substeps", [1, 2, 5])
@pytest.mark.parametrize("speed", [0.05, 0.7, 3.3])
def test_a_body_stops_after_v_squared_over_2_mu_g(speed, substeps):
    direction = np.array([0.6, -0.8])
    seen = moved(sliding(), 40, twist=(*(speed * direction), 0), substeps=substeps)
    np.testing.assert_allclose(seen[-1, :2], speed**2 / (2 * 0.3 * G) * direction, atol=1e-12)
    assert (seen[-1, 2:] == 0).all()
    still = int(np.ceil(speed / (0.3 * G) / DT))
    assert (seen[still:] == seen[-1]).all()


def test_a_spin_stops_as_the_torque_of_an_evenly_pressed_outline_says():
    body = sliding()
    assert body.inertia is not None
    length = 0.3 * G * body.mass * mean_distance(body.outline)  # [N·m]
    seen = moved(body, 40, twist=(0, 0, 2.0))
    assert seen[-1, 2] == pytest.approx(2.0**2 * body.inertia / (2 * length), abs=1e-12)
    assert (seen[-1, 3:] == 0).all()


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_a_push_below_the_limit_moves_nothing_and_one_above_moves_by_the_rest(angle):
    body = sliding()
    most = 0.3 * body.mass * G  # [N]
    for share in (0.2, 0.999):
        force = share * most * np.array([np.cos(angle), np.sin(angle)])
        assert (moved(body, 40, wrench=(*force, 0.0)) == 0).all()
    force = 1.2 * most * np.array([np.cos(angle), np.sin(angle)])
    pose = moved(body, 40, wrench=(*force, 0.0))[-1]
    gained = 0.2 * most / body.mass * np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(pose[:2], gained * 2.0, atol=1e-12)  # t² / 2 of 2 s
    np.testing.assert_allclose(pose[3:5], gained * 2.0, atol=1e-12)


def test_force_and_torque_share_the_limit():
    body = sliding()
    force, torque = held(body, HALL)
    inside, outside = 0.7 * np.array([force, torque]), 0.72 * np.array([force, torque])
    assert (moved(body, 20, wrench=(inside[0], 0, inside[1])) == 0).all()
    assert moved(body, 20, wrench=(outside[0], 0, outside[1]))[-1, 0] > 1e-3


def test_a_spinning_body_is_slowed_less_along_its_way_than_one_that_does_not_spin():
    straight = moved(sliding(), 60, twist=(1.0, 0, 0))[-1]
    spinning = moved(sliding(), 60, twist=(1.0, 0, 4.0))[-1]
    assert spinning[0] > 1.3 * straight[0]


@pytest.mark.parametrize("drag", [0.0, 8.0])
def test_what_slides_and_spins_agrees_with_a_tight_numerical_solution(drag):
    body = sliding(linear_drag=drag, angular_drag=drag)
    force, torque = held(body, HALL)

    def rate(_, state):
        velocity, spin = state[3:5], state[5]
        taken = np.sqrt(force**2 * (velocity @ velocity) + torque**2 * spin**2)
        pulled = -(force**2) * velocity / taken - drag * velocity
        turned = -(torque**2) * spin / taken - drag * spin
        return [*state[3:], *(pulled / body.mass), turned / body.inertia]

    begin = [0, 0, 0, 1.5, -0.5, 2.0]
    wanted = solve_ivp(rate, (0, 0.3), begin, "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    errors = []
    for substeps in (2, 20, 200):
        seen = moved(body, 6, twist=begin[3:], substeps=substeps)[-1]
        errors.append(np.abs(seen - wanted).max())
    assert errors[0] < 0.02
    assert errors[1] < errors[0] / 5
    assert errors[2] < errors[1] / 5


def test_the_work_of_a_push_is_kinetic_energy_and_what_friction_took():
    body, push = sliding(), 40.0
    most = 0.3 * body.mass * G
    seen = moved(body, 30, wrench=(push, 0.0, 0.0))
    path, speed = seen[-1, 0], seen[-1, 3]
    assert push * path == pytest.approx(body.mass * speed**2 / 2 + most * path, rel=1e-12)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=200)
def test_friction_takes_of_every_part_of_a_twist_and_reverses_none(seed):
    generator = np.random.default_rng(seed)
    limits = tuple(10 ** generator.uniform(-3, 3, 2))
    mass, inertia, step = *(10 ** generator.uniform(-2, 2, 2)), 10 ** generator.uniform(-3, 0)
    gains = step / mass, step**2 / mass / 2, step / inertia, step**2 / inertia / 2
    start, end = generator.normal(0, 1, (2, 3)) * 10 ** generator.uniform(-4, 1, (2, 3))
    path = (start + end) * step / 2
    change, left = (np.array(part) for part in rubbed(limits, gains, step, start, path, end))
    assert (np.abs(left) <= np.abs(end)).all()
    assert (left * end >= 0).all()
    gain, most = np.array(gains)[[0, 0, 2]], np.array(limits)[[0, 0, 1]]
    taken = (end - left) / gain  # [N, N·m]
    rounding = 1e-15 * np.abs(end) / gain  # of the difference
    share = ((taken / most) ** 2).sum()
    slack = 1e-9 + (2 * np.abs(taken) * rounding / most**2).sum()
    assert share <= 1 + slack
    if left.any():  # what slides feels all that there is, against where it goes
        assert share == pytest.approx(1, abs=slack)
        along, size = most**2 * left, np.linalg.norm(taken)
        off = np.abs(taken / size - along / np.linalg.norm(along))
        assert off.max() <= 1e-6 + 2 * np.linalg.norm(rounding) / size
    else:
        assert np.abs(change).max() <= np.abs(start).max() * step / 2 + 1e-15


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_push_that_comes_and_goes_makes_no_body_chatter(substeps):
    body = sliding(0.5)
    seen = moved(body, 200, wrench=lambda step: (60.0 * (step % 20 < 3), 0, 0), substeps=substeps)
    assert (seen[:, 3] >= 0).all()
    assert (np.diff(seen[:, 0]) >= 0).all()
    assert (seen[19::20, 3:] == 0).all()
    assert seen[-1, 0] > 0.05


def test_the_mean_distance_is_that_of_a_disc_a_square_and_any_shape():
    disc = tuple((np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 721)[:-1])
    assert mean_distance(disc) == pytest.approx(2 / 3, rel=1e-4)
    square = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    assert mean_distance(square) == pytest.approx((np.sqrt(2) + np.arcsinh(1)) / 3)
    assert mean_distance(square[::-1]) == pytest.approx(mean_distance(square))
    rim = ((0.0, -1.0), (2.0, -1.0), (2.0, 1.0), (0.0, 1.0))  # the centre lies on an edge
    across = quad(lambda x: quad(lambda y: np.hypot(x, y), -1, 1)[0], 0, 2)[0]
    assert mean_distance(rim) == pytest.approx(across / 4)


def test_what_presses_a_body_on_the_ground_can_be_another_gravity():
    moon = Scene(size=(80.0, 80.0), normal_gravity=1.62)
    far = moved(sliding(), 60, twist=(0.5, 0, 0), scene=moon)[-1, 0]
    assert far == pytest.approx(0.5**2 / (2 * 0.3 * 1.62), abs=1e-12)
    assert held(sliding(), Scene(normal_gravity=0.0)) == (0.0, 0.0)


def test_a_ground_below_a_body_that_slides_downhill_holds_it_up_to_its_angle():
    for lean, slides in ((0.29, False), (0.31, True)):  # tan, against a coefficient of 0.3
        ramp = Scene(size=(80.0, 80.0), gravity=(-lean * G, 0.0), normal_gravity=G)
        assert moved(sliding(), 20, scene=ramp)[-1].any() == slides


def test_wheels_do_not_slide():
    with pytest.raises(InvalidInput, match=r"body\.ground_friction must be 0 on wheels, got 0\.2"):
        Body.walker(ground_friction=0.2)
    with pytest.raises(InvalidInput, match=r"body\.ground_friction must be zero or positive"):
        Body(ground_friction=-0.1)
