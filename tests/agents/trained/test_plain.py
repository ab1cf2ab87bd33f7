"""Policies in plain numbers: they act without torch, and their files run nothing."""

import io
import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coopenv import Body, Transport, TransportConfig
from coopenv.agents import load
from coopenv.agents.environment import find_config
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.trained import PlainPolicy, read_notes
from coopenv.agents.trained.network import SMALL, Layer
from coopenv.agents.trained.normalization import Normalization
from coopenv.agents.trained.record import RECORD, check_trained_on
from coopenv.errors import InvalidInput
from tests.agents.trained.cases import CONFIG, plain


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("plain") / "policy.npz"
    PlainPolicy(plain()).save(path)
    return path


def changed(source: Path, target: Path, members: dict[str, bytes]) -> Path:
    """A copy in which some members hold something else."""
    with zipfile.ZipFile(source) as archive:
        whole = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in {**whole, **members}.items():
            archive.writestr(name, data)
    return target


def test_it_acts_without_torch_and_its_library(file):
    code = f"""
import sys
sys.modules["torch"] = sys.modules["stable_baselines3"] = None
from coopenv.agents import load
from coopenv.agents.evaluate import evaluate
from tests.agents.trained.cases import CONFIG
print(evaluate(load({str(file)!r}), CONFIG, episodes=2).episodes)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "2", done.stderr


def test_what_was_saved_acts_alike_and_is_saved_as_the_same_bytes(file, tmp_path):
    core = Transport(num_worlds=3, config=CONFIG)
    obs, _ = core.reset(seed=1)
    again = load(file)
    assert isinstance(again, PlainPolicy)
    assert core.transition is not None
    np.testing.assert_array_equal(
        again(obs, core.transition), PlainPolicy(plain())(obs, core.transition)
    )
    again.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == file.read_bytes()


@pytest.mark.parametrize("rows", [1, 63, 64, 65, 1000])
def test_layers_of_many_rows_are_what_each_row_alone_comes_to(rows):
    rng = np.random.default_rng(0)
    weight, x = (rng.normal(size=(n, 64)).astype(np.float32) for n in (64, rows))
    layer = Layer(weight=weight, bias=weight[:, 0], activation="tanh")
    assert SMALL // weight.size == 64  # rows that are multiplied at once
    wanted = np.tanh(np.einsum("ri,ui->ru", x, weight) + weight[:, 0])
    np.testing.assert_allclose(layer(x), wanted, atol=1e-5)


@pytest.mark.parametrize(("units", "products"), [(64, 8), (512, 1), (1024, 1)])
def test_a_layer_is_multiplied_in_blocks_where_that_pays_and_at_once_where_it_is_large(
    units, products, monkeypatch
):
    seen = []
    multiply = np.matmul
    monkeypatch.setattr(np, "matmul", lambda *a, **b: seen.append(1) or multiply(*a, **b))
    weight = np.ones((units, 512 if units > 64 else 64), dtype=np.float32)
    layer = Layer(weight=weight, bias=weight[:, 0], activation="identity")
    assert layer(np.ones((512, weight.shape[1]), dtype=np.float32)).shape == (512, units)
    assert len(seen) == products


def test_a_file_is_packed_and_says_no_time_of_day(tmp_path):
    file = tmp_path / "policy.npz"
    PlainPolicy(plain()).save(file)
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
    assert {member.compress_type for member in members} == {zipfile.ZIP_DEFLATED}
    assert {member.date_time for member in members} == {(1980, 1, 1, 0, 0, 0)}
    assert file.stat().st_size < sum(member.file_size for member in members)


def test_sampled_actions_repeat_and_do_not_depend_on_the_worlds_beside(file):
    policy = load(file, deterministic=False, seed=3)
    few, many = (
        run_episodes(policy, CONFIG, episodes=6, num_worlds=count).reward for count in (2, 6)
    )
    np.testing.assert_allclose(few, many, atol=1e-5)
    mean = run_episodes(load(file), CONFIG, episodes=6).reward
    assert np.abs(few - mean).max() > 1e-3


def test_a_pickle_in_the_place_of_weights_is_not_run(file, tmp_path):
    marker = tmp_path / "marker"

    class Touch:
        def __reduce__(self):
            return Path.touch, (marker,)

    poisoned = io.BytesIO()
    np.save(poisoned, np.array([Touch()], dtype=object), allow_pickle=True)
    path = changed(file, tmp_path / "bad.npz", {"weights/log_std.npy": poisoned.getvalue()})
    with pytest.raises(InvalidInput, match="policy must be a whole file as coopenv export"):
        load(path)
    assert not marker.exists()


def test_an_array_that_says_to_be_larger_than_it_is_takes_no_memory(file, tmp_path):
    data = io.BytesIO()
    header = {"descr": "<f4", "fortran_order": False, "shape": (10**12,)}
    np.lib.format.write_array_header_1_0(data, header)
    path = changed(file, tmp_path / "big.npz", {"weights/log_std.npy": data.getvalue() + b"0000"})
    with pytest.raises(InvalidInput, match="something else than its numbers"):
        load(path)


@pytest.mark.parametrize(
    ("name", "value", "match"),
    [
        ("format", 2, "policy must be of format 1, got 2"),
        ("network", {}, "its network is described by"),
        ("spaces", {}, "KeyError"),
        ("algorithm", None, None),
    ],
)
def test_a_file_that_says_something_else_is_refused(file, tmp_path, name, value, match):
    with zipfile.ZipFile(file) as archive:
        said = json.loads(archive.read("coopenv_policy.json"))
    text = json.dumps({**said, name: value}).encode()
    path = changed(file, tmp_path / "other.npz", {"coopenv_policy.json": text})
    if match is None:  # nothing depends on it while it acts
        assert load(path)
        return
    with pytest.raises(InvalidInput, match=match):
        load(path)


def test_weights_that_are_not_finite_or_do_not_fit_are_refused(file, tmp_path):
    for array, match in (
        (np.full(6, np.nan, dtype=np.float32), "not finite"),
        (np.zeros(5, dtype=np.float32), "spread is of other actions"),
        (np.zeros(6), "is float64"),
    ):
        data = io.BytesIO()
        np.save(data, array)
        path = changed(file, tmp_path / "odd.npz", {"weights/log_std.npy": data.getvalue()})
        with pytest.raises(InvalidInput, match=match):
            load(path)


def test_a_file_that_is_cut_short_missing_or_no_policy_is_one_sentence(file, tmp_path):
    short = tmp_path / "short.npz"
    short.write_bytes(file.read_bytes()[:1000])
    recording = tmp_path / "recording.npz"
    np.savez(recording, time=np.arange(3.0))
    for path, match in (
        (short, "cut short"),
        (tmp_path / "none.npz", "which is not there"),
        (recording, "an archive without data and policy.pth"),
    ):
        with pytest.raises(InvalidInput, match=match):
            load(path)


def test_it_is_written_under_its_suffix_alone(tmp_path):
    with pytest.raises(InvalidInput, match=r"path must end in \.npz, got"):
        PlainPolicy(plain()).save(tmp_path / "policy.zip")


def refusal(config: TransportConfig) -> str:
    with pytest.raises(InvalidInput) as refused:
        PlainPolicy(plain()).check_environment(Transport(num_worlds=1, config=config))
    return str(refused.value)


def test_an_environment_in_which_its_numbers_mean_something_else_is_refused():
    other = replace(CONFIG, observe=("twist", "goal", *CONFIG.observe[2:]))
    assert "obs must be made of the blocks" in refusal(other)
    assert "obs and action must have the sizes" in refusal(replace(CONFIG, observe=("goal",)))
    assert "obs and action must have the sizes" in refusal(replace(CONFIG, action="force"))
    assert "action must be 'wrench'" in refusal(replace(CONFIG, action="motion"))
    assert "force_limit must be the" in refusal(replace(CONFIG, force_limit=1.0))
    assert "must be the 10 N that" in refusal(replace(CONFIG, force_limit=(10.0, 5.0)))
    walker = find_config("coopenv/WalkerTurn-v0", {})  # whose blocks are the same
    assert "task must be the TransportTask" in refusal(walker)


def test_limits_of_each_agent_are_compared_with_those_of_each():
    limits = replace(CONFIG, force_limit=(10.0, 10.0))  # as one for all of them
    PlainPolicy(plain()).check_environment(Transport(num_worlds=1, config=limits))
    for recorded, now in (([30.0, 5.0], 10.0), ([30.0, 5.0], (5.0, 30.0))):
        with pytest.raises(InvalidInput, match="force_limit must be the 30 and 5 N that"):
            check_trained_on(
                {RECORD: {"environment": {"force_limit": recorded}}},
                Transport(num_worlds=1, config=replace(CONFIG, force_limit=now)),
                2,
            )


def test_an_environment_with_another_body_is_not(file):
    heavy = replace(CONFIG, body=Body(mass=9.0))
    load(file).check_environment(Transport(num_worlds=1, config=heavy))  # type: ignore[attr-defined]


def test_notes_go_along(file):
    assert read_notes(file)["provenance"]["training"]["control"] == "joint"
    assert PlainPolicy.load(file).notes == read_notes(file)


def test_statistics_that_would_unpack_to_more_than_any_policy_has_are_refused_unread():
    packed = io.BytesIO()
    mean, variance = np.zeros(10**6), np.ones(10**6)
    np.savez_compressed(packed, mean=mean, variance=variance, epsilon=1e-8, clip=10.0)
    assert len(packed.getvalue()) < 10**5
    with pytest.raises(ValueError, match="would unpack to 16,000"):
        Normalization.from_bytes(packed.getvalue())
