"""What each agent sees: every block against its definition, and blocks of one's own."""

import numpy as np
import pytest

from coopenv import BLOCKS, Block, Body, Transport
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import DEFAULT_BLOCKS, SENSING, Observation
from tests.helpers import BLIND_TO_HANDS, OPEN_ROOM, QUINTET, TRIO, actions

ALL = BLIND_TO_HANDS
RANGES = ("obstacles", "partner_obstacles")  # test_ranges.py has what they are
TEAMS = {"pair": Body(), "three": TRIO, "five": QUINTET, "one": Body(grips=((0.4, 0.1),))}


def moved(body=None, *, observe=ALL, steps=7, num_worlds=4, **keywords):
    """A core some random steps into an episode, and what was seen last."""
    core = Transport(
        num_worlds=num_worlds, body=body or Body(), observe=observe, scene=OPEN_ROOM, **keywords
    )
    obs, _ = core.reset(seed=0)
    for action in actions(1, steps, num_worlds, core.num_agents, core.action_size):
        obs, *_ = core.step(action)
    assert core.transition is not None
    return core, core.transition, obs


def seen_along(vector, angle):
    """A vector ``(..., 2)`` in a frame turned by ``angle``."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def own_angles(core):
    """Angle of each agent frame in the object frame ``(world, agent)``: towards the centre."""
    grips = core.team.grips
    at_center = (grips == 0).all(axis=-1)  # there: the object's x
    return np.where(at_center, 0.0, np.arctan2(-grips[..., 1], -grips[..., 0]))


def wrenches_seen(core, wrench):
    """The wrenches ``(world, agent, other, 3)`` of all agents from each agent's frame."""
    count = core.num_agents
    seen = np.empty((*wrench.shape[:2], count, 3))
    for i in range(count):
        order = np.roll(np.arange(count), -i)  # its own first, then the others in turn
        seen[:, i, :, :2] = seen_along(wrench[:, order, :2], own_angles(core)[:, i, None])
        seen[:, i, :, 2] = wrench[:, order, 2]
    return seen


def body_seen(core):
    """The ``body`` block, agent by agent."""
    limits = core.config.limits()
    seen = np.empty((core.num_worlds, core.num_agents, 6 + 4 * core.num_agents))
    for k, body in enumerate(core.bodies):
        seen[k, :, :5] = body.mass, body.inertia, body.linear_drag, body.angular_drag, body.friction
        seen[k, :, 5] = np.ptp(np.array(body.outline)[:, 0])
        for i in range(core.num_agents):
            for j in range(core.num_agents):
                other = (i + j) % core.num_agents
                grip = seen_along(np.array(body.grips[other]), own_angles(core)[k, i])
                seen[k, i, 6 + 4 * j : 10 + 4 * j] = *grip, *limits[other]
    np.testing.assert_allclose(seen[..., 7], 0.0, atol=1e-12)  # an agent's x runs through its grip
    return np.delete(seen, 7, axis=-1)


def near_seen(way, turn):
    """The ``near_goal`` block for a way ``(world, agent, 2)`` and a turn ``(world,)``."""
    turn = np.arctan2(np.sin(turn), np.cos(turn))[:, None].repeat(way.shape[1], axis=1)
    away = np.linalg.norm(way, axis=-1, keepdims=True)
    return np.concatenate([way / (away + 0.1), (turn / (abs(turn) + 0.1))[..., None]], axis=-1)


@pytest.mark.parametrize("team", TEAMS)
def test_every_block_is_what_it_says(team):
    core, transition, obs = moved(TEAMS[team])
    state, count = transition.next_state, core.num_agents
    heading = state.pose[:, None, 2] + own_angles(core)
    turn = state.goal[:, 2] - state.pose[:, 2]
    away = np.broadcast_to((state.goal - state.pose)[:, None, :2], (4, count, 2))
    speed = np.broadcast_to(state.twist[:, None, :2], (4, count, 2))
    both = np.stack([np.cos(turn), np.sin(turn)], axis=-1)[:, None].repeat(count, axis=1)
    spin = state.twist[:, 2, None, None].repeat(count, axis=1)
    applied = wrenches_seen(core, transition.applied)
    internal = wrenches_seen(core, transition.decomposition.internal)
    share = transition.decomposition.load_share
    seen = {name: BLOCKS[name].read(transition) for name in RANGES}  # pyright: ignore
    wanted = {
        "goal": np.concatenate([seen_along(away, heading), both], axis=-1),
        "twist": np.concatenate([seen_along(speed, heading), spin], axis=-1),
        "own_wrench": applied[:, :, 0],
        "partner_wrench": applied[:, :, 1:].reshape(4, count, -1),
        "own_internal": internal[:, :, 0],
        "partner_internal": internal[:, :, 1:].reshape(4, count, -1),
        "load_share": np.stack([share.force, share.torque], axis=-1),
        "relative_cost": transition.decomposition.relative_cost[:, None, None].repeat(count, 1),
        "near_goal": near_seen(seen_along(away, heading), turn),
        "known": np.ones((4, count, 2)),
        "body": body_seen(core),
        "time": np.full((4, count, 1), 1 - 7 / core.horizon),
        **seen,
        "felt_wrench": applied[:, :, 0],
        "energy_share": transition.power.share[..., None],
        "internal_power": transition.power.internal[:, None, None].repeat(count, 1),
    }
    elsewhere = {"own_motion", "acceleration"}  # test_senses.py
    elsewhere |= {"others_wrench", "place"}  # test_team.py
    assert set(wanted) | elsewhere == set(BLIND_TO_HANDS)
    for name, values in wanted.items():
        got = obs[..., core.observation.blocks[name]]
        np.testing.assert_allclose(got, values, rtol=1e-6, atol=1e-6, err_msg=name)


def test_limits_of_each_agent_are_seen_its_own_first_and_then_the_others_in_turn():
    core, transition, obs = moved(
        TRIO,
        observe=("body", "own_wrench"),
        force_limit=(1.0, 2.0, 3.0),
        torque_limit=(4.0, 5.0, 6.0),
    )
    seen = obs[..., core.observation.blocks["body"]]
    np.testing.assert_allclose(seen, body_seen(core), rtol=1e-6, atol=1e-6)
    assert seen[0, 1, 7:].tolist()[:2] == [2.0, 5.0]
    assert seen[0, 1, [11, 12, 15, 16]].tolist() == [3.0, 6.0, 1.0, 4.0]
    own = obs[..., core.observation.blocks["own_wrench"]]
    wanted = transition.action * np.array([[1, 1, 4], [2, 2, 5], [3, 3, 6]])
    np.testing.assert_allclose(own, wanted, rtol=1e-5)


@pytest.mark.parametrize("team", TEAMS)
def test_the_blocks_lie_side_by_side_without_a_gap(team):
    core, _, obs = moved(TEAMS[team], observe=ALL[::-1])
    at = 0
    for name in ALL[::-1]:
        where = core.observation.blocks[name]
        assert where == slice(at, at + BLOCKS[name].width(core.num_agents))
        at = where.stop
    assert obs.shape[-1] == core.observation.size == at
    assert core.observation.low.shape == core.observation.high.shape == (at,)


@pytest.mark.parametrize("team", TEAMS)
def test_a_block_reads_the_same_alone_and_in_any_company(team):
    whole, _, everything = moved(TEAMS[team], observe=DEFAULT_BLOCKS)
    for name in DEFAULT_BLOCKS:
        _, _, alone = moved(TEAMS[team], observe=(name,))
        np.testing.assert_array_equal(alone, everything[..., whole.observation.blocks[name]])


def test_the_default_shows_the_decomposition():
    assert {"own_internal", "partner_internal", "load_share", "relative_cost"} <= set(
        DEFAULT_BLOCKS
    )
    assert Transport().config.observe == DEFAULT_BLOCKS


def test_both_ends_of_a_symmetric_beam_see_the_same_thing():
    # Turned half round, agent 1 stands where agent 0 stood: a shared policy must not notice.
    one, other = Transport(observe=ALL, scene=OPEN_ROOM), Transport(observe=ALL, scene=OPEN_ROOM)
    one.reset(pose=(0.3, 0.2, 0.5), goal=(1.0, -1.0, 1.1))
    other.reset(pose=(0.3, 0.2, 0.5 + np.pi), goal=(1.0, -1.0, 1.1 + np.pi))
    for action in actions(2, 10, 1, 2, 3):
        first, reward, *_ = one.step(action)
        second, mirrored, *_ = other.step(action[:, ::-1])
        np.testing.assert_allclose(first, second[:, ::-1], rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(reward, mirrored[:, ::-1], atol=1e-12)


def test_what_is_not_defined_reads_as_an_even_share():
    core = Transport(body=TRIO, observe=("load_share",))
    obs, info = core.reset(seed=0)
    np.testing.assert_allclose(obs, 1 / 3, rtol=1e-6)
    np.testing.assert_array_equal(info["force_load_share"], 1 / 3)
    assert not info["force_load_share_defined"].any()
    obs, *_, info = core.step(np.zeros((1, 3, 3)))
    np.testing.assert_allclose(obs, 1 / 3, rtol=1e-6)


def test_time_runs_from_one_to_exactly_nothing():
    core = Transport(observe=("time",), horizon=7, dt=0.07)
    seen = [core.reset(seed=0)[0], *(core.step(np.zeros((1, 2, 3)))[0] for _ in range(7))]
    left = np.array(seen)[:, 0, 0, 0]
    np.testing.assert_allclose(left, np.linspace(1, 0, 8), atol=1e-7)
    assert (left[0], left[-1]) == (1.0, 0.0)


def constant(value):
    return lambda transition: np.full((*transition.applied.shape[:2], 2), value)


def test_a_block_of_ones_own_is_seen_beside_the_others():
    mine = Block(name="mine", size=2, describe="a constant", read=constant(5.0), low=0, high=9)
    core, _, obs = moved(observe=("goal", mine, "time"))
    np.testing.assert_array_equal(obs[..., core.observation.blocks["mine"]], 5.0)
    np.testing.assert_array_equal(core.observation.high[core.observation.blocks["mine"]], 9.0)


def test_a_block_of_ones_own_may_take_the_name_of_a_known_one():
    mine = Block(name="load_share", size=2, describe="a constant", read=constant(5.0))
    observe = tuple(mine if name == "load_share" else name for name in DEFAULT_BLOCKS)
    core, _, obs = moved(observe=observe)
    np.testing.assert_array_equal(obs[..., core.observation.blocks["load_share"]], 5.0)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"name": "", "size": 1, "read": constant(1.0)}, "a block must have a name"),
        ({"name": "x", "size": 0, "read": constant(1.0)}, "at least one feature"),
        ({"name": "x", "size": 2}, "read must be given"),
        ({"name": "goal", "size": 9}, "read must be given"),
    ],
)
def test_a_block_that_cannot_be_is_refused(values, said):
    with pytest.raises(InvalidInput, match=said):
        Observation([Block(**values, describe="")], 2)


def test_a_block_that_reads_another_shape_than_it_says_is_refused():
    wrong = Block(name="wrong", size=3, describe="two features", read=constant(1.0))
    with pytest.raises(
        InvalidInput, match=r"block 'wrong' must read an array of shape \(1, 2, 3\)"
    ):
        Transport(observe=(wrong,)).reset(seed=0)


def test_an_unknown_block_lists_the_known_ones():
    with pytest.raises(
        UnknownName,
        match=r"got 'partner'; .*known: acceleration, body, energy_share, felt_wrench, goal",
    ):
        Observation(["partner"], 2)


def test_an_agent_that_is_not_told_the_goal_reads_zeros_beside_a_known_flag_of_zero():
    core, _, obs = moved(informed=(1,))
    blocks = core.observation.blocks
    assert not obs[:, 0, blocks["goal"]].any()
    assert not obs[:, 0, blocks["known"]].any()
    assert obs[:, 1, blocks["goal"]].all()
    assert (obs[:, 1, blocks["known"]] == 1).all()
    _, _, told = moved()
    np.testing.assert_array_equal(obs[:, 1], told[:, 1])


@pytest.mark.parametrize("informed", [(2,), (0, 0), (-1,), 0, "first", (0.5,)])
def test_an_informed_agent_that_does_not_exist_is_refused(informed):
    with pytest.raises(InvalidInput, match="informed must"):
        Transport(informed=informed)


def test_senses_of_ones_own_need_no_partner_and_shared_ones_add_to_them():
    own, shared = SENSING["own"], SENSING["shared"]
    assert own == shared[: len(own)]
    of_the_partners = {name for name in ALL if name.startswith("partner")}
    takes_all_wrenches = {"own_internal", "load_share", "relative_cost"}
    assert set(shared) - set(own) == of_the_partners | takes_all_wrenches
    for name, blocks in SENSING.items():
        core = Transport(sensing=name)
        assert core.config.observe == blocks
        assert core.config.sensing is None


def test_by_its_own_senses_an_agent_cannot_tell_how_the_others_strain():
    push = np.zeros((1, 3, 3))
    push[0, 1:, 2] = (1.0, -1.0)  # the object feels nothing of it
    for sensing, is_told in (("own", False), ("shared", True)):
        core = Transport(sensing=sensing, body=TRIO)
        seen = []
        for strain in (0.0, 1.0):
            core.reset(seed=0)
            seen.append(core.step(strain * push)[0][0, 0])
        assert (seen[0] != seen[1]).any() == is_told


@pytest.mark.parametrize(
    ("bounds", "said"),
    [({"low": (0.0, 0.0, 0.0)}, "low must be one number"), ({"high": (1.0,)}, "high must be one")],
)
def test_bounds_that_are_not_as_many_as_the_features_are_refused(bounds, said):
    wrong = Block(name="wrong", size=2, describe="ones", read=constant(1.0), **bounds)
    with pytest.raises(InvalidInput, match=said):
        Transport(observe=(wrong,))
