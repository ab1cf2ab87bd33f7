"""Every reward term by hand: two worlds, three agents, signs mixed, no weight or scale of 1."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Transport, rewards
from coopenv.power import Power
from coopenv.transition import Transition
from coopenv.wrench import Decomposer, Decomposition, Settings
from coopenv.wrench.answer import Answer
from tests.helpers import TRIO

OWN = Settings(torque_weight=0.25)  # J = ¾ Σ‖f‖ + ¼ Σ|t|
OTHER = Settings(method="moore_penrose")
INTERNAL = np.array([  # [N, N, N·m]; in world 1 all of it is internal
    [[2, -3, 1.5], [-4, 1, 2], [2, 2, -4]],
    [[3, 4, -1.4], [0, 0, 0], [-3, -4, 1]],
])  # fmt: skip
MANIPULATION = np.array([[[6, 0, 0], [0, 8, -1], [0, 0, 2]], np.zeros((3, 3))])
APPLIED = INTERNAL + MANIPULATION  # (8, −3, 1.5), (−4, 9, 1), (2, 2, −2); forces sum up to (6, 8)
ACTION = [[[1, -0.5, 0.25], [-1, 0, 0.5], [0, 0, 0]], [[0.2, 0, 0]] * 3]
BEFORE = [[[0.5, 0.5, -0.25], [1, 0, 0.5], [0, 0, -1]], [[0.2, 0, 0]] * 3]
STORED = np.array([[0.5, 0.25, 0.0], [1.0, 2.0, 3.0]])  # [J]
WANTED = (0.5, 0.3, 0.2)


def hand_made() -> Transition:
    """Grips are (−0.9, 0), (0.3, 0.05) and (0.9, −0.05) m."""
    core = Transport(num_worlds=2, body=TRIO, decomposition=OWN)
    core.reset(seed=0)
    assert core.transition is not None
    state = core.transition.state
    step = replace(
        core.transition,
        applied=APPLIED,
        action=np.array(ACTION),
        previous_action=np.array(BEFORE),
        state=replace(state, distance=np.array([3.0, 1.0])),
        next_state=replace(state, distance=np.array([2.5, 1.25])),
        success=np.array([True, False]),
        terminated=np.array([True, False]),
        contact_impulse=np.array([1.5, 0.25]),
        dt=0.1,
        stored_energy=STORED,
    )
    step._power.append(
        Power(np.zeros((2, 3)), np.ones((2, 3)) / 3, np.array([True, True]), np.array([1.5, 0.25]))
    )
    for settings, internal in ((OWN, INTERNAL), (OTHER, 2 * INTERNAL)):
        decomposer = Decomposer(core.team.grips[0], settings)
        split = Decomposition(APPLIED, Answer(manipulation=APPLIED - internal), decomposer)
        if settings is OWN:
            step._own.append(split)
        else:
            step._decompositions[settings] = split
    return step


SQUEEZED = np.array([[np.sqrt(13), np.sqrt(17), np.sqrt(8)], [5, 0, 5]])
# r × f + t: 2.7 + 1.5, 0.5 + 2, 1.9 − 4; −3.6 − 1.4, 0, −3.75 + 1
TWISTED = np.array([[4.2, 2.5, 2.1], [5, 0, 2.75]])
COST = 0.75 * (np.sqrt(73) + np.sqrt(97) + np.sqrt(8)) + 0.25 * 4.5, 0.75 * 10 + 0.25 * 2.4
KEPT = 0.75 * 14 + 0.25 * 3, 0.0
WASTE = np.array([[COST[0] - KEPT[0]] * 3, [COST[1]] * 3])
ALIKE = np.ones(3)

CASES = {
    "success": (rewards.Success(weight=7.0), [7 * ALIKE, 0 * ALIKE]),
    "time": (rewards.TimeCost(weight=3.0), [-0.3 * ALIKE, -0.3 * ALIKE]),
    "progress": (rewards.Progress(weight=2.0), [6 * ALIKE, -0.5 * ALIKE]),
    "shaping": (
        rewards.PotentialShaping(
            potential=lambda state: -(state.distance**2), discount=0.9, weight=2.0
        ),
        [18 * ALIKE, 2 * (1 - 0.9 * 1.5625) * ALIKE],
    ),
    "tracking": (rewards.TrackingError(weight=3.0), [-0.75 * ALIKE, -0.375 * ALIKE]),
    "effort": (
        rewards.Effort(weight=0.1, torque_weight=0.5),
        [[-7.3 - 1.125, -9.7 - 0.5, -0.8 - 2], [-2.5 - 0.98, 0, -2.5 - 0.5]],
    ),
    "internal force": (rewards.InternalForce(weight=0.2), -0.2 * SQUEEZED),
    "internal force, asked otherwise": (
        rewards.InternalForce(weight=0.2, settings=OTHER), -0.4 * SQUEEZED,
    ),
    "internal torque": (rewards.InternalTorque(weight=0.5), -0.5 * TWISTED),
    "internal torque, asked otherwise": (
        rewards.InternalTorque(weight=0.5, settings=OTHER), -TWISTED,
    ),
    "relative cost": (
        rewards.RelativeCost(weight=0.3), [-0.3 * (1 - KEPT[0] / COST[0]) * ALIKE, -0.3 * ALIKE],
    ),
    "wasted cost": (rewards.WastedCost(weight=0.3, scale=4.0), -0.3 / 4 * WASTE),
    # Along (0.6, 0.8) they bear 2.4, 4.8 and 2.8 of 10 N; world 1 has no resultant.
    "force share": (
        rewards.LoadShare(weight=0.4, scale=4.0, wanted=WANTED),
        [[-0.26, -0.18, -0.08], [-0.5, 0, -0.5]],
    ),
    "force share, even": (
        rewards.LoadShare(weight=0.4, scale=4.0),
        -0.1 * np.array([[10 / 3 - 2.4, 4.8 - 10 / 3, 10 / 3 - 2.8], [5, 0, 5]]),
    ),
    "force share, one wish": (
        rewards.LoadShare(weight=0.4, scale=4.0, wanted=0.2),
        [[-0.04, -0.28, -0.08], [-0.5, 0, -0.5]],
    ),
    "force share, in parts": (
        rewards.LoadShare(weight=0.4, scale=None, wanted=WANTED),
        [[-0.4 * 0.26, -0.4 * 0.18, -0.4 * 0.08], [0, 0, 0]],
    ),
    # At the centre of mass 4.2, 3.9 and −0.1 of 8 N·m, and −5, 0 and −2.75 of −7.75 N·m. Who turns
    # against the resultant has no share (eq. 25), but is charged.
    "torque share": (
        rewards.LoadShare(weight=0.4, scale=4.0, wanted=WANTED, of="torque"),
        [[-0.02, -0.15, -0.17], [-0.1125, -0.2325, -0.12]],
    ),
    "torque share, in parts": (
        rewards.LoadShare(weight=0.4, scale=None, wanted=WANTED, of="torque"),
        [
            [-0.4 * (4.2 / 8.1 - 0.5), -0.4 * (3.9 / 8.1 - 0.3), -0.08],
            [-0.45 / 7.75, -0.93 / 7.75, -0.48 / 7.75],
        ],
    ),
    "action rate": (rewards.ActionRate(weight=0.5), [[-0.75, -2, -0.5], [0, 0, 0]]),
    "internal power": (
        rewards.InternalPower(weight=0.3, scale=2.0), [-0.225 * ALIKE, -0.0375 * ALIKE],
    ),
    "stored energy": (rewards.StoredEnergy(weight=0.4, scale=2.0), -0.2 * STORED),
    "contact": (rewards.Contact(weight=2.0), [-3 * ALIKE, -0.5 * ALIKE]),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_each_term_is_what_a_hand_computes(name):
    term, wanted = CASES[name]
    np.testing.assert_allclose(term(hand_made()), wanted, rtol=1e-12, atol=1e-12)


def test_every_term_there_is_stands_in_the_table_of_values():
    known = {type(term) for term, _ in CASES.values()}
    assert known == {type(term) for each in rewards.PRESETS.values() for term in each.values()} | {
        rewards.PotentialShaping, rewards.WastedCost, rewards.LoadShare,
        rewards.InternalPower, rewards.StoredEnergy,
    }  # fmt: skip


def test_a_sum_adds_its_parts_for_each_agent_and_reports_them_by_name():
    names = ("effort", "progress", "internal torque")
    total, parts = rewards.RewardSum({name: CASES[name][0] for name in names})(hand_made())
    wanted = [[6 - 8.425 - 2.1, 6 - 10.2 - 1.25, 6 - 2.8 - 1.05],
              [-0.5 - 3.48 - 2.5, -0.5, -0.5 - 3 - 1.375]]  # fmt: skip
    np.testing.assert_allclose(total, wanted, rtol=1e-12)
    assert list(parts) == list(names)
    for name in names:
        np.testing.assert_allclose(parts[name], CASES[name][1])


def test_new_weights_reach_only_the_terms_they_name():
    term = rewards.Effort(weight=0.1, torque_weight=0.5)
    mixed = rewards.RewardSum({"effort": term, "contact": rewards.Contact(weight=2.0)})
    changed = mixed.with_weights(effort=0.2)
    assert changed["effort"] == rewards.Effort(weight=0.2, torque_weight=0.5)
    assert changed["contact"] is mixed["contact"]
    assert mixed["effort"] is term


@pytest.mark.parametrize("weight", [1e12, -1e12, 0])
def test_a_weight_may_be_as_large_as_numbers_of_the_package_get(weight):
    assert len(rewards.RewardSum({"bonus": rewards.Success(weight=weight)})) == 1
    with pytest.raises(ValueError, match="weight of reward 'bonus' must be at most 1e"):
        rewards.RewardSum({"bonus": rewards.Success(weight=np.copysign(1.001e12, weight))})
