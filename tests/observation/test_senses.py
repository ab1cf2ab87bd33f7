"""What a hand feels: wrench, stretch, motion and specific force at its grip."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import BLOCKS, Body, Hands, Ranges, Scene, Sensor, Transport, TransportConfig, rewards
from coopenv.errors import InvalidInput
from coopenv.observation import FELT, SENSING
from coopenv.transition import Transition
from tests.helpers import BLIND_TO_HANDS, NEVER, OPEN_ROOM, QUINTET, TRIO, actions
from tests.test_partner import Steady

WITHOUT_HANDS = ("wrench", "force", "discrete")


def started(num_worlds: int = 1, **keywords) -> Transport:
    keywords = {"scene": OPEN_ROOM, "task": NEVER, **keywords}
    core = Transport(num_worlds=num_worlds, **keywords)
    core.reset(seed=0)
    return core


def played(core: Transport, plan) -> np.ndarray:
    """What is seen after the last action of a plan, float64."""
    steps = [core.step(push)[0] for push in plan]
    return steps[-1].astype(float)


def last(core: Transport) -> Transition:
    assert core.transition is not None
    return core.transition


def grips_in_world(core: Transport, pose) -> np.ndarray:
    """``(world, agent, 2)`` [m]."""
    x, y = np.moveaxis(core.team.grips, -1, 0)
    c, s = np.cos(pose[:, 2])[:, None], np.sin(pose[:, 2])[:, None]
    return pose[:, None, :2] + np.stack([c * x - s * y, s * x + c * y], axis=-1)


def along_own_axes(core: Transport, vectors, angle) -> np.ndarray:
    """World vectors ``(world, agent, 2)`` as agents see them; ``angle`` ``(world,)`` of bodies."""
    x, y = np.moveaxis(core.team.grips, -1, 0)
    own = np.where((x == 0) & (y == 0), 0.0, np.arctan2(-y, -x))  # at the centre: the object's x
    at = angle[:, None] + own
    c, s = np.cos(at), np.sin(at)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


@pytest.mark.parametrize("body", [Body(), TRIO, QUINTET, Body.plate(4)])
def test_own_motion_is_the_rate_at_which_the_grip_moves_along_the_agents_axes(body):
    core = started(3, body=body, observe=("own_motion",), dt=1e-3)
    seen = played(core, actions(0, 1, 3, core.num_agents, 3).repeat(150, axis=0))
    before, after = last(core).state, last(core).next_state
    way = grips_in_world(core, after.pose) - grips_in_world(core, before.pose)
    wanted = along_own_axes(core, way / core.dt, after.pose[:, 2])
    assert np.abs(wanted).max() > 0.05
    np.testing.assert_allclose(seen[..., :2], wanted, atol=1e-2)
    np.testing.assert_allclose(seen[..., 2], after.twist[:, 2, None].repeat(core.num_agents, 1))


def test_grips_of_a_rigid_body_neither_near_nor_part():
    core = started(5, observe=("own_motion",))
    for push in actions(1, 20, 5, 2, 3):
        seen = core.step(push)[0]
        np.testing.assert_allclose(seen[:, 0, 0], -seen[:, 1, 0], atol=1e-6)  # x is inwards
        spin, span = seen[:, 0, 2], 1.8  # [m] between the grips
        np.testing.assert_allclose(-seen[:, 0, 1] - seen[:, 1, 1], spin * span, atol=1e-6)


def test_an_inertial_unit_reads_the_change_of_its_grips_velocity():
    core = started(4, body=TRIO, observe=("acceleration",), dt=0.02)
    velocity = np.zeros((4, 3, 2))
    for push in actions(2, 30, 4, 3, 3):
        seen = core.step(push)[0]
        pose, (x, y) = last(core).next_state.pose, np.moveaxis(core.team.grips, -1, 0)
        twist = last(core).next_state.twist[:, None]
        c, s = np.cos(pose[:, 2, None]), np.sin(pose[:, 2, None])
        lever = np.stack([-(s * x + c * y), c * x - s * y], axis=-1)
        after = twist[..., :2] + twist[..., 2:] * lever
        turn = last(core).next_state.pose[:, 2] - last(core).state.pose[:, 2]
        middle = pose[:, 2] - (np.pi - (np.pi - turn) % (2 * np.pi)) / 2
        wanted = along_own_axes(core, (after - velocity) / core.dt, middle)
        assert np.abs(wanted).max() > 0.1
        np.testing.assert_allclose(seen, wanted, rtol=1e-5, atol=1e-5)
        velocity = after


@pytest.mark.parametrize("spin", [0.5, 9.0, 70.0])
def test_who_goes_round_is_drawn_towards_the_centre(spin):
    """ω² r, but for the chord that a step makes of the circle; 70 rad/s is more than half round."""
    body = Body(linear_drag=0.0, angular_drag=0.0, grips=((-0.9, 0.0), (0.5, 0.3)))
    core = started(body=body, observe=("acceleration",))
    state = core.get_state()
    state.parts["world"]["twist"][:] = (0.3, -0.2, spin)
    state.parts["transition"]["next_state"]["twist"][:] = (0.3, -0.2, spin)
    core.set_state(state)
    seen = core.step(np.zeros((1, 2, 3)))[0][0]
    half = spin * core.dt / 2
    inwards = spin**2 * np.linalg.norm(body.grips, axis=1) * np.sin(half) / half
    np.testing.assert_allclose(seen, np.stack([inwards, [0, 0]], axis=-1), rtol=1e-5, atol=1e-3)


def test_a_unit_that_falls_reads_nothing_and_one_that_is_held_reads_what_bears_it():
    upright = Scene(size=(80.0, 80.0), gravity=(0.6, -9.81))
    core = started(scene=upright, body=Body(linear_drag=0.0), observe=("acceleration",))
    seen, _ = core.reset(seed=0, pose=(0.0, 0.0, 0.0))
    held = [[-0.6, 9.81], [0.6, -9.81]]  # agent 1 looks back along the beam
    np.testing.assert_allclose(seen[0], held, rtol=1e-6)
    for _ in range(3):
        seen = core.step(np.zeros((1, 2, 3)))[0]
        np.testing.assert_allclose(seen[0], 0.0, atol=1e-4)
    resting = started(scene=Scene(size=(8.0, 6.0), gravity=(0.0, -9.81)), observe=("acceleration",))
    resting.reset(seed=0, pose=(0.0, -2.9, 0.0))
    seen = played(resting, np.zeros((60, 1, 2, 3)))
    np.testing.assert_allclose(seen[0], [[0.0, 9.81], [0.0, -9.81]], atol=1e-3)


@pytest.mark.parametrize("action", WITHOUT_HANDS)
def test_a_sensor_at_the_grip_reads_a_wrench_that_is_held_as_it_is_given(action):
    core = started(3, action=action, body=TRIO, observe=("own_wrench", "felt_wrench"))
    rng = np.random.default_rng(0)
    plan = rng.uniform(-1, 1, (5, *core.action_shape))
    plan = rng.integers(0, 7, plan.shape) if action == "discrete" else plan
    for push in plan:
        seen = core.step(push)[0]
        np.testing.assert_array_equal(seen[..., :3], seen[..., 3:])
        assert seen.any()


def test_hands_held_apart_feel_half_of_stiffness_times_distance_inwards():
    core = started(action="motion", sensing="own", hands=Hands(stiffness=150.0, speed=0.1))
    outwards = np.array([[(-1.0, 0.0, 0.2), (-1.0, 0.0, 0.2)]])
    (seen,) = played(core, [outwards] * 8 + [0 * outwards] * 112)
    blocks = core.observation.blocks
    stretch, felt = seen[:, blocks["stretch"]], seen[:, blocks["felt_wrench"]]
    np.testing.assert_allclose(stretch[:, 0], -8 * 0.05 * 0.1, atol=1e-4)  # outwards: −x
    np.testing.assert_allclose(felt, stretch * [150.0, 150.0, 20.0], atol=1e-4)
    np.testing.assert_allclose(seen[:, blocks["own_motion"]], 0.0, atol=1e-5)


@pytest.mark.parametrize("action", ["motion", "impedance"])
def test_what_hands_feel_is_that_of_the_end_of_the_step_along_their_own_axes(action):
    core = started(4, action=action, body=TRIO, observe=("felt_wrench", "stretch", "own_wrench"))
    seen = played(core, actions(3, 6, 4, 3, core.action_size))
    transition = last(core)
    for at, vectors in ((0, transition.felt_wrench), (3, transition.stretch)):
        assert vectors is not None
        wanted = along_own_axes(core, vectors[..., :2], np.zeros(4))
        np.testing.assert_allclose(seen[..., at : at + 2], wanted, rtol=1e-5, atol=1e-6)
        np.testing.assert_allclose(seen[..., at + 2], vectors[..., 2], rtol=1e-6)
    assert (np.abs(seen[..., :3] - seen[..., 6:]) > 1e-3).any()  # the other is the step's mean


def test_own_senses_hold_what_hands_feel_and_are_as_before_without_them():
    for word, blocks in SENSING.items():
        for action in WITHOUT_HANDS:
            assert TransportConfig(sensing=word, action=action).observe == blocks
        for action in ("motion", "impedance"):
            felt = TransportConfig(sensing=word, action=action).observe
            assert [name for name in felt if name not in FELT] == list(blocks)
            assert set(felt) == {*blocks, *FELT}
    assert FELT == ("felt_wrench", "stretch", "own_motion", "acceleration")
    own = TransportConfig(sensing="own", action="motion")
    shared = TransportConfig(sensing="shared", action="motion")
    assert own.observe == shared.observe[: len(own.observe)]
    again = replace(own, action="wrench", hands=None, sensing="own")
    assert again.observe == SENSING["own"]


@pytest.mark.parametrize(
    ("keywords", "named"),
    [
        ({"observe": ("goal", "stretch")}, "observe 'stretch'"),
        ({"observe": (Sensor("stored_energy", noise=0.1),)}, "observe 'stored_energy'"),
        ({"reward": {"soft": rewards.StoredEnergy()}}, "reward 'soft'"),
        ({"cost": "stored_energy"}, "cost 'stored_energy'"),
    ],
)
@pytest.mark.parametrize("action", WITHOUT_HANDS)
def test_what_tells_of_hands_is_refused_without_them(keywords, named, action):
    said = f"{named} must come with action='motion' or action='impedance'"
    with pytest.raises(InvalidInput, match=said):
        TransportConfig(action=action, **keywords)
    TransportConfig(action="motion", **keywords)


def test_a_step_without_hands_cannot_be_priced_or_read_as_one_with_them():
    transition = last(started())
    with pytest.raises(InvalidInput, match="StoredEnergy must price steps of hands"):
        rewards.StoredEnergy()(transition)
    for name in ("stretch", "stored_energy"):
        read = BLOCKS[name].read
        assert read is not None
        with pytest.raises(InvalidInput, match=f"{name} must be read where hands"):
            read(transition)


def test_who_is_driven_feels_what_it_holds_and_stretches_nothing():
    core = started(2, action="motion", partner=Steady(), observe=("own_wrench", *FELT))
    for push in actions(4, 5, *core.action_shape):
        core.step(push)
    seen = core.observation(last(core))
    blocks = core.observation.blocks
    own, felt = seen[:, 1, blocks["own_wrench"]], seen[:, 1, blocks["felt_wrench"]]
    np.testing.assert_allclose(felt, own, rtol=1e-5)
    assert own.any()
    assert not seen[:, 1, blocks["stretch"]].any()
    assert seen[:, 0, blocks["stretch"]].any()


@pytest.mark.parametrize("name", FELT)
def test_each_sense_takes_noise_a_bias_and_a_delay(name):
    def seen(entry):
        core = started(40, action="motion", observe=(entry,))
        return np.array([core.step(push)[0] for push in actions(5, 6, 40, 2, 3)])

    true = seen(name)
    np.testing.assert_array_equal(seen(Sensor(name, delay=2))[2:], true[:-2])
    biased = seen(Sensor(name, bias=0.5)) - true
    np.testing.assert_allclose(biased, biased[:1].repeat(6, axis=0), atol=1e-4)
    assert np.std(biased[0]) == pytest.approx(0.5, rel=0.25)
    assert np.std(seen(Sensor(name, noise=0.5)) - true) == pytest.approx(0.5, rel=0.1)


@pytest.mark.parametrize(
    "keywords",
    [
        {"action": "wrench"},
        {"action": "motion"},
        {"action": "motion", "hands": Hands(torque_stiffness=0.0, torque_damping=0.0)},
        {"action": "impedance", "hands": Hands(stiffness=(40.0, 90.0), speed=4.0)},
        {
            "action": "impedance",
            "randomise": Ranges(stiffness=(30.0, 150.0), force_limit=(5.0, 30.0)),
        },
        {"action": "motion", "body": Body.walker(), "scene": Scene(size=(8.0, 6.0))},
        {"action": "motion", "scene": Scene(size=(4.0, 3.5), gravity=(0.0, -9.81))},
        {"action": "wrench", "body": Body.beam(mass=0.5), "force_limit": 100.0},
    ],
)
def test_nothing_that_is_felt_is_beyond_its_bound_and_no_bound_is_idle(keywords):
    hands = keywords["action"] != "wrench"
    observe = (*BLIND_TO_HANDS, *(("stretch", "stored_energy") if hands else ()))
    keywords = {"task": NEVER, "observe": observe, "bounded": True, **keywords}
    core = Transport(num_worlds=20, **keywords)
    core.reset(seed=0)
    high = core.observation.high
    assert (core.observation.low < high).all()
    most = np.zeros_like(high)
    for push in actions(6, 60, 20, 2, core.action_size):
        seen, *_, info = core.step(4 * push)
        assert not info["observation_clipped"].any()
        most = np.maximum(most, np.abs(seen).max(axis=(0, 1)))
    if hands and "randomise" not in keywords:  # else the softest and the strongest are bounded
        blocks = core.observation.blocks
        for name in ("felt_wrench", "stretch", "stored_energy"):
            part = (most / high)[blocks[name]]
            assert part[0] > 0.5, name


def test_from_its_own_senses_one_hand_can_tell_what_the_other_gives():
    """M Δv / dt + D v − own, as long as nothing is touched; mass and drag it has to know."""
    body = Body()
    for action in ("wrench", "motion"):
        core = started(8, action=action, observe=("own_wrench", "twist"), dt=0.02)
        before = core.reset(seed=0)[0][:, 0].astype(float)
        worst = largest = 0.0
        for push in actions(7, 60, 8, 2, 3):
            seen = core.step(push)[0][:, 0].astype(float)
            turn = core.dt * (before[:, 5] + seen[:, 5]) / 2
            c, s = np.cos(turn), np.sin(turn)
            old = np.stack(  # the velocity of before along the axes of now
                [c * before[:, 3] + s * before[:, 4], c * before[:, 4] - s * before[:, 3]], axis=-1
            )
            change = (seen[:, 3:5] - old) / core.dt
            drag = body.linear_drag * (seen[:, 3:5] + old) / 2
            told = body.mass * change + drag - seen[:, :2]
            given = last(core).applied[:, 1, :2]  # agent 0 looks along the object's x
            worst = max(worst, float(np.abs(told - given).max()))
            largest = max(largest, float(np.abs(given).max()))
            before = seen
        assert worst < 0.05 * largest
