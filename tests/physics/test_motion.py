"""The closed-form motion against the analytic solutions of a free body with drag."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coopenv.physics import motion
from coopenv.physics.coefficients import coefficients

MASS, INERTIA = 7.7, 2.5  # [kg], [kg·m²]
FORCE = np.array([12.0, -5.0])  # [N], object frame
TORQUE = 3.0  # [N·m]


@dataclass
class Body:
    """A body moved by `motion.advance` alone."""

    linear_drag: float = 8.0
    angular_drag: float = 4.0
    pose: tuple[float, float, float] = (0.3, -0.2, 0.7)
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def after(self, seconds: float, force=(0.0, 0.0), torque=0.0, *, step=0.025):
        """Pose and twist after ``seconds`` under a wrench held in the object frame."""
        one = np.ones(1)
        table = coefficients(
            MASS * one, INERTIA * one, self.linear_drag * one, self.angular_drag * one, step
        )
        pose, twist = np.array(self.pose), np.array(self.twist)
        for _ in range(round(seconds / step)):
            held = (*pose[2:], *twist, *force, torque)
            change = motion.advance(table, 0, motion.Motion._make(held))
            pose, twist = pose + change[:3], np.array(change[3:])
        return pose, twist


def close(actual, wanted, *, within=1e-10):
    np.testing.assert_allclose(actual, wanted, rtol=0, atol=within)


def rotated(vector, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


@pytest.mark.parametrize("drag", [0.0, 1e-9, 1e-3, 8.0, 300.0, 5000.0])
def test_a_pure_force_brings_the_body_to_its_terminal_speed_as_calculus_says(drag):
    start = Body(linear_drag=drag, twist=(0.4, 0.1, 0.0))
    seconds = 5.0
    pose, twist = start.after(seconds, FORCE)
    pushed, rate = rotated(FORCE, start.pose[2]) / MASS, drag / MASS
    if rate * seconds < 1e-6:  # series of the expressions below, to O(rate)
        faded = seconds - rate * seconds**2 / 2
        covered = seconds**2 / 2 - rate * seconds**3 / 6
    else:
        faded = -np.expm1(-rate * seconds) / rate  # ∫ exp(−rate·s) ds
        covered = (seconds - faded) / rate
    v0 = np.array(start.twist[:2])
    close(twist[:2], v0 * np.exp(-rate * seconds) + pushed * faded)
    close(pose[:2], np.array(start.pose[:2]) + v0 * faded + pushed * covered)
    assert (pose[2], twist[2]) == (start.pose[2], 0.0)


@pytest.mark.parametrize("drag", [0.0, 1e-9, 1e-3, 4.0, 300.0, 5000.0])
def test_a_pure_torque_spins_the_body_up_as_calculus_says(drag):
    start = Body(angular_drag=drag, twist=(0.0, 0.0, -0.5))
    seconds = 4.0
    pose, twist = start.after(seconds, torque=TORQUE)
    gain, rate = TORQUE / INERTIA, drag / INERTIA
    if rate * seconds < 1e-6:
        faded = seconds - rate * seconds**2 / 2
        covered = seconds**2 / 2 - rate * seconds**3 / 6
    else:
        faded = -np.expm1(-rate * seconds) / rate
        covered = (seconds - faded) / rate
    assert twist[2] == pytest.approx(-0.5 * np.exp(-rate * seconds) + gain * faded, abs=1e-10)
    assert pose[2] == pytest.approx(start.pose[2] - 0.5 * faded + gain * covered, abs=1e-10)
    np.testing.assert_array_equal(pose[:2], start.pose[:2])


def test_a_body_left_alone_coasts_the_length_its_momentum_pays_for():
    start = Body(twist=(1.3, -0.4, 2.0))
    pose, twist = start.after(60.0)
    path = np.array(start.twist) * [MASS / 8.0, MASS / 8.0, INERTIA / 4.0]  # p / d
    close(pose, np.array(start.pose) + path)
    close(twist, 0.0)


def test_a_body_in_motion_stays_in_motion_without_drag():
    start = Body(linear_drag=0.0, angular_drag=0.0, twist=(1.3, -0.4, 2.0))
    pose, twist = start.after(7.0)
    close(pose, np.array(start.pose) + 7.0 * np.array(start.twist))
    close(twist, start.twist, within=1e-15)


def test_a_force_held_in_a_turning_body_drives_it_round_a_circle():
    # Without drag v̇ = R(θ₀ + ωt) f / m integrates to v₀ + R(θ₀)(R(ωt − π/2) − R(−π/2)) f / (mω).
    spin, seconds = 1.7, 6.0
    start = Body(linear_drag=0.0, angular_drag=0.0, twist=(0.0, 0.0, spin))
    _, twist = start.after(seconds, FORCE)
    angle = start.pose[2]
    wanted = rotated(FORCE, angle + spin * seconds - np.pi / 2) - rotated(FORCE, angle - np.pi / 2)
    close(twist[:2], wanted / (MASS * spin))


@pytest.mark.parametrize("linear_drag", [0.0, 8.0, 60.0])
@pytest.mark.parametrize("angular_drag", [0.0, 4.0, 25.0])
def test_a_wrench_held_in_the_body_agrees_with_a_tight_numerical_solution(
    linear_drag, angular_drag
):
    start = Body(linear_drag, angular_drag, twist=(0.5, -0.3, 1.0))
    seconds = 2.0

    def rate(_, state):
        force = rotated(FORCE, state[2]) - linear_drag * state[3:5]
        return [*state[3:], *(force / MASS), (TORQUE - angular_drag * state[5]) / INERTIA]

    begin = [*start.pose, *start.twist]
    wanted = solve_ivp(rate, (0, seconds), begin, "DOP853", rtol=3e-14, atol=1e-14).y[:, -1]
    pose, twist = start.after(seconds, FORCE, TORQUE, step=0.0125)
    close(np.concatenate([pose, twist]), wanted)


def test_the_error_falls_with_the_sixth_power_of_the_step():
    start = Body(twist=(0.5, -0.3, 6.0))
    exact, _ = start.after(1.6, FORCE, TORQUE, step=0.00625)
    coarse, fine = (start.after(1.6, FORCE, TORQUE, step=step)[0] for step in (0.2, 0.1))
    gained = np.linalg.norm(coarse - exact) / np.linalg.norm(fine - exact)
    assert gained > 2**5.5
