"""Policies that come with the package: what they are called, and that they do what they say."""

import json
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coopenv import TransportConfig
from coopenv.agents import load, pretrained
from coopenv.agents.evaluate import evaluate, run_episodes
from coopenv.agents.partners import LearnedPartner
from coopenv.agents.policy import RandomPolicy
from coopenv.agents.pretrained.naming import expanded
from coopenv.agents.pretrained.rows import agree, told
from coopenv.agents.provenance import Provenance
from coopenv.agents.trained import PlainPolicy, read_notes
from coopenv.agents.trained.form import read_form
from coopenv.errors import InvalidInput, UnknownName

NAMES = pretrained.names()
MOST = 1_000_000  # [bytes] of all of them
FEW = 100  # episodes


def file(name: str) -> Path:
    return pretrained.file_of(f"pretrained:{name}")


def environment(name: str) -> TransportConfig:
    provenance = Provenance.read(file(name))
    assert provenance is not None
    return provenance.config()


def test_there_are_some_and_they_are_small():
    assert "BeamTransport/joint" in NAMES
    assert sum(file(name).stat().st_size for name in NAMES) < MOST


@pytest.mark.parametrize("name", NAMES)
def test_each_says_how_it_was_made_and_names_no_folder_of_a_machine(name):
    notes = read_notes(file(name))
    task, control = name.split("/")
    words = shlex.split(notes["made"]["command"])
    assert words[:4] == ["coopenv", "train", "--env", f"coopenv/{task}-v0"]
    assert ("--control" in words) == (control != "joint")
    assert len(notes["made"]["revision"]) == 40
    assert notes["provenance"]["training"]["control"] == control
    assert notes["provenance"]["command"] == words
    said = json.dumps({key: notes["provenance"][key] for key in ("training", "command")})
    assert '"/' not in said
    assert "runs/" in said


@pytest.mark.parametrize("name", NAMES)
def test_each_succeeds_as_its_file_says(name):
    seen = evaluate(load(name), environment(name), episodes=FEW)
    row = pretrained.row_of(f"pretrained:{name}")
    assert row is not None
    assert row.episodes == 500
    assert agree(seen, row)
    np.testing.assert_allclose(seen.relative_cost, row.relative_cost, atol=0.05)


def test_rows_of_others_are_told_apart():
    row = pretrained.row_of("pretrained:BeamTransport/joint")
    assert row is not None
    worse = replace(row, success_rate=0.5, success_interval=(0.45, 0.55))
    assert told({"pretrained:BeamTransport/joint": row}) == ["1 of 1 succeed as their files say"]
    first, second = told({"pretrained:BeamTransport/joint": worse, "random": row})
    assert first == "0 of 1 succeed as their files say"
    assert second.startswith("pretrained:BeamTransport/joint: 50.0 % (45.0 to 55.0), its file says")
    assert told({"random": row}) == []


def test_names_are_those_of_ids_too_and_others_are_refused():
    assert expanded("pretrained") == tuple(f"pretrained:{name}" for name in NAMES)
    assert "pretrained:BeamTransport/joint" in expanded("pretrained:BeamTransport")
    assert expanded("pretrained:coopenv/BeamTransport-v0/joint") == (
        "pretrained:BeamTransport/joint",
    )
    assert expanded("scripted") == ("scripted",)
    with pytest.raises(UnknownName, match=r"got .BeamTranspot/joint.; .*BeamTransport"):
        expanded("pretrained:BeamTranspot/joint")
    with pytest.raises(UnknownName, match="single pretrained policy"):
        pretrained.file_of("pretrained")


def test_load_takes_a_task_an_id_a_name_or_a_file():
    wanted = load("BeamTransport", "joint")
    assert isinstance(wanted, PlainPolicy)
    same = (
        load("BeamTransport"),
        load("coopenv/BeamTransport-v0"),
        load("pretrained:BeamTransport/joint"),
        load(file("BeamTransport/joint")),
    )
    for other in same:
        assert isinstance(other, PlainPolicy)
        assert other.notes == wanted.notes
    with pytest.raises(InvalidInput, match="control must be one of joint, shared, got 'team'"):
        load("BeamTransport", "team")
    with pytest.raises(InvalidInput, match="policy must be that of one task, got 'pretrained'"):
        load("pretrained")
    with pytest.raises(InvalidInput, match="control must be left out beside a file"):
        load(file("BeamTransport/joint"), "joint")


def test_one_drives_the_partner_of_an_environment():
    config = TransportConfig(partner="pretrained:BeamTransport/joint")
    assert isinstance(config.partner, LearnedPartner)
    again = TransportConfig.from_json(config.to_json())
    assert again == config
    together, helped = (
        run_episodes(RandomPolicy(each), each, episodes=20).success.mean()
        for each in (TransportConfig(), config)
    )
    assert together < 0.2
    assert helped > 0.8


def test_what_names_several_policies_or_none_is_no_partner():
    for name, match in (("pretrained", "got 'pretrained'"), ("pretrained:No", "got 'No'")):
        with pytest.raises(UnknownName, match=match):
            TransportConfig(partner=name)


def test_a_model_to_learn_on_is_made_of_its_file():
    sb3 = pytest.importorskip("coopenv.agents.sb3")
    path = file("BeamTransport/joint")
    policy = sb3.SB3Policy.load(path)
    state = policy.model.policy.state_dict()
    for name, array in read_form(path).arrays.items():
        np.testing.assert_array_equal(state[name].numpy(), array)
