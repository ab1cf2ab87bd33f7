"""Sensors: how they err, how late they are, and that they depend on nothing but the seed."""

import dataclasses
import pickle

import gymnasium
import numpy as np
import pytest
from scipy import stats

import coopenv
from coopenv import BLOCKS, Block, Sensor, Transport
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import ranges
from tests.helpers import NEVER, OPEN_ROOM, TRIO, actions

NOISY = Sensor("twist", noise=0.02, bias=0.01, delay=2)


def run(observe, *, steps=12, num_worlds=4, seed=0, **keywords):
    """Everything that was seen ``(step, world, agent, feature)`` under the same pushes."""
    core = Transport(
        num_worlds=num_worlds, observe=observe, scene=OPEN_ROOM, task=NEVER, **keywords
    )
    pushes = actions(1, steps, 64, core.num_agents, core.action_size)[:, :num_worlds]
    seen = [core.reset(seed=seed)[0], *(core.step(push)[0] for push in pushes)]
    return np.array(seen)


def errors(sensor, **keywords):
    """What a sensor adds to the truth ``(step, world, agent, feature)``."""
    return run((sensor,), **keywords).astype(float) - run((sensor.block,), **keywords)


def test_noise_is_normal_of_the_deviation_given_and_new_everywhere():
    noise = np.array([0.5, 1.0, 2.0])
    drawn = errors(Sensor("twist", noise=noise.tolist()), steps=40, num_worlds=60) / noise
    assert stats.kstest(drawn.ravel(), "norm").pvalue > 0.01
    flat = drawn.transpose(3, 2, 0, 1).reshape(6, -1)  # (feature · agent, sample)
    correlation = np.corrcoef(flat) - np.eye(6)
    assert np.abs(correlation).max() < 4 / np.sqrt(flat.shape[1])
    for axis in (0, 1):  # one step after the other, one world beside the other
        first, second = np.delete(drawn, 0, axis).ravel(), np.delete(drawn, -1, axis).ravel()
        assert abs(np.corrcoef(first, second)[0, 1]) < 4 / np.sqrt(first.size)


def test_a_bias_stays_for_an_episode_and_is_each_agents_own():
    drawn = errors(Sensor("own_wrench", bias=2.0), num_worlds=64)
    np.testing.assert_allclose(drawn, np.broadcast_to(drawn[0], drawn.shape), atol=1e-5)
    assert stats.kstest(drawn[0].ravel() / 2.0, "norm").pvalue > 0.01
    assert len(np.unique(drawn[0])) == drawn[0].size
    core = Transport(num_worlds=2, observe=(Sensor("own_wrench", bias=2.0),))
    first, _ = core.reset(seed=0)
    again, _ = core.reset()
    assert (first != again).all()  # the next episode has another


def test_noise_and_bias_add_up_and_blocks_err_apart():
    both = errors(Sensor("twist", noise=0.5, bias=0.3), num_worlds=3)
    noise, bias = errors(Sensor("twist", noise=0.5)), errors(Sensor("twist", bias=0.3))
    np.testing.assert_allclose(both, (noise + bias)[:, :3], atol=1e-6)
    other = errors(Sensor("own_wrench", noise=0.5))
    assert (np.abs(other - noise) > 1e-6).all()


def test_a_sensor_errs_the_same_alone_and_in_any_company():
    alone = run((NOISY,))
    beside = run(("time", Sensor("goal", noise=0.1), NOISY, Sensor("load_share", delay=3)))
    np.testing.assert_array_equal(beside[..., 5:8], alone)


@pytest.mark.parametrize("delay", [0, 1, 2, 5])
def test_a_delayed_reading_is_that_of_so_many_steps_ago_and_before_that_the_first(delay):
    truth, late = run(("twist", "goal")), run((Sensor("twist", delay=delay), "goal"))
    for step in range(len(truth)):
        np.testing.assert_array_equal(late[step, ..., :3], truth[max(step - delay, 0), ..., :3])
    np.testing.assert_array_equal(late[..., 3:], truth[..., 3:])
    assert not delay or (late[6, ..., :3] != truth[6, ..., :3]).any()


def test_readings_that_do_not_fit_into_memory_are_refused_with_their_size(monkeypatch):
    def full(shape, *rest, **named):
        if len(np.atleast_1d(shape)) == 4:  # (delay, world, agent, feature)
            raise MemoryError
        return np.empty(shape, *rest, **named)

    monkeypatch.setattr(np, "zeros", full)
    with pytest.raises(InvalidInput, match=r"10000 steps of 3 worlds, 0.00072 GB; lower it"):
        Transport(num_worlds=3, observe=(Sensor("twist", delay=10_000),))


def test_noise_is_delayed_with_what_it_is_on():
    now, late = run((Sensor("twist", noise=1.0),)), run((Sensor("twist", noise=1.0, delay=3),))
    np.testing.assert_array_equal(late[3:], now[:-3])


def test_the_same_seed_gives_the_same_bits_and_another_seed_others():
    first = run((NOISY, "obstacles"))
    np.testing.assert_array_equal(first, run((NOISY, "obstacles")))
    assert (first[..., :3] != run((NOISY, "obstacles"), seed=9)[..., :3]).all()


def test_what_a_world_reads_does_not_depend_on_its_neighbours():
    many = run((NOISY,), num_worlds=7)
    for count in (1, 3):
        np.testing.assert_allclose(run((NOISY,), num_worlds=count), many[:, :count], atol=1e-6)
    alone = Transport(observe=(NOISY,))
    for k in range(3):
        np.testing.assert_array_equal(alone.reset(seed=k)[0][0], many[0, k])


def test_a_reset_of_some_worlds_leaves_the_history_of_the_others_alone():
    observe = (Sensor("twist", noise=0.1, bias=0.1, delay=3), Sensor("own_wrench", delay=4))
    cores = [Transport(num_worlds=3, observe=observe, scene=OPEN_ROOM) for _ in range(2)]
    mask = np.array([False, True, False])
    for core in cores:
        core.reset(seed=0)
    for step, push in enumerate(actions(0, 12, 3, 2, 3)):
        if step == 5:
            obs, _ = cores[0].reset(mask=mask)
            np.testing.assert_array_equal(obs[[0, 2]], kept[[0, 2]])  # pyright: ignore # noqa: F821
        kept, other = (core.step(push)[0] for core in cores)
        np.testing.assert_array_equal(kept[~mask], other[~mask])
        assert (kept[mask] == other[mask]).all() == (step < 5)


@pytest.mark.parametrize("how", ["reset", "restart"])
def test_a_new_episode_starts_without_the_history_of_the_last_one(how):
    core = Transport(num_worlds=2, observe=(Sensor("own_wrench", delay=2),), scene=OPEN_ROOM)
    core.reset(seed=0)
    pushes = actions(0, 4, 2, 2, 3)
    for push in pushes:
        obs, *_ = core.step(push)
    assert obs.all()  # pyright: ignore[reportPossiblyUnboundVariable]
    mask = np.array([True, False])
    if how == "reset":
        obs, _ = core.reset(mask=mask)
    else:
        obs, *_ = core.step(pushes[0], restart=mask)
    assert not obs[0].any()
    assert obs[1].all()
    for _ in range(2):
        obs, *_ = core.step(pushes[1])
        assert not obs[0].any()
    assert core.step(pushes[1])[0][0].all()


def test_every_view_reads_the_same():
    keywords = {"observe": (NOISY, Sensor("obstacles", noise=0.1, delay=1)), "horizon": 6}
    core = Transport(num_worlds=2, **keywords)
    vector = gymnasium.make_vec("coopenv/BeamTransport-v0", num_envs=2, **keywords)
    singles = [gymnasium.make("coopenv/BeamTransport-v0", **keywords) for _ in range(2)]
    parallel = coopenv.beam_transport_v0.parallel_env(**keywords)
    wanted = core.reset(seed=3)[0]
    rows = wanted.reshape(2, -1)
    np.testing.assert_array_equal(vector.reset(seed=3)[0], rows)
    for k, env in enumerate(singles):
        np.testing.assert_array_equal(env.reset(seed=3 + k)[0], rows[k])
    seen, _ = parallel.reset(seed=3)
    np.testing.assert_array_equal(list(seen.values()), wanted[0])
    for push in actions(0, 5, 2, 2, 3).astype(np.float32):
        wanted = core.step(push)[0]
        rows = wanted.reshape(2, -1)
        np.testing.assert_array_equal(vector.step(push.reshape(2, -1))[0], rows)
        for k, env in enumerate(singles):
            np.testing.assert_allclose(env.step(push[k].ravel())[0], rows[k], atol=1e-6)
        seen = parallel.step(dict(zip(parallel.possible_agents, push[0], strict=True)))[0]
        np.testing.assert_allclose(list(seen.values()), wanted[0], atol=1e-6)


def test_sensors_change_nothing_that_they_are_not_on():
    plain = Transport(num_worlds=3, observe=("goal", "twist"), scene=OPEN_ROOM)
    noisy = Transport(num_worlds=3, observe=("goal", NOISY), scene=OPEN_ROOM)
    late = Transport(num_worlds=3, observe=("goal", Sensor("twist", delay=1)), scene=OPEN_ROOM)
    for core in (plain, noisy, late):
        core.reset(seed=0)
    for push in actions(0, 5, 3, 2, 3):
        seen = [core.step(push)[0] for core in (plain, noisy, late)]
        for other in seen[1:]:
            np.testing.assert_array_equal(other[..., :4], seen[0][..., :4])
    for core in (plain, late):  # a delay draws nothing
        core.reset()
    np.testing.assert_array_equal(
        plain.transition.next_state.goal,  # pyright: ignore[reportOptionalMemberAccess]
        late.transition.next_state.goal,  # pyright: ignore[reportOptionalMemberAccess]
    )
    assert not plain.conditions.key.any()
    assert not late.conditions.key.any()
    assert len(set(noisy.conditions.key.tolist())) == 3


def test_readings_stay_within_the_bounds_of_their_block_and_finite():
    wild = Sensor("obstacles", noise=1e3), Sensor("load_share", bias=1e3), Sensor("goal", 1e12)
    core = Transport(num_worlds=16, observe=wild)
    core.reset(seed=0)
    obs, *_ = core.step(np.ones((16, 2, 3)))
    assert np.isfinite(obs).all()
    assert (obs >= core.observation.low).all()
    assert (obs <= core.observation.high).all()
    seen = obs[..., core.observation.blocks["obstacles"]]
    assert set(np.unique(seen[..., :12])) <= {0.0, 3.0}


def test_what_an_agent_is_not_told_reads_zero_through_a_sensor_too():
    observe = (Sensor("goal", noise=0.5, bias=0.5, delay=1), "known")
    core = Transport(num_worlds=3, observe=observe, informed=(1,), scene=OPEN_ROOM)
    seen = [core.reset(seed=0)[0], core.step(np.ones((3, 2, 3)))[0]]
    for obs in seen:
        assert not obs[:, 0].any()
        assert obs[:, 1].all()
        np.testing.assert_array_equal(obs[:, 1, 4:], 1.0)  # flags are not noised


def test_numbers_about_one_other_agent_stand_for_each():
    sensor = Sensor("partner_wrench", noise=(0.0, 0.0, 1.0))
    drawn = errors(sensor, body=TRIO)
    assert not drawn[..., [0, 1, 3, 4]].any()
    assert drawn[..., [2, 5]].all()
    whole = errors(Sensor("partner_wrench", noise=(0, 0, 1.0, 0, 0, 1.0)), body=TRIO)
    np.testing.assert_array_equal(whole, drawn)
    assert (drawn[..., 2] != drawn[..., 5]).all()


def test_a_block_of_ones_own_and_one_without_features_may_be_sensed():
    mine = Block(
        name="mine", size=2, describe="ones", read=lambda t: np.ones((*t.applied.shape[:2], 2))
    )
    assert (run((Sensor(mine, noise=0.1),)) != 1).all()
    lonely = coopenv.Body(grips=((0.0, 0.0),))
    assert run(("twist", Sensor("partner_wrench", noise=1.0, delay=1)), body=lonely).shape[-1] == 3


def test_a_sensor_without_errors_reads_the_truth():
    np.testing.assert_array_equal(run((Sensor("twist"), "goal")), run(("twist", "goal")))
    default = tuple(Sensor(name) for name in coopenv.observation.DEFAULT_BLOCKS)  # pyright: ignore
    np.testing.assert_array_equal(run(default), run(coopenv.observation.DEFAULT_BLOCKS))  # pyright: ignore


def test_a_logged_step_says_what_the_sensors_were_drawn_with():
    core = Transport(num_worlds=2, observe=(NOISY,))
    core.reset(seed=0)
    kept = pickle.loads(pickle.dumps(core.transition))
    np.testing.assert_array_equal(kept.conditions.key, core.conditions.key)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"noise": -1.0}, "sensor.noise must be from 0 to"),
        ({"bias": (0.1, -0.1, 0.1)}, "sensor.bias must be from 0 to"),
        ({"noise": np.nan}, "sensor.noise must be finite"),
        ({"noise": ()}, "sensor.noise must be from 0 to 1e.12, one number"),
        ({"noise": "some"}, "sensor.noise must be an array of numbers"),
        ({"delay": -1}, "sensor.delay must be a whole number of at least 0"),
        ({"delay": 0.5}, "sensor.delay must be a whole number"),
        ({"block": NOISY}, "sensor.block must be a block or its name"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused_by_the_name_of_its_parameter(values, said):
    with pytest.raises(InvalidInput, match=said):
        Sensor(**{"block": "twist", **values})


@pytest.mark.parametrize(
    ("observe", "said"),
    [
        ((Sensor("twst"),), "observe must be .*did you mean 'twist'"),
        ((Sensor("twist", noise=(0.1, 0.2)),), "sensor.noise must be one number or one for each of "
         "the 3 features of 'twist'"),
        ((Sensor("partner_wrench", bias=(0.1, 0.2)),), "sensor.bias must be one number or one for"),
        (("twist", NOISY), r"observe must name each block once, got \['twist'\] twice"),
        ((Sensor(Block(name="x", size=2, describe="")),), "read must be given"),
    ],
)  # fmt: skip
def test_a_sensor_that_fits_no_block_is_refused_when_the_environment_is_made(observe, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        Transport(observe=observe)


def test_a_sensor_is_a_value():
    assert Sensor("twist", noise=[0.1, 0.2, 0.3]) == Sensor("twist", noise=(0.1, 0.2, 0.3))
    assert Sensor(ranges(num_rays=3)) == Sensor(ranges(num_rays=3)) != Sensor(BLOCKS["obstacles"])
    assert dataclasses.replace(NOISY, delay=0).noise == 0.02
