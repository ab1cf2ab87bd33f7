"""The page on extending runs, top to bottom, and says what is true."""

import re
import shlex
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import api_test, parallel_api_test

from coopenv.cli import main

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)


def forget():
    for name in [name for name in gymnasium.registry if name.startswith("mine/")]:
        del gymnasium.registry[name]
    sys.modules.pop("parking", None)


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    """What the page's code defines; its first block is a file beside the others."""
    pytest.importorskip("stable_baselines3")
    folder, scope = tmp_path_factory.mktemp("extending"), {}
    first, *rest = [re.sub(r"(num_(envs|worlds))=\d+", r"\1=16", code) for code in blocks("python")]
    (folder / first.partition("\n")[0].removeprefix("# ")).write_text(first)
    sys.path.insert(0, str(folder))
    try:
        for block in rest:
            exec(compile(block, str(PAGE), "exec"), scope)
        yield scope
    finally:
        sys.path.remove(str(folder))
        forget()


def test_every_block_of_the_page_runs(names):
    assert names["env"].unwrapped.observation_blocks["wall"] == slice(7, 8)
    assert names["team"].possible_agents == [f"agent_{i}" for i in range(4)]
    assert names["venv"].num_envs == 32
    assert names["again"].unwrapped.transport.config.task == names["parking"].Parking()
    assert np.ptp(names["info"]["body"]["mass"]) > 1
    assert names["heavy"].unwrapped.transport.config.body.mass == 12
    assert '"kind": "parking:Parking"' in names["text"]


def test_a_task_of_ones_own_passes_the_checkers_of_every_view(names):
    check_env(gymnasium.make("mine/Parking-v0").unwrapped, skip_render_check=True)
    parallel_api_test(names["parking"].parallel_env(horizon=9), num_cycles=20)
    api_test(names["parking"].env(horizon=9), num_cycles=20)


def test_the_command_line_takes_it(names, capsys):
    (command,) = blocks("sh")
    words = shlex.split(command.replace("PYTHONPATH=. coopenv", ""))
    assert main([*words, "--episodes", "40", "--num-worlds", "40"]) == 0
    table = capsys.readouterr().out
    scripted = next(line for line in table.splitlines() if "scripted" in line)
    assert float(scripted.split()[1]) >= 80
    assert "mine/Parking-v0" in table


def test_ones_own_block_term_and_draw_say_what_they_should(names):
    limited = names["limited"]
    obs, _ = limited.reset(seed=0)
    core = limited.unwrapped.transport
    drawn = core.conditions.plan[:, 0]
    assert (drawn >= 0.3).all()
    assert np.ptp(drawn) > 0.3
    np.testing.assert_allclose(obs.reshape(16, 2, -1)[..., 7], drawn[:, None].repeat(2, 1))
    info = {}
    for _ in range(30):
        *_, info = limited.step(np.tile([1, 0, 0, -1, 0, 0], (16, 1)))  # both push along the beam
    speed = np.hypot(*core.transition.next_state.twist[:, :2].T)
    wanted = -0.5 * np.maximum(speed - drawn, 0)
    np.testing.assert_allclose(info["reward_terms"]["obedience"], wanted)
    assert wanted.any()


def test_the_block_reads_the_distance_to_the_wall(names):
    env = names["env"]
    obs, _ = env.reset(options={"pose": (1.0, 0.5, np.pi / 2), "goal": (2.0, 0.0, 0.0)})
    np.testing.assert_allclose(obs.reshape(2, -1)[:, 7], [2.0, 3.0 - 1.4], rtol=1e-6)
