"""Body and team drawn anew in every episode: what is drawn, for whom, and what it changes."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import Body, Ranges, Scene, Transport, TransportConfig
from coopenv.errors import InvalidInput, UnknownName
from coopenv.physics.body import second_moments
from coopenv.randomisation import Variations
from coopenv.wrench import Settings
from tests.helpers import ALONG, TRIO, WIDE, actions, assert_same

LIMITS = np.array([(10.0, 5.0)] * 3)
SHARES = st.floats(0, 1)


def parameters(core):
    return core.conditions.parameters()


def test_every_parameter_is_drawn_from_its_range_for_every_world_and_episode():
    core = Transport(num_worlds=64, body=TRIO, randomise=WIDE)
    core.reset(seed=0)
    first = parameters(core)
    core.reset()
    for name, value in parameters(core).items():
        if getattr(WIDE, name) is None:
            np.testing.assert_array_equal(value, 0.0, err_msg=name)  # no friction, no gravity
            continue
        assert (value != first[name]).mean() > 0.9, name
        assert len(np.unique(value)) > 0.9 * value.size, name
        if name != "grips":
            low, high = getattr(WIDE, name)
            assert low <= value.min() < value.max() <= high, name
            assert np.ptp(value) > 0.8 * (high - low), name
    stretch = parameters(core)["length"] / TRIO.length
    moved = parameters(core)["grips"] - np.array(TRIO.grips) * [[[1, 1]]]
    moved[..., 0] -= (stretch[:, None] - 1) * np.array(TRIO.grips)[:, 0]
    for axis, (low, high) in enumerate(WIDE.grips or ()):
        assert low - 1e-12 <= moved[..., axis].min() < moved[..., axis].max() <= high + 1e-12


def test_a_logarithmic_range_puts_its_geometric_mean_in_the_middle():
    ranges = Ranges(mass=(1.0, 100.0), friction=(0.1, 0.9), logarithmic=("mass",))
    varied = Variations(ranges, Body(), LIMITS[:2])
    middle, _ = varied([0.5, 0.5])
    assert middle.mass == pytest.approx(10.0)
    assert middle.friction == pytest.approx(0.5)


def test_what_has_no_range_stays_and_draws_nothing():
    core, plain = Transport(num_worlds=3, randomise=Ranges()), Transport(num_worlds=3)
    obs, info = core.reset(seed=2)
    np.testing.assert_array_equal(obs, plain.reset(seed=2)[0])
    assert core.bodies == plain.bodies
    assert "body/mass" in info
    assert "body/mass" not in plain.reset(seed=2)[1]


@given(SHARES, SHARES, SHARES)
@settings(max_examples=50, deadline=None)
def test_a_drawn_body_is_one_that_could_have_been_given(mass, length, across):
    ranges = Ranges(mass=(1, 20), length=(1, 3), grips=((-0.04, 0.04), (-0.04, 0.04)))
    drawn, _ = Variations(ranges, TRIO, LIMITS)([mass, length, *[across] * 6])
    stated = Body(**{name: getattr(drawn, name) for name in Body.__slots__ if name != "inertia"})
    assert drawn.inertia == pytest.approx(stated.inertia, rel=1e-12)
    assert replace(drawn, inertia=stated.inertia) == stated
    assert drawn.length == pytest.approx(1 + 2 * length)


def test_inertia_of_its_own_keeps_its_proportion_to_mass_and_outline():
    body = Body(inertia=1.3)
    (drawn, _), scale = Variations(Ranges(mass=(1, 9)), body, LIMITS[:2])([1.0]), 9.0 / body.mass
    assert drawn.inertia == pytest.approx(1.3 * scale)
    along, across = second_moments(body.outline)
    longer, _ = Variations(Ranges(length=(1, 4)), body, LIMITS[:2])([1.0])
    assert longer.inertia == pytest.approx(1.3 * (4 * along + across) / (along + across))
    given, _ = Variations(Ranges(mass=(1, 9), inertia=(2, 3)), body, LIMITS[:2])([1.0, 0.0])
    assert given.inertia == 2.0


def test_world_k_draws_the_same_however_many_run_beside_it_and_whichever_view():
    keywords = {"randomise": ALONG, "horizon": 5, "observe": ("goal", "twist", "body")}
    many, one = Transport(num_worlds=7, **keywords), Transport(**keywords)
    vector = gymnasium.make_vec("coopenv/BeamTransport-v0", num_envs=7, **keywords)
    obs, _ = many.reset(seed=10)
    np.testing.assert_array_equal(one.reset(seed=14)[0][0], obs[4])
    np.testing.assert_array_equal(vector.reset(seed=10)[0].reshape(obs.shape), obs)
    for action in actions(0, 23, 7, 2, 3):
        if many.transition is not None and many.transition.truncated.any():
            many.reset(mask=many.transition.truncated | many.transition.terminated)
            one.reset()
        many.step(action)
        one.step(action[4:5])
        for name, value in parameters(one).items():
            np.testing.assert_array_equal(value[0], parameters(many)[name][4], err_msg=name)
        tables = [core.world._shards[0]._table for core in (many, one)]
        np.testing.assert_array_equal(tables[0][4], tables[1][0])
        np.testing.assert_allclose(many.world.pose[4], one.world.pose[0], rtol=0, atol=1e-12)


def test_an_episode_in_a_used_world_equals_one_in_a_fresh_core_to_the_bit():
    core, fresh = (Transport(num_worlds=5, randomise=ALONG, reward="balanced") for _ in "ab")
    core.reset(seed=3)
    for action in actions(1, 20, 5, 2, 3):
        core.step(action)
    for k in range(5):  # one after the other, in batches of other sizes than the fresh one's
        mask = np.arange(5) == k
        core.reset(seed=[8 + j if j == k else None for j in range(5)], mask=mask)
    fresh.reset(seed=8)
    for action in actions(2, 40, 5, 2, 3):
        assert_same(core.step(action), fresh.step(action))


def test_heavier_bodies_and_stronger_agents_move_as_the_physics_says():
    ranges = Ranges(mass=(2, 20), length=(0.5, 3.0), force_limit=(5, 20))
    core = Transport(num_worlds=16, randomise=ranges, scene=Scene(size=(40, 40)))
    core.reset(seed=1, pose=(0, 0, 0), goal=(9, 9, 0))
    push = np.zeros((16, 2, 3))
    push[:, 0, 0] = 1.0  # along the beam, towards agent 1
    core.step(push)
    named, dt = parameters(core), core.dt
    rate = named["linear_drag"] / named["mass"]
    speed = named["force_limit"][:, 0] / named["linear_drag"] * (1 - np.exp(-rate * dt))
    np.testing.assert_allclose(core.world.twist[:, 0], speed, rtol=1e-9)


def test_worlds_with_the_longest_bodies_do_not_touch_each_other():
    ranges = Ranges(length=(0.5, 5.7))
    core = Transport(num_worlds=9, randomise=ranges, scene=Scene(size=(6.0, 6.0)))
    origin = core.world._shards[0]._origin
    pitch = np.linalg.norm(origin[1] - origin[0])
    assert pitch >= 2 * (3.0 + 2.0) + 5.7


def test_the_decomposition_uses_the_drawn_grips():
    core = Transport(num_worlds=3, randomise=ALONG)
    core.reset(seed=0)
    core.step(np.ones((3, 2, 3)))
    assert core.transition is not None
    decomposition = core.transition.decomposition
    np.testing.assert_array_equal(decomposition.grips, [body.grips for body in core.bodies])
    assert decomposition.residuals().balance.max() < 1e-9


def test_infos_in_every_view_say_what_was_drawn():
    keywords = {"randomise": ALONG, "horizon": 3}
    core = Transport(**keywords)
    core.reset(seed=5)
    named = parameters(core)
    single = gymnasium.make("coopenv/BeamTransport-v0", **keywords)
    vector = gymnasium.make_vec("coopenv/BeamTransport-v0", num_envs=2, **keywords)
    _, told = single.reset(seed=5)
    _, batch = vector.reset(seed=5)
    for name, value in named.items():
        np.testing.assert_array_equal(told["body"][name], value[0], err_msg=name)
        np.testing.assert_array_equal(batch["body"][name][0], value[0], err_msg=name)
    still = np.zeros((2, 6), dtype=np.float32)
    last = {}
    for _ in range(3):
        *_, last = vector.step(still)
    np.testing.assert_array_equal(last["body"]["mass"][0], named["mass"][0])
    *_, new = vector.step(still)  # resets on its own
    core.reset()
    assert new["body"]["mass"][0] == parameters(core)["mass"][0] != named["mass"][0]


@pytest.mark.parametrize(
    ("ranges", "said"),
    [
        ({"mass": (10, 5)}, r"randomise\.mass must be \(low, high\), got \(10, 5\); swap them"),
        ({"mass": (0, 5)}, r"randomise\.mass must begin above zero"),
        ({"mass": 5}, r"randomise\.mass must be \(low, high\), got 5"),
        ({"inertia": (1, float("inf"))}, r"randomise\.inertia must be finite"),
        ({"friction": (-0.1, 1)}, r"randomise\.friction must not begin below zero"),
        ({"linear_drag": ("a", "b")}, r"randomise\.linear_drag must be an array of numbers"),
        ({"force_limit": (-1, 1)}, r"randomise\.force_limit must begin above zero"),
        ({"length": (3, 1)}, r"randomise\.length must be \(low, high\)"),
        ({"grips": (0, 1)}, r"randomise\.grips must be two ranges, along x and across"),
        ({"grips": ((0.1, 0), (0, 0))}, r"randomise\.grips along x must be \(low, high\)"),
        ({"grips": ((-0.2, 0.2), (0, 0))}, r"randomise\.grips must keep every grip on the body"),
        ({"length": (0.2, 2), "grips": ((-0.05, 0.05), (0, 0))}, r"must keep every grip on the"),
        ({"length": (1, 9)}, r"randomise must leave the task possible: scene\.size"),
        ({"mas": (1, 2)}, r"keyword of randomise must be .*did you mean 'mass'"),
        ({"logarithmic": ("mass",)}, r"logarithmic must name ranges that are given, got 'mass'"),
        ({"mass": (1, 2), "logarithmic": ("inertia",)}, r"randomise\.logarithmic must be one of"),
        ({"friction": (0, 1), "logarithmic": ("friction",)}, r"friction must begin above zero to"),
        ({"mass": (1, 2), "logarithmic": "mass"}, r"logarithmic must be a sequence of names"),
    ],
)
def test_wrong_ranges_are_refused_at_construction_by_name(ranges, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        TransportConfig(randomise=ranges)


def test_grips_that_the_method_cannot_take_are_refused_before_the_first_episode():
    settings = Settings(method="prioritized_torque")
    said = r"randomise must leave grips .* method='prioritized_torque'"
    with pytest.raises(InvalidInput, match=said):
        Transport(randomise=WIDE, decomposition=settings)
    Transport(randomise=WIDE, decomposition=Settings(solver="pair"))


def test_a_grip_off_the_body_may_be_anywhere_off_it():
    handle = Body(grips=((-1.2, 0.0), (1.2, 0.0)))
    core = Transport(body=handle, randomise=Ranges(grips=((-0.1, 0.1), (0.0, 0.0))))
    core.reset(seed=0)
    assert 1.1 <= core.team.grips[0, 1, 0] <= 1.3


def test_a_grip_at_the_centre_of_mass_stays_there():
    ranges = Ranges(grips=((-0.1, 0.1), (-0.1, 0.1)))
    core = Transport(num_worlds=8, body=Body.walker(), randomise=ranges)
    core.reset(seed=0)
    assert not core.team.grips[:, 1].any()
    np.testing.assert_array_equal(core.team.frame[:, 1], [[1.0, 0.0]] * 8)
    assert len(np.unique(core.team.grips[:, 0, 1])) == 8


def test_every_number_of_a_variation_goes_where_it_belongs():
    ranges = Ranges(
        mass=(2, 4), angular_drag=(0, 8), friction=(0.2, 0.4), length=(1, 3),
        grips=((-0.1, 0.1), (-0.02, 0.02)), force_limit=(10, 20), torque_limit=(1, 5),
    )  # fmt: skip
    grips = (0.5, 1.0, 0.0, 0.5, 1.0, 0.0)
    varied = Variations(ranges, TRIO, LIMITS)
    assert varied.count == 4 + 6 + 3 + 3
    body, limits = varied([0.5, 0.25, 1.0, 0.75, *grips, 0.1, 0.2, 0.3, 0.25, 0.5, 1.0])
    assert (body.mass, body.angular_drag, body.friction) == pytest.approx((3.0, 2.0, 0.4))
    assert body.length == pytest.approx(2.5)  # of 2 m: everything along x is 1.25 times as long
    wanted = [(-0.9 * 1.25, 0.02), (0.3 * 1.25 - 0.1, 0.05), (0.9 * 1.25 + 0.1, -0.05 - 0.02)]
    np.testing.assert_allclose(body.grips, wanted)
    np.testing.assert_allclose(limits, [(11, 2), (12, 3), (13, 5)])
    assert (body.linear_drag, body.nonholonomic) == (TRIO.linear_drag, False)
    one, own = Variations(Ranges(torque_limit=(1, 5)), TRIO, LIMITS * [1, 2])([0.0, 0.5, 1.0])
    assert one.grips == TRIO.grips
    np.testing.assert_allclose(own, [(10, 1), (10, 3), (10, 5)])


def test_extremes_are_everything_at_its_lowest_and_at_its_highest():
    low, high = Variations(Ranges(mass=(2, 4), length=(1, 3)), Body(), LIMITS[:2]).extremes()
    assert (low.mass, low.length) == (2.0, 1.0)
    assert (high.mass, high.length) == (4.0, 3.0)


def test_limits_drawn_for_an_agent_are_what_its_action_of_one_stands_for():
    ranges = Ranges(force_limit=(5, 15), torque_limit=(1, 3))
    core = Transport(num_worlds=3, body=TRIO, randomise=ranges, scene=Scene(size=(20, 20)))
    core.reset(seed=0)
    core.step(np.ones((3, 3, 3)))
    assert core.transition is not None
    drawn, applied = parameters(core), core.transition.applied
    np.testing.assert_allclose(
        np.hypot(applied[..., 0], applied[..., 1]), np.sqrt(2) * drawn["force_limit"]
    )
    np.testing.assert_allclose(applied[..., 2], drawn["torque_limit"])
