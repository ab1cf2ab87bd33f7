"""The state of worlds: kept, put back here or elsewhere, and gone on from: `docs/state.md`."""

import copy
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.state import measure
from coopenv import Body, DoorwayTask, Scene, Sensor, Snapshot, Transport
from coopenv.agents.partners import PARTNERS
from coopenv.envs.registry import find_config
from coopenv.errors import BodyLost, InvalidInput, ResetNeeded
from tests.agents.partners.cases import acting
from tests.helpers import (
    ALONG,
    CLUTTERED,
    EASY_TASKS,
    IDS,
    LEVEL,
    NEVER,
    OPEN_ROOM,
    OPTIONS,
    TRIO,
    actions,
    assert_same,
)
from tests.test_partner import Steady

SENSES = (
    Sensor("goal", noise=0.01, delay=3),
    Sensor("twist", noise=0.02, bias=0.01, delay=1),
    Sensor("obstacles", noise=0.05, bias=0.02),
    "partner_wrench",
)
EVERYTHING: dict[str, Any] = {
    "partner": "population",
    "observe": SENSES,
    "horizon": 17,  # so that episodes end and others begin
}


def made(name: str, num_worlds: int = 6, **keywords: Any) -> Transport:
    ranges = None if "Walker" in name else ALONG
    given = {"randomise": ranges, **EVERYTHING, **keywords}
    return Transport(num_worlds=num_worlds, config=find_config(name, given))


def ride(core: Transport, plan: np.ndarray) -> list[Any]:
    """What every step returned, and where it led; worlds that end begin anew."""
    assert core.transition is not None
    ended = core.transition.terminated | core.transition.truncated
    seen = []
    for action in plan:
        result = core.step(action, restart=ended)
        ended = result[2] | result[3]
        seen.append((*result, core.world.pose, core.world.twist))
    return seen


def plan_of(core: Transport, steps: int, seed: int = 0, size: float = 0.5) -> np.ndarray:
    shape = core.num_worlds, len(core.learners), core.action_size
    return size * actions(seed, steps, *shape)


def goes_on_alike(core: Transport, plan: np.ndarray) -> None:
    """Twice from where it is, the same actions lead to the same bits."""
    state = core.get_state()
    first = ride(core, plan)
    core.set_state(state)
    assert_same(ride(core, plan), first)


def of_worlds(seen: list[Any], worlds: Any) -> list[Any]:
    """The part of what `ride` returned that is of some worlds."""
    return [
        tuple(
            {name: value[worlds] for name, value in part.items()}
            if isinstance(part, dict)
            else part[worlds]
            for part in step
        )
        for step in seen
    ]


def untouched(core: Transport, *rides: list[Any]) -> np.ndarray:
    """Worlds that touched nothing in the last step, nor in any of the rides."""
    touched = np.zeros(core.num_worlds, dtype=np.bool_)
    for info in [core._info, *(step[4] for seen in rides for step in seen)]:
        touched |= (info["contact_impulse"] != 0) | (info["contact_shift"] != 0)
    return np.flatnonzero(~touched)


@pytest.mark.parametrize("name", LEVEL)
def test_from_a_state_the_same_actions_lead_to_the_same_bits(name):
    core = made(name)
    core.reset(seed=4)
    plan = plan_of(core, 125)
    ride(core, plan[:25])
    state = core.get_state()
    first = ride(core, plan[25:])
    core.set_state(state)
    second = ride(core, plan[25:])
    core.set_state(state)
    free = untouched(core, first)
    assert len(free) > 1
    assert sum(step[3].sum() for step in first) > 20  # episodes that began after the state too
    assert_same(of_worlds(first, free), of_worlds(second, free))


@pytest.mark.parametrize("name", ["one agent", "five agents", "forces", "two of three driven"])
def test_teams_of_any_kind_go_on_to_the_same_bits(name):
    keywords = {**OPTIONS[name], "task": NEVER, "scene": OPEN_ROOM}
    core = Transport(num_worlds=3, **keywords)
    core.reset(seed=0)
    plan = plan_of(core, 20)
    ride(core, plan[:5])
    goes_on_alike(core, plan)


@pytest.mark.parametrize("partner", PARTNERS)
def test_every_partner_remembers(partner):
    keywords = {"partner": partner, "scene": OPEN_ROOM, "horizon": 30, **acting(partner)}
    core = made(IDS[0], **keywords)
    core.reset(seed=1)
    plan = plan_of(core, 40)
    ride(core, plan[:13])
    state, twin = core.get_state(), made(IDS[0], **keywords)
    first = ride(core, plan)
    twin.set_state(state)
    assert_same(ride(twin, plan), first)


@pytest.mark.parametrize("view", LEVEL[2:])
def test_the_mean_over_an_episode_and_its_clock_go_on(view):
    config = replace(find_config(view, {}), task=EASY_TASKS[view])
    core = Transport(num_worlds=8, config=config)
    core.reset(seed=2)
    plan = plan_of(core, 30)
    ride(core, plan[:3])
    state = core.get_state()
    first = ride(core, plan[3:])
    assert any(step[2].any() for step in first)
    core.set_state(state)
    free = untouched(core, first)
    assert_same(of_worlds(ride(core, plan[3:]), free), of_worlds(first, free))


def test_a_state_is_a_copy_that_neither_steps_nor_goings_on_change():
    core = made(IDS[0])
    core.reset(seed=0)
    plan = plan_of(core, 12)
    ride(core, plan[:6])
    state = core.get_state()
    kept = pickle.dumps(state.parts)
    for _ in range(2):
        ride(core, plan)
        core.reset()
        obs, info = core.set_state(state)
        obs[:] = 7
        info["internal_wrench"][:] = 7
        assert core.transition is not None
        core.transition.applied[:] = 7
        assert pickle.dumps(state.parts) == kept


def test_putting_a_state_back_returns_what_its_step_returned():
    core = made(IDS[1], horizon=40)
    core.reset(seed=0)
    seen = ride(core, plan_of(core, 20))[-1]
    state = core.get_state()
    ride(core, plan_of(core, 5))
    obs, info = core.set_state(state)
    assert_same((obs, dict(info)), (seen[0], dict(seen[4])))


def test_worlds_that_are_not_named_go_on_as_if_nothing_had_been():
    core, twin = (made(IDS[1], horizon=30) for _ in range(2))
    for one in (core, twin):
        one.reset(seed=0)
        ride(one, plan_of(one, 10, size=1.0))
    state = core.get_state([4, 1])
    assert len(state) == 2
    for one in (core, twin):
        ride(one, plan_of(one, 3, seed=1, size=1.0))
    core.set_state(state, [1, 4])
    others = [0, 2, 3, 5]
    plan = plan_of(core, 20, seed=2, size=1.0)
    mine, theirs = ride(core, plan), ride(twin, plan)
    assert_same(of_worlds(mine, others), of_worlds(theirs, others))
    mask = np.array([True, False, False, False, True, False])
    assert_same(core.reset(mask=mask)[0][others], twin.reset(mask=mask)[0][others])


@pytest.mark.parametrize("view", LEVEL)
def test_a_state_goes_into_any_worlds_of_any_core_to_rounding(view):
    core, other = made(view, 6), made(view, 70)
    core.reset(seed=0)
    other.reset(seed=100)
    plan = plan_of(core, 40)
    ride(core, plan[:10])
    ride(other, plan_of(other, 4))
    state = core.get_state([3, 5, 0])
    places = [66, 0, 31]  # world 3 goes to place 66
    first = ride(core, plan[10:])
    other.set_state(state, places)
    longer = plan_of(other, 30, seed=3)
    longer[:, places] = plan[10:][:, [3, 5, 0]]
    second = ride(other, longer)
    core.set_state(core.get_state())
    free = [j for j, k in enumerate([3, 5, 0]) if not _touched(first, k)]
    assert free
    chosen, there = np.array([3, 5, 0])[free], np.array(places)[free]
    for mine, theirs in zip(of_worlds(first, chosen), of_worlds(second, there), strict=True):
        assert_same(mine[2:4], theirs[2:4])
        np.testing.assert_allclose(mine[5], theirs[5], rtol=0, atol=1e-9)
        np.testing.assert_allclose(mine[0], theirs[0], rtol=0, atol=1e-6)  # float32
        np.testing.assert_allclose(mine[1], theirs[1], rtol=0, atol=1e-8)


def _touched(seen: list[Any], world: int) -> bool:
    return any(step[4]["contact_impulse"][world] != 0 for step in seen)


def test_one_world_branches_into_all():
    core, model = made(IDS[0]), made(IDS[0], 64)
    core.reset(seed=0)
    ride(core, plan_of(core, 10))
    state = core.get_state([2])
    obs, info = model.set_state(state)
    assert (obs == obs[0]).all()
    assert all((value == value[:1]).all() for value in info.values())
    np.testing.assert_array_equal(model.world.pose, np.tile(core.world.pose[2], (64, 1)))
    assert_same(state.take([0, 0]).parts["obs"], obs[:2])
    branches = [each.bit_generator.state for each in model.generators if each is not None]
    assert all(each == branches[0] for each in branches)
    assert len({id(each) for each in model.generators}) == 64  # each goes on by itself


def test_a_body_meets_the_obstacles_of_the_state_and_no_others():
    keywords = {"task": DoorwayTask(gap_position=(-1.0, 1.0)), "horizon": 10**4}
    core = Transport(num_worlds=4, config=find_config(IDS[1], keywords))
    twin = Transport(num_worlds=4, config=core.config)
    core.reset(seed=0)
    state = core.get_state()
    ahead = np.zeros((60, 4, 2, 3))
    ahead[..., 0] = [1.0, -1.0]  # both along the beam's x
    first = ride(core, ahead)
    assert core.world.contact_impulse.any()
    core.reset(seed=50)  # other doors
    assert core.conditions.scenes != twin.conditions.scenes
    core.set_state(state)
    twin.set_state(state)
    assert core.conditions.scenes == twin.conditions.scenes == core.world.scenes
    np.testing.assert_allclose(ride(core, ahead)[-1][5], first[-1][5], rtol=0, atol=0.05)
    np.testing.assert_allclose(ride(twin, ahead)[-1][5], first[-1][5], rtol=0, atol=0.05)


@pytest.mark.parametrize("name", [IDS[1], IDS[3]])
def test_after_a_touch_the_way_differs_by_little(name):
    row = measure(name, num_states=4)
    assert row.exact == row.free > 50
    assert len(row.apart) > 20
    after_one, after_all = row.apart[:, 0], row.apart[:, -1]
    assert after_one.max() < 0.02  # [m], as docs/state.md says
    assert np.median(after_all) < 0.002


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_a_state_can_be_copied_and_pickled(again):
    core = made(IDS[3])
    core.reset(seed=0)
    plan = plan_of(core, 10)
    ride(core, plan[:5])
    state = again(core.get_state())
    first = ride(core, plan)
    twin = Transport(num_worlds=6, config=state.config)
    twin.set_state(state)
    free = untouched(twin, first)
    assert_same(of_worlds(ride(twin, plan), free), of_worlds(first, free))


def test_a_state_brings_back_a_core_whose_step_broke_off():
    core = Transport(num_worlds=2, scene=OPEN_ROOM)
    core.reset(seed=0)
    plan = plan_of(core, 10)
    state = core.get_state()
    first = ride(core, plan)
    core.world.twist = np.full((2, 3), 1e6)
    with pytest.raises(BodyLost):
        core.step(plan[0])
    with pytest.raises(ResetNeeded, match="reset must be called before get_state"):
        core.get_state()
    core.set_state(state)
    assert_same(ride(core, plan), first)


def test_a_generator_of_another_kind_goes_along():
    core, twin = (Transport(scene=OPEN_ROOM, horizon=2) for _ in range(2))
    core.generators[0] = np.random.Generator(np.random.MT19937(3))
    core.reset()
    twin.reset(seed=0)
    twin.set_state(core.get_state())
    assert_same(ride(twin, plan_of(twin, 9)), ride(core, plan_of(core, 9)))


def started(**keywords: Any) -> Transport:
    core = Transport(**keywords)
    core.reset(seed=0)
    return core


def test_a_state_of_another_configuration_is_refused_and_the_difference_named():
    state = started(horizon=10, body=TRIO).get_state()
    with pytest.raises(InvalidInput, match="got one with another body, horizon; make a core by"):
        started().set_state(state)


def test_configurations_that_differ_in_identity_alone_are_equal():
    core = started(reward={"own": Own()})
    state = pickle.loads(pickle.dumps(core.get_state()))
    assert state.config != core.config
    core.set_state(state)
    with pytest.raises(InvalidInput, match="another reward"):
        started(reward={"own": Own(3.0)}).set_state(state)


class Own:
    """A term that compares by identity."""

    def __init__(self, size: float = 2.0):
        self.size = size

    def __call__(self, transition):
        return np.full(transition.applied.shape[:2], self.size)


@pytest.mark.parametrize(
    ("worlds", "message"),
    [
        ([0, 0], "worlds must be different whole numbers from 0 to 2"),
        ([3], "from 0 to 2"),
        (slice(0, 2), r"whole numbers from 0 to 2, at least one, got slice\(0, 2, None\)"),
        ([], "at least one"),
        (np.array([True, False, True]), "of a mask give np.flatnonzero"),
        ([0, 1], "state must be of 1 or 2 worlds, as many as it is put into, got 3"),
    ],
)
def test_worlds_that_do_not_fit_are_refused_and_nothing_changes(worlds, message):
    core = started(num_worlds=3, scene=OPEN_ROOM)
    state, before = core.get_state(), core.transition
    with pytest.raises(InvalidInput, match=message):
        core.set_state(state, worlds)
    assert core.transition is before


def test_what_is_no_state_or_of_another_version_is_refused():
    core = started()
    with pytest.raises(InvalidInput, match="state must be what get_state returned, got a dict"):
        core.set_state({})  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidInput, match="state must be of version"):
        core.set_state(replace(core.get_state(), version=0))
    with pytest.raises(InvalidInput, match="whole numbers from 0 to 0"):
        core.get_state().take([1])


def test_a_core_has_no_state_before_its_first_reset_and_takes_one_for_all_worlds_only():
    core = Transport(num_worlds=2)
    with pytest.raises(ResetNeeded, match="reset must be called before get_state"):
        core.get_state()
    state: Snapshot = started(num_worlds=1).get_state()
    with pytest.raises(InvalidInput, match="worlds must be all 2 before the first reset, got 1"):
        core.set_state(state, [0])
    core.set_state(state)


def test_a_state_does_not_go_into_a_room_with_other_walls():
    scenes = (Scene(size=(8.0, 8.0)), Scene(size=(8.0, 8.0), friction=0.1), CLUTTERED)
    core = started(num_worlds=3, scene=scenes, body=(Body(), Body(), TRIO)[:1] * 3)
    for k in (1, 2):
        with pytest.raises(InvalidInput, match=f"state must be of a room with .* in world {k}"):
            core.set_state(core.get_state([0]), [k])


def test_a_partner_that_cannot_tell_what_it_remembers_says_so():
    core = started(partner=Steady())
    for keep in (Transport.get_state, copy.deepcopy, pickle.dumps):
        with pytest.raises(InvalidInput, match="must have get_state and set_state for the state"):
            keep(core)


def test_a_partner_of_ones_own_remembers_by_two_methods(monkeypatch):
    class Counting:
        def player(self, config, num_worlds, agents):
            return Counter(num_worlds)

    partner = Counting()
    core = started(num_worlds=3, partner=partner, scene=OPEN_ROOM)
    plan = plan_of(core, 8)
    ride(core, plan[:3])
    goes_on_alike(core, plan)
    monkeypatch.setattr(Counter, "get_state", lambda self, worlds: {"count": 3.0})
    with pytest.raises(InvalidInput, match=r"state of the partner\['count'\] must be an array"):
        core.get_state()


class Counter:
    """A player that pushes the harder the longer it has been at it."""

    def __init__(self, num_worlds):
        self.kind, self.count = np.zeros(num_worlds, dtype=np.int64), np.zeros(num_worlds)

    def reset(self, worlds, generators, start):
        self.count[worlds] = 0

    def act(self, transition):
        self.count += 1
        return np.repeat(self.count[:, None, None], 3, axis=2)

    def plan(self, transition):
        return np.full((len(self.kind), 3), np.nan)

    def get_state(self, worlds):
        return {"count": self.count[worlds]}

    def set_state(self, state, worlds):
        self.count[worlds] = state["count"]
