"""Reward terms on hand-made transitions, their sums, shaping and presets."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from coopenv import Transport, rewards, wrench
from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, UnknownName
from coopenv.rewards import terms
from coopenv.transition import Transition

SQUEEZE = [[[4.0, 0.0, 0.0], [-4.0, 0.0, 0.0]]]  # object frame [N, N, N·m]
TWIST = [[[0.0, 0.0, 3.0], [0.0, 0.0, -3.0]]]
LIFT = [[[0.0, 3.0, 0.0], [0.0, 1.0, 0.0]]]


def step(applied: list | FloatArray | None = None, **changes) -> Transition:
    """A transition of one world, with what is given put in."""
    core = Transport(num_worlds=1)
    core.reset(seed=3)
    core.step(np.zeros((1, 2, 3)))
    assert core.transition is not None
    forces = np.zeros((1, 2, 3)) if applied is None else np.array(applied)
    return replace(core.transition, applied=forces, **changes)


def with_distance(
    before: float, after: float, *, done: bool = False, failed: bool = False
) -> Transition:
    """A transition that came from one distance to another."""
    at = step()
    return replace(
        at,
        state=replace(at.state, distance=np.array([before])),
        next_state=replace(at.next_state, distance=np.array([after])),
        success=np.array([done]),
        terminated=np.array([done or failed]),
    )


def test_every_term_is_handed_on():
    made = {name for name, each in vars(terms).items() if isinstance(each, type)}
    own = {name for name in made if getattr(terms, name).__module__ == terms.__name__}
    assert own <= set(rewards.__all__)
    assert "Contact" in own


def test_squeezing_costs_each_agent_the_norm_of_its_internal_force():
    assert rewards.InternalForce(weight=0.5)(step(SQUEEZE)) == pytest.approx(-2.0)


def test_unequal_loads_in_one_direction_are_not_squeezing():
    together = [[[0.0, 3.0, 0.0], [0.0, 3.0, 0.0]]]
    assert rewards.InternalForce()(step(together)) == pytest.approx(0.0, abs=1e-12)
    ahead = [[[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]]
    assert rewards.InternalForce()(step(ahead)) == pytest.approx(0.0, abs=1e-12)


def test_twisting_against_each_other_costs_the_torque_at_the_centre():
    assert rewards.InternalTorque(weight=2.0)(step(TWIST)) == pytest.approx(-6.0)


def test_relative_cost_is_full_where_everything_cancels_and_zero_where_nothing_does():
    assert rewards.RelativeCost(weight=0.3)(step(SQUEEZE)) == pytest.approx(-0.3)
    ahead = [[[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]]
    assert rewards.RelativeCost(weight=0.3)(step(ahead)) == pytest.approx(0.0, abs=1e-9)


def test_a_term_may_ask_for_another_decomposition_than_the_environments():
    wasteful = rewards.InternalForce(weight=1.0, settings=wrench.Settings(method="moore_penrose"))(
        step([[[2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    )
    assert wasteful == pytest.approx(-1.0)  # the paper's figure 2: pseudoinverses say ±1


def test_wasted_cost_is_priced_in_units_of_its_scale_and_alike_for_all():
    squeeze = rewards.WastedCost(weight=0.3, scale=2.0)(step(SQUEEZE))  # wastes 4 N at w = 0.5
    assert squeeze == pytest.approx(np.full((1, 2), -0.6))
    ahead = [[[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]]
    assert rewards.WastedCost()(step(ahead)) == pytest.approx(0.0, abs=1e-12)
    heavy = wrench.Settings(torque_weight=0.75)
    assert rewards.WastedCost(weight=1.0, scale=1.0, settings=heavy)(step(TWIST)) == pytest.approx(
        -4.5
    )


def test_wasted_cost_leaves_idle_hands_alone_where_the_relative_cost_does_not():
    core = Transport(num_worlds=500)
    core.reset(seed=0)
    core.step(np.random.default_rng(0).normal(scale=0.005, size=(500, 2, 3)))
    assert core.transition is not None
    waste = rewards.WastedCost(weight=1.0)(core.transition)
    relative = rewards.RelativeCost(weight=1.0)(core.transition)
    assert relative.mean() < -0.1
    assert -0.005 < waste.mean() < 0.0


def test_wasted_cost_sees_little_of_squeezing_across_a_common_effort():
    across = [[[4.0, 10.0, 0.0], [-4.0, 10.0, 0.0]]]
    assert rewards.WastedCost(weight=1.0, scale=1.0)(step(across)) == pytest.approx(-0.77, abs=0.01)
    assert rewards.InternalForce(weight=1.0)(step(across)) == pytest.approx(-4.0)


@pytest.mark.parametrize(
    "term", [rewards.WastedCost, rewards.LoadShare, rewards.InternalPower, rewards.StoredEnergy]
)
@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), "ten"])
def test_a_scale_that_is_no_positive_number_is_refused(term, scale):
    with pytest.raises(InvalidInput, match="scale must be"):
        term(scale=scale)


def test_load_share_charges_the_newtons_by_which_it_is_missed():
    shared = rewards.LoadShare(weight=1.0, scale=1.0)(step(LIFT))
    assert shared == pytest.approx(np.full((1, 2), -1.0))  # 3 N and 1 N of 4 N
    kept = rewards.LoadShare(weight=1.0, wanted=(0.75, 0.25))(step(LIFT))
    assert kept == pytest.approx(0.0, abs=1e-12)
    against = rewards.LoadShare(weight=1.0, scale=1.0, wanted=(1.0, 0.0))(
        step([[[0.0, 3.0, 0.0], [0.0, -1.0, 0.0]]])
    )
    assert against == pytest.approx(np.full((1, 2), -1.0))
    turning = rewards.LoadShare(weight=1.0, scale=1.0, of="torque")
    grip = Transport(num_worlds=1).team.grips[0, 0, 0]  # m along the beam
    pressed = step([[[0.0, 2.0 / grip, 0.0], [0.0, 0.0, 4.0]]])  # 2 and 4 N·m
    assert turning(pressed) == pytest.approx(np.full((1, 2), -1.0))


def test_load_share_pays_nobody_for_an_undefined_share():
    assert rewards.LoadShare(weight=1.0, scale=1.0)(step(SQUEEZE)) == pytest.approx(-4.0)
    assert rewards.LoadShare(weight=1.0, scale=1.0, of="torque")(step(TWIST)) == pytest.approx(-3.0)
    assert rewards.LoadShare()(step()).tolist() == [[0.0, 0.0]]  # nothing applied, nothing to share


def test_load_share_costs_as_much_just_before_it_is_undefined():
    term = rewards.LoadShare(weight=1.0, scale=1.0)
    nearly = [[[4.0, 0.0, 0.0], [-4.0 + 1e-6, 0.0, 0.0]]]
    assert term(step(nearly)) == pytest.approx(term(step(SQUEEZE)), abs=1e-5)


def test_load_share_without_scale_is_a_part_of_the_resultant_and_free_where_undefined():
    term = rewards.LoadShare(weight=1.0, scale=None)
    assert term(step(LIFT)) == pytest.approx(-0.25)
    assert term(step(SQUEEZE)).tolist() == [[0.0, 0.0]]
    torque = rewards.LoadShare(of="torque", scale=None)
    assert torque(step()).tolist() == [[0.0, 0.0]]


def test_load_share_rejects_wishes_for_another_number_of_agents():
    with pytest.raises(InvalidInput, match="wanted must be one number or one for each of 2"):
        rewards.LoadShare(wanted=(0.2, 0.3, 0.5))(step(LIFT))
    with pytest.raises(InvalidInput, match="of must be"):
        rewards.LoadShare(of="power")  # pyright: ignore[reportArgumentType]


def test_effort_is_quadratic_in_force_and_torque():
    applied = [[[3.0, 4.0, 2.0], [0.0, 0.0, 0.0]]]
    effort = rewards.Effort(weight=0.1, torque_weight=1.0)(step(applied))
    assert effort == pytest.approx(np.array([[-2.5 - 4.0, 0.0]]))


def test_action_rate_compares_with_the_action_before():
    action = np.array([[[1.0, 0.0, 0.0], [0.5, 0.0, 0.0]]])
    moved = step(action=action, previous_action=np.zeros((1, 2, 3)))
    assert rewards.ActionRate(weight=1.0)(moved) == pytest.approx(np.array([[-1.0, -0.25]]))
    held = step(action=action, previous_action=action)
    assert rewards.ActionRate(weight=1.0)(held).tolist() == [[0.0, 0.0]]


def test_contact_costs_its_impulse():
    assert rewards.Contact(weight=2.0)(step(contact_impulse=np.array([1.5]))) == pytest.approx(-3.0)


def test_success_pays_in_the_step_it_happens_and_time_costs_always():
    assert rewards.Success(weight=7.0)(step(success=np.array([True]))) == pytest.approx(7.0)
    assert rewards.Success(weight=7.0)(step()).tolist() == [[0.0, 0.0]]
    assert rewards.TimeCost(weight=1.0)(step()) == pytest.approx(-0.05)


def test_progress_pays_metres_nearer_and_takes_them_back():
    assert rewards.Progress(weight=2.0)(with_distance(3.0, 2.5)) == pytest.approx(1.0)
    assert rewards.Progress(weight=2.0)(with_distance(2.5, 3.0)) == pytest.approx(-1.0)
    assert rewards.Progress()(with_distance(2.0, 2.0)).tolist() == [[0.0, 0.0]]


def test_the_potential_is_zero_at_success_but_neither_at_truncation_nor_at_failure():
    assert rewards.Progress()(with_distance(0.4, 0.1, done=True)) == pytest.approx(0.4)
    assert rewards.Progress()(with_distance(0.4, 0.1, failed=True)) == pytest.approx(0.3)
    late = replace(with_distance(0.4, 0.1), truncated=np.array([True]))
    assert rewards.Progress()(late) == pytest.approx(0.3)


def test_a_failure_takes_what_success_would_pay():
    term = rewards.Success(weight=3.0)
    paid = [
        term(with_distance(1.0, 1.0, **how)).tolist()
        for how in ({}, {"done": True}, {"failed": True})
    ]
    assert paid == [[[0.0, 0.0]], [[3.0, 3.0]], [[-3.0, -3.0]]]


@given(
    st.lists(st.floats(0, 10), min_size=2, max_size=20),
    st.floats(0.5, 1.0),
)
def test_discounted_shaping_telescopes_to_the_start_potential(distances: list[float], rate: float):
    term = rewards.PotentialShaping(potential=lambda state: -state.distance, discount=rate)
    total, last = 0.0, len(distances) - 2
    for k in range(last + 1):
        at = with_distance(distances[k], distances[k + 1], done=k == last)
        total += rate**k * float(term(at)[0, 0])
    assert total == pytest.approx(distances[0], abs=1e-9)


@pytest.mark.parametrize("discount", [0.0, -0.1, 1.01, float("nan")])
def test_a_discount_outside_its_range_is_refused(discount: float):
    with pytest.raises(InvalidInput, match="discount must be"):
        rewards.Progress(discount=discount)


@pytest.mark.parametrize("name", sorted(rewards.PRESETS))
def test_a_total_is_the_sum_of_its_parts_and_zero_weights_leave_nothing(name: str):
    core = Transport(num_worlds=5, reward=name)
    core.reset(seed=0)
    *_, info = core.step(np.random.default_rng(0).uniform(-1, 1, (5, 2, 3)))
    assert core.transition is not None
    total, parts = core.reward(core.transition)
    assert set(info["reward_terms"]) == set(parts) == set(rewards.PRESETS[name])
    np.testing.assert_allclose(total, sum(parts.values()), atol=1e-15)
    silent = core.reward.with_weights(**dict.fromkeys(core.reward, 0.0))
    if "effort" in silent:  # its torque has a weight of its own
        silent = rewards.RewardSum(
            {**silent, "effort": rewards.Effort(weight=0.0, torque_weight=0.0)}
        )
    assert not silent(core.transition)[0].any()


def test_every_term_is_evaluated_once_a_step():
    calls = []

    def counted(transition: Transition) -> FloatArray:
        calls.append(1)
        return np.ones(transition.applied.shape[:2])

    core = Transport(num_worlds=2, reward=counted)
    core.reset(seed=0)
    _, reward, *_ = core.step(np.zeros((2, 2, 3)))
    assert len(calls) == 1
    assert reward.tolist() == [[1.0, 1.0]] * 2


def test_returned_parts_do_not_alias_the_total():
    total, parts = rewards.RewardSum({"time": rewards.TimeCost()})(step())
    total += 1
    assert parts["time"] == pytest.approx(-0.025)


def test_logged_transitions_can_be_pickled_and_rewarded_again_under_other_weights():
    core = Transport(num_worlds=3, reward="balanced")
    core.reset(seed=1)
    generator = np.random.default_rng(1)
    log, paid = [], []
    for _ in range(4):
        _, reward, *_ = core.step(generator.uniform(-1, 1, (3, 2, 3)))
        log.append(core.transition)
        paid.append(reward)
    log = pickle.loads(pickle.dumps(log))
    total, parts = rewards.recompute(rewards.PRESETS["balanced"], log)
    np.testing.assert_array_equal(total, paid)
    heavier = rewards.PRESETS["balanced"].with_weights(internal_force=1.0)
    _, changed = rewards.recompute(heavier, log)
    np.testing.assert_allclose(changed["internal_force"], 100 * parts["internal_force"])
    np.testing.assert_array_equal(changed["progress"], parts["progress"])


def test_bad_sums_name_what_is_wrong():
    with pytest.raises(UnknownName, match="did you mean 'harmony'"):
        rewards.find_reward("harmnoy")
    with pytest.raises(InvalidInput, match="at least one term"):
        rewards.RewardSum({})
    with pytest.raises(InvalidInput, match="callable terms"):
        rewards.RewardSum({"squeeze": 3.0})  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidInput, match="reward must be a preset name"):
        rewards.find_reward(rewards.Progress)
    with pytest.raises(UnknownName, match="did you mean 'progress'"):
        rewards.PRESETS["task"].with_weights(progres=1.0)
    with pytest.raises(InvalidInput, match="at least one step"):
        rewards.recompute(rewards.PRESETS["task"], [])


@pytest.mark.parametrize("value", [np.ones(2), np.ones((2, 1)), 1.0])
def test_a_term_of_another_shape_is_refused_by_name(value):
    core = Transport(num_worlds=2, reward={"odd": lambda transition: value})
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match="reward 'odd' must return an array"):
        core.step(np.zeros((2, 2, 3)))


def holed(value: float):
    """A term that is right but for agent 1 of world 2."""

    def term(transition: Transition) -> FloatArray:
        paid = np.zeros(transition.applied.shape[:2])
        paid[2, 1] = value
        return paid

    return term


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_a_reward_that_is_not_finite_is_refused_by_the_name_of_its_term(value):
    core = Transport(num_worlds=3, reward={"success": rewards.Success(), "holed": holed(value)})
    core.reset(seed=0)
    with pytest.raises(InvalidInput, match=f"'holed' must be finite, got {value} for agent 1 of w"):
        core.step(np.zeros((3, 2, 3)))
    with pytest.raises(InvalidInput, match="'holed' must be finite"):
        rewards.recompute(rewards.RewardSum({"holed": holed(value)}), [core_at(3)])


def core_at(num_worlds: int) -> Transition:
    core = Transport(num_worlds=num_worlds)
    core.reset(seed=0)
    core.step(np.zeros((num_worlds, 2, 3)))
    assert core.transition is not None
    return core.transition


def test_rewards_of_any_finite_size_are_summed_unless_the_sum_is_none():
    at = core_at(3)
    total, _ = rewards.RewardSum({"large": holed(1e300)})(at)
    assert total[2, 1] == 1e300
    both = rewards.RewardSum({"one": holed(1.5e308), "two": holed(1.5e308)})
    with np.errstate(over="ignore"), pytest.raises(InvalidInput, match=r"'one' .* at most 1e"):
        both(at)


@pytest.mark.parametrize("weight", [float("nan"), "x", True])
def test_a_weight_that_is_no_finite_number_is_refused(weight):
    with pytest.raises(InvalidInput, match="weight of reward 'success'"):
        rewards.RewardSum({"success": rewards.Success(weight=weight)})


@pytest.mark.parametrize("wanted", [(), (0.5,), (0.2, 0.3, 0.5), [[0.5, 0.5]]])
def test_a_load_share_for_another_team_is_refused_at_construction(wanted):
    term = rewards.LoadShare(wanted=wanted)
    with pytest.raises(InvalidInput, match="wanted must be one number or one for each of 2 agents"):
        Transport(reward=term)
    with pytest.raises(InvalidInput, match="wanted must be"):
        Transport(reward={"load": term})


def test_sums_and_terms_hash_as_they_compare():
    one, same = (rewards.RewardSum({"load": rewards.LoadShare(wanted=[0.2, 0.8])}) for _ in "ab")
    assert one == same
    assert hash(one) == hash(same)
    assert len({*rewards.PRESETS.values(), one}) == len(rewards.PRESETS) + 1


def test_the_tracking_error_costs_by_the_second():
    far = rewards.TrackingError(weight=3.0)(with_distance(0.1, 0.4))
    assert far == pytest.approx(-3.0 * 0.4 * 0.05)
    assert rewards.TrackingError()(with_distance(0.4, 0.0)).tolist() == [[0.0, 0.0]]
