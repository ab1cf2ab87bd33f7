"""A trained policy as a partner: it acts as it was trained, in every view, or says why not."""

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from gymnasium.envs.registration import EnvSpec

from coopenv import PUSHES, DoorwayTask, Sensor, Transport, TransportConfig, beam_transport_v0
from coopenv.agents import sb3
from coopenv.agents.partners import Impedance, Lagging, LearnedPartner
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.learned.cases import normalized, trained, untrained
from tests.agents.partners.cases import OTHER, SEEN, wrenches
from tests.helpers import NEVER, TRIO, actions

ID = "coopenv/BeamTransport-v0"


def saved(path: Path, config: TransportConfig = SEEN, control: str = "joint") -> str:
    """The file of an untrained policy of PPO, with the record of its environment."""
    venv = sb3.make_vec_env(config, 2, control=control)
    model = untrained(sb3_ppo(), venv)
    model.policy.log_std.data.fill_(-2.0)  # so that no sample is clipped
    sb3.SB3Policy(model, notes=venv.to_notes()).save(path)
    return str(path)


def sb3_ppo() -> Any:
    import stable_baselines3
    import torch

    torch.set_num_threads(1)
    return stable_baselines3.PPO


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, str]:
    """One of each kind of control."""
    folder = tmp_path_factory.mktemp("policies")
    return {c: saved(folder / f"{c}.zip", control=c) for c in ("joint", "shared", "partner")}


def beside(
    partner: Any, policy: Any, seen: tuple[int, ...], config: TransportConfig, *, steps: int = 12
) -> None:
    """Agent 1 of a core with ``partner`` does what ``policy`` does in a twin without one.

    The twin shows what the policy was trained on. World 1 starts anew on its own.
    """
    core = Transport(num_worlds=3, config=replace(OTHER, partner=partner, action=config.action))
    twin = Transport(num_worlds=3, config=config)
    pose, goal = np.zeros((3, 3)), np.tile([1.0, -0.5, 0.4], (3, 1))
    everywhere, alone = np.ones(3, dtype=np.bool_), np.array([False, True, False])
    for k, action in enumerate(actions(0, steps, 3, 1, 3)):
        mask = everywhere if k == 0 else alone if k == steps // 2 else None
        if mask is not None:
            for each in (core, twin):
                each.reset(seed=4, mask=mask, pose=pose, goal=goal)
            policy.reset(mask)
        assert core.transition is not None
        assert twin.transition is not None
        obs = twin.observation(twin.transition)[:, list(seen)]
        given = policy(obs, twin.transition)[:, [seen.index(1)]]
        core.step(action)
        twin.step(np.concatenate([action, given], axis=1))
        np.testing.assert_allclose(core.transition.applied, twin.transition.applied, atol=1e-6)
    assert twin.transition is not None
    assert np.abs(twin.transition.applied[:, 1]).min() > 0


@pytest.mark.parametrize(
    ("control", "seen"), [("joint", (0, 1)), ("shared", (1,)), ("partner", (1,))]
)
def test_a_policy_acts_as_in_its_training_whatever_the_learner_sees(files, control, seen):
    beside(files[control], sb3.SB3Policy.load(files[control]), seen, SEEN)


def test_it_sees_through_its_own_statistics_and_remembers_each_episode(tmp_path):
    model = trained("RecurrentPPO", normalized("shared"))
    policy = sb3.SB3Policy(model)
    policy.save(tmp_path / "it")
    assert policy.normalization is not None
    beside(str(tmp_path / "it"), policy, (1,), replace(TransportConfig(), task=NEVER))
    beside(policy, policy.frozen(), (1,), replace(TransportConfig(), task=NEVER))


def test_samples_are_of_seed_episode_and_step_whatever_runs_beside(files):
    sampled = LearnedPartner(path=files["partner"], deterministic=False)
    config = replace(OTHER, partner=sampled)
    three = wrenches(Transport(num_worlds=3, config=config), seed=5)
    alone = wrenches(Transport(num_worlds=1, config=config), seed=7)
    np.testing.assert_array_equal(three, wrenches(Transport(num_worlds=3, config=config), seed=5))
    np.testing.assert_allclose(three[0, 2], alone[0, 0], atol=1e-6)  # then learners differ
    again = wrenches(Transport(num_worlds=3, config=config), seed=6)
    assert (three != again).all()
    assert len(np.unique(three)) == three.size
    mean = wrenches(
        Transport(num_worlds=3, config=replace(OTHER, partner=files["partner"])), seed=5
    )
    assert np.abs(three - mean).mean() > 0.3
    other = replace(sampled, seed=1)
    assert (
        wrenches(Transport(num_worlds=3, config=replace(OTHER, partner=other)), seed=5) != three
    ).all()


def test_a_world_that_begins_alone_draws_as_if_all_did(files):
    config = replace(OTHER, partner=LearnedPartner(path=files["partner"], deterministic=False))
    cores = [Transport(num_worlds=3, config=config) for _ in range(2)]
    for core, mask in zip(cores, (None, np.array([False, True, False])), strict=True):
        core.reset(seed=1)
        core.step(np.zeros((3, 1, 3)))
        core.reset(seed=9, mask=mask)
        core.step(np.zeros((3, 1, 3)))
    everywhere, alone = (core.transition.applied[:, 1] for core in cores)  # pyright: ignore[reportOptionalMemberAccess]
    np.testing.assert_array_equal(everywhere[1], alone[1])
    assert (everywhere[[0, 2]] != alone[[0, 2]]).all()


def test_its_sensors_err_anew_in_every_episode(tmp_path):
    seen = replace(SEEN, observe=("goal", Sensor("twist", noise=0.5, bias=0.5), "own_wrench"))
    partner = saved(tmp_path / "noisy.zip", seen, "partner")
    pose, goal = np.zeros((2, 3)), np.ones((2, 3))
    core = Transport(num_worlds=2, config=replace(OTHER, partner=partner))
    given = wrenches(core, episodes=2, steps=1, seed=0, pose=pose, goal=goal)
    core.reset(pose=pose, goal=goal)
    core.step(np.zeros((2, 1, 3)))
    assert core.transition is not None
    assert len(np.unique([*given[0, :, 0], *core.transition.applied[:, 1, 0]])) == 4


def test_every_view_has_it(files):
    keywords: dict[str, Any] = {"partner": files["shared"], "horizon": 3}
    views = [
        gymnasium.make(ID, **keywords),
        gymnasium.make_vec(ID, num_envs=2, **keywords),
        beam_transport_v0.parallel_env(**keywords),
        beam_transport_v0.env(**keywords),
        sb3.make_vec_env(ID, 2, control="partner", **keywords),
    ]
    wanted = LearnedPartner(path=files["shared"])
    given = []
    for view in views:
        core = view.unwrapped.transport if hasattr(view, "unwrapped") else view.transport  # pyright: ignore
        assert core.config.partner == wanted
        assert core.learners == (0,)
        core.reset(seed=2)
        core.step(np.zeros((core.num_worlds, 1, 3)))
        given.append(core.transition.applied[0, 1])
        assert not core._info["partner_has_plan"].any()
    assert np.abs(given[0]).min() > 0
    np.testing.assert_allclose(given, [given[0]] * len(given), atol=1e-6)


def test_the_torchrl_view_has_it(files):
    pytest.importorskip("torchrl")
    from coopenv.agents import torchrl

    keywords: dict[str, Any] = {"num_worlds": 2, "partner": files["shared"], "horizon": 3}
    env, core = torchrl.make_env(ID, seed=2, **keywords), Transport(**keywords)
    assert env.group_map == {"agents": ["agent_0"]}
    core.reset(seed=2)
    data = env.reset()
    for _ in range(2):
        data["agents", "action"] = env.full_action_spec.zero()["agents", "action"]
        data = env.step(data)["next"]
        core.step(np.zeros((2, 1, 3)))
        assert env.transport.transition is not None
        assert core.transition is not None
        applied = env.transport.transition.applied
        np.testing.assert_array_equal(applied, core.transition.applied)
        assert np.abs(applied[:, 1]).min() > 0


def test_a_core_and_an_environment_with_it_can_be_pickled(files):
    env: Any = gymnasium.make(ID, partner=files["shared"])
    twin = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(twin.reset(seed=1)[0], env.reset(seed=1)[0])
    for each in (env, twin):
        each.step(np.zeros(3))
    wanted, found = (each.unwrapped.transport.transition.applied for each in (env, twin))
    np.testing.assert_array_equal(found, wanted)


def test_a_path_goes_through_json_and_stands_for_one_file(files, tmp_path):
    file = tmp_path / "policy.zip"
    file.write_bytes(Path(files["joint"]).read_bytes())
    config = TransportConfig(partner=file)  # pyright: ignore[reportArgumentType]
    text = config.to_json()
    assert TransportConfig.from_json(text) == config == TransportConfig(partner=str(file))
    env: Any = gymnasium.make(ID, partner=file)
    again: Any = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    assert again.unwrapped.transport.config == env.unwrapped.transport.config
    file.write_bytes(Path(files["shared"]).read_bytes())
    with pytest.raises(InvalidInput, match=r"partner\.digest must be that of the file"):
        TransportConfig.from_json(text)
    with pytest.raises(InvalidInput, match=r"partner\.digest must be that of the file"):
        Transport(config=config)
    file.unlink()
    with pytest.raises(InvalidInput, match=r"partner must be a policy's file: .* not there"):
        TransportConfig.from_json(text)


def test_only_the_reader_of_a_text_trusts_its_file(files):
    config = TransportConfig(partner=LearnedPartner(path=files["joint"], trust=True))
    text = config.to_json()
    assert "trust" not in text
    assert TransportConfig.from_json(text).partner.trust is False  # pyright: ignore
    assert TransportConfig.from_json(text, trust=("mine",)).partner.trust is False  # pyright: ignore
    assert TransportConfig.from_json(text, trust=True).partner.trust is True  # pyright: ignore
    forged = text.replace('"seed": 0', '"seed": 0, "trust": true')
    assert forged != text
    with pytest.raises(UnknownName, match="field of partner"):
        TransportConfig.from_json(forged, trust=True)


def test_a_file_that_would_run_something_needs_trust(tmp_path):
    venv = sb3.make_vec_env(SEEN, 2, control="shared")
    untrained(sb3_ppo(), venv).save(tmp_path / "bare.zip")
    partner = LearnedPartner(path=str(tmp_path / "bare.zip"))
    with pytest.raises(InvalidInput, match="trust=True"):
        Transport(config=replace(SEEN, partner=partner))
    core = Transport(config=replace(SEEN, partner=replace(partner, trust=True)))
    core.reset(seed=0)
    core.step(np.zeros((1, 1, 3)))
    with pytest.raises(InvalidInput, match="must have learned in a team like this one"):
        Transport(config=replace(OTHER, partner=replace(partner, trust=True)))


@pytest.mark.parametrize(
    ("control", "changed", "message"),
    [
        ("joint", {"action": "force"}, "must have learned in a team like this one"),
        ("joint", {"body": TRIO}, "must have learned in a team like this one"),
        ("partner", {"body": TRIO, "partner_agents": (0, 2)}, r"one agent .*\(control='partner'\)"),
    ],
)
def test_a_policy_of_another_team_is_refused(files, control, changed, message):
    with pytest.raises(InvalidInput, match=rf"{message}.*{control}\.zip"):
        Transport(config=replace(SEEN, partner=files[control], **changed))


def test_a_policy_that_learned_to_move_hands_moves_them_and_gives_no_wrenches(files, tmp_path):
    moving = replace(SEEN, action="motion")
    mover = saved(tmp_path / "mover.zip", moving)
    beside(mover, sb3.SB3Policy.load(mover), (0, 1), moving)
    with pytest.raises(InvalidInput, match=r"must be 'motion' for a policy .* got 'wrench'"):
        Transport(config=replace(OTHER, partner=mover))
    with pytest.raises(InvalidInput, match=r"must be 'wrench' for a policy .* got 'motion'"):
        Transport(config=replace(OTHER, partner=files["joint"], action="motion"))


def test_one_that_every_agent_runs_drives_several(files):
    driven = replace(SEEN, body=TRIO, partner=files["shared"], partner_agents=(0, 2))
    core = Transport(config=driven)
    core.reset(seed=0)
    core.step(np.zeros((1, 1, 3)))
    assert core.transition is not None
    assert core.transition.applied[0, [0, 2]].all()
    assert not core.transition.applied[0, 1].any()


def test_blocks_that_the_task_does_not_have_are_refused(tmp_path):
    doorway = replace(find_config("coopenv/BeamDoorway-v0", {}), observe=("goal", "gap"))
    path = saved(tmp_path / "doorway.zip", doorway, "shared")
    Transport(config=replace(doorway, observe=("goal",), partner=path))
    with pytest.raises(InvalidInput, match=r"cannot be read in this environment: .*'gap'"):
        Transport(config=replace(SEEN, partner=path))
    assert isinstance(doorway.task, DoorwayTask)


def test_agents_of_a_walker_are_not_exchanged(tmp_path):
    walker = replace(find_config("coopenv/WalkerTurn-v0", {}), partner="walking")
    drive = saved(tmp_path / "drive.zip", walker, "partner")
    with pytest.raises(InvalidInput, match=r"partner_agents must be those .*\(1,\)"):
        Transport(config=replace(walker, partner=drive))
    Transport(config=replace(walker, partner=drive, partner_agents=(1,)))
    seen = TransportConfig(observe=walker.observe, sensing=None)
    beam = saved(tmp_path / "beam.zip", replace(seen, partner="impedance"), "partner")
    with pytest.raises(InvalidInput, match=r"body with wheels, got .* coopenv.TransportTask, with"):
        Transport(config=replace(walker, partner=beam, partner_agents=(1,)))
    with pytest.raises(InvalidInput, match=r"body without wheels, got .* coopenv.WalkerTurnTask"):
        Transport(config=replace(seen, partner=drive))


def test_a_policy_that_learns_on_changes_no_partner():
    model = trained("PPO", sb3.make_vec_env(SEEN, 2, control="shared"))
    core = Transport(config=replace(OTHER, partner=sb3.SB3Policy(model)))
    before = wrenches(core, episodes=1, seed=0)
    model.learn(8)
    np.testing.assert_array_equal(wrenches(core, episodes=1, seed=0), before)
    later = Transport(config=replace(OTHER, partner=sb3.SB3Policy(model)))
    assert (wrenches(later, episodes=1, seed=0) != before).any()


@pytest.mark.parametrize("action", ["wrench", "discrete"])
def test_a_policy_that_chooses_pushes_does_here_what_they_stood_for_in_its_training(
    action, tmp_path
):
    learned = replace(SEEN, action="discrete", pushes="compass", bounded=True)
    venv = sb3.make_vec_env(learned, 2, control="shared")
    path = tmp_path / "policy.zip"
    sb3.SB3Policy(untrained(sb3_ppo(), venv), notes=venv.to_notes()).save(path)
    core = Transport(num_worlds=40, config=replace(OTHER, action=action, partner=str(path)))
    core.reset(seed=0)
    assert core.transition is not None
    policy = sb3.SB3Policy.load(path)
    seen = Transport(num_worlds=40, config=learned)
    given = policy(seen.reset(seed=0)[0], core.transition)[:, 1]
    core.step(np.zeros(core.action_shape, dtype=np.float64 if action == "wrench" else np.int64))
    np.testing.assert_array_equal(core.transition.action[:, 1], np.array(PUSHES["compass"])[given])
    with pytest.raises(InvalidInput, match="action must be 'wrench' or 'discrete' beside a"):
        Transport(config=replace(OTHER, action="force", partner=str(path)))


def test_a_policy_that_no_file_can_name_is_refused_there(files):
    policy = sb3.SB3Policy.load(files["joint"])
    for partner, remedy in ((lambda obs, _: obs, "top of a module"), (policy, "save it")):
        with pytest.raises(InvalidInput, match=rf"partner\.policy must be .*{remedy}"):
            Transport(partner=partner).config.to_json()
        env: Any = gymnasium.make(ID, partner=partner)
        with pytest.raises(InvalidInput, match=r"partner must be something that JSON can hold"):
            env.spec.to_json()


def test_numbers_of_a_file_partner_are_checked(files):
    wrongs: list[dict[str, Any]] = [{"seed": -1}, {"deterministic": 1}, {"trust": "yes"}]
    for wrong in wrongs:
        with pytest.raises(InvalidInput, match=rf"partner\.{next(iter(wrong))} must be"):
            LearnedPartner(path=files["joint"], **wrong)
    with pytest.raises(
        InvalidInput, match=r"must be a partner of coopenv\.agents\.partners, got LearnedPartner"
    ):
        Lagging(partner=LearnedPartner(path=files["joint"]))  # pyright: ignore[reportArgumentType]
    assert Lagging(partner=Impedance())
