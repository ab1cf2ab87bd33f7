"""Blocks of an agent's place in its team, of one size in any team."""

import numpy as np
import pytest

from coopenv import BLOCKS, Body, Scene, Transport
from tests.helpers import NEVER, OPEN_ROOM, TRIO, actions

OBSERVE = ("others_wrench", "place")
ALONE = Body(grips=((0.4, 0.1),))


def moved(body: Body, *, observe=OBSERVE, pose=None, push=None, **keywords):
    """A core after a step of random actions, and what each agent sees in it."""
    core = Transport(
        num_worlds=1, body=body, observe=observe, scene=OPEN_ROOM, task=NEVER, **keywords
    )
    core.reset(seed=0, **({} if pose is None else {"pose": pose}))
    given = actions(1, 1, 1, core.num_agents, 3)[0] if push is None else push
    seen, *_ = core.step(given)
    return core, {name: seen[0, :, at] for name, at in core.observation.blocks.items()}


@pytest.mark.parametrize("body", [Body(), TRIO, Body.plate(6), ALONE])
def test_the_others_wrench_is_the_sum_of_theirs_about_the_own_grip(body):
    core, seen = moved(body)
    assert core.transition is not None
    applied, grips = core.transition.applied[0], core.team.grips[0]
    for i, (c, s) in enumerate(core.team.frame[0]):
        expected = np.zeros(3)
        for j in range(body.num_agents):
            if j != i:
                force, (x, y) = applied[j, :2], grips[j] - grips[i]
                expected[:2] += c * force[0] + s * force[1], c * force[1] - s * force[0]
                expected[2] += applied[j, 2] + x * force[1] - y * force[0]
        np.testing.assert_allclose(seen["others_wrench"][i], expected, rtol=1e-5, atol=1e-5)


def test_with_own_wrench_it_is_all_that_the_object_gets_about_the_own_grip():
    core, seen = moved(Body.plate(4), observe=("own_wrench", *OBSERVE))
    assert core.transition is not None
    whole = seen["own_wrench"] + seen["others_wrench"]
    total = core.transition.applied[0, :, :2].sum(axis=0)
    np.testing.assert_allclose(np.hypot(*whole[:, :2].T), np.hypot(*total), rtol=1e-5)


def test_an_agent_alone_feels_no_others_and_has_all_of_the_place():
    _, seen = moved(ALONE)
    assert seen["others_wrench"].tolist() == [[0.0, 0.0, 0.0]]
    np.testing.assert_allclose(seen["place"], [[1.0, 0.17**0.5, 0.17**0.5]], rtol=1e-6)


def test_place_is_an_even_share_the_own_lever_and_that_of_the_team():
    body = Body.plate(3, grips=((0.6, 0.0), (0.0, 0.3), (0.0, 0.0)))
    _, seen = moved(body)
    spread = (0.45 / 3) ** 0.5
    np.testing.assert_allclose(seen["place"], [[1 / 3, r, spread] for r in (0.6, 0.3, 0.0)], 1e-6)


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_their_size_is_the_same_in_any_team(count):
    core, _ = moved(Body.plate(count))
    assert core.observation.size == 6
    assert [BLOCKS[name].width(count) for name in OBSERVE] == [3, 3]


def test_agents_that_are_swapped_see_the_same_swapped():
    plate, order = Body.plate(4), [2, 0, 3, 1]
    swapped = Body.plate(4, grips=[plate.grips[i] for i in order])
    push = actions(1, 1, 1, 4, 3)[0]
    _, seen = moved(plate, push=push)
    _, other = moved(swapped, push=push[:, order])
    for name in OBSERVE:
        np.testing.assert_allclose(other[name], seen[name][order], rtol=1e-5, atol=1e-5)


def test_they_turn_with_the_object_and_with_its_grips():
    plate, turn = Body.plate(3), 0.7
    c, s = np.cos(turn), np.sin(turn)
    turned = Body.plate(3, grips=[(c * x - s * y, s * x + c * y) for x, y in plate.grips])
    push = actions(1, 1, 1, 3, 3)[0]
    _, seen = moved(plate, push=push, pose=(0.0, 0.0, 0.0))
    for body, pose in ((plate, (1.0, 2.0, 1.2)), (turned, (0.0, 0.0, 0.0))):
        _, other = moved(body, push=push, pose=pose)
        for name in OBSERVE:
            np.testing.assert_allclose(other[name], seen[name], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_full_force_stays_inside_the_finite_bounds(count):
    push = np.sign(actions(2, 1, 1, count, 3)[0])
    core, seen = moved(Body.plate(count), push=push, bounded=True, torque_limit=2.0)
    assert np.isfinite([core.observation.low, core.observation.high]).all()
    for name, at in core.observation.blocks.items():
        assert (seen[name] >= core.observation.low[at]).all()
        assert (seen[name] <= core.observation.high[at]).all()


def test_worlds_of_several_bodies_have_each_their_own_place():
    bodies = [Body.plate(3), Body.plate(3, radius=1.5)]
    core = Transport(num_worlds=2, body=bodies, observe=("place",), scene=Scene(size=(20.0, 20.0)))
    seen, _ = core.reset(seed=0)
    np.testing.assert_allclose(seen[1, :, 1:], 2 * seen[0, :, 1:], rtol=1e-6)
