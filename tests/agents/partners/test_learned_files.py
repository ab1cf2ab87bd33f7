"""The file of a trained policy as a partner: what it is known by, trusted and refused for."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from gymnasium.envs.registration import EnvSpec

from coopenv import DoorwayTask, Transport, TransportConfig
from coopenv.agents import sb3
from coopenv.agents.partners import Impedance, Lagging, LearnedPartner
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.learned.cases import untrained
from tests.agents.partners.cases import OTHER, SEEN
from tests.agents.partners.saved import saved, saved_each, sb3_ppo
from tests.helpers import TRIO

ID = "coopenv/BeamTransport-v0"


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, str]:
    """One of each kind of control."""
    return saved_each(tmp_path_factory.mktemp("policies"))


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
