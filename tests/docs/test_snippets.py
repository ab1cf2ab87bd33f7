"""Every block of code and every command on a page runs by itself, or at least exists."""

import re
import shlex
from dataclasses import replace
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

import pytest

from coopenv.cli import COMMANDS
from coopenv.files import toml
from coopenv.warming import decompositions, environments
from tests.docs.snippets import PAGES, ROOT, Snippet, chains, printed, running, snippets

TEAMS = ROOT / "docs" / "training" / "teams.md"  # its commands train for a minute each
CHAINS = [chain for page in (*PAGES, TEAMS) for chain in chains(page)]
COMMAND_LINES = [  # of blocks; the name before the command sets the environment, as in a shell
    (snippet, line)
    for page in PAGES
    for snippet in snippets(page)
    if snippet.language == "sh"
    for line in snippet.code.splitlines()
    if line.strip() and not line.startswith("#")
]
OURS = {line: snippet for snippet, line in COMMAND_LINES if re.search(r"\bcoopenv \w", line)}
CALL = "from coopenv.cli import main\nfailed = main({words!r})\n"


@pytest.mark.parametrize("chain", CHAINS, ids=lambda chain: chain[0].place)
def test_the_python_blocks_of_a_page_run(chain: list[Snippet], tmp_path: Path):
    pytest.importorskip("stable_baselines3")
    pytest.importorskip("pandas")
    with running(chain, tmp_path) as names:
        if "model" in names:  # of the page that says what training comes to
            assert names["seen"].success_rate > 0.9


@pytest.mark.parametrize(("line", "snippet"), OURS.items(), ids=OURS)
def test_the_command_lines_of_a_page_run(
    line: str, snippet: Snippet, tmp_path: Path, monkeypatch, capsys
):
    pytest.importorskip("tyro")
    works = decompositions.works
    monkeypatch.setattr(environments, "works", lambda: ())  # of `coopenv warmup`: some will do
    monkeypatch.setattr(decompositions, "works", lambda: islice(works(), 5))
    words = shlex.split(line, comments=True)
    while "=" in words[0]:
        words.pop(0)  # PYTHONPATH=., which is set below
    assert words[0] == "coopenv"
    with running([replace(snippet, code=CALL.format(words=words[1:]))], tmp_path) as names:
        assert names["failed"] == 0, capsys.readouterr().err
    out = " ".join(capsys.readouterr().out.split())
    assert out
    for told in printed(snippet, line):
        assert " ".join(told.split()) in out, out


def test_a_block_is_of_a_known_kind():
    for page in PAGES:
        for snippet in snippets(page):
            tree = snippet.page.name == "architecture.md" and not snippet.language
            assert tree or snippet.language in ("python", "sh", "toml", "json"), snippet.place


def test_a_block_without_the_mark_knows_nothing_of_the_one_before(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "```python\na = 1\n```\n<!-- continues -->\n```python\nb = a\n```\n```python\nc = a\n```\n"
    )
    first, second = chains(page)
    with running(first, tmp_path) as names:
        assert names["b"] == 1
    with pytest.raises(NameError) as caught, running(second, tmp_path):
        pass
    assert caught.traceback[-1].lineno == 8  # counted from 0


def test_every_command_that_a_page_names_exists():
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
    extras = toml.loads((ROOT / "pyproject.toml").read_text())["project"]
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for module in re.findall(r"python -m ((?:benchmarks|coopenv)[\w.]*)", text):
            assert find_spec(module), (page.name, module)
        code = [snippet.code for snippet in snippets(page) if snippet.language == "sh"]
        code += re.findall(r"`([^`\n]+)`", text)
        for name in re.findall(r"^(?:\S+=\S+ )?coopenv (\w+)", "\n".join(code), flags=re.MULTILINE):
            assert name in COMMANDS, (page.name, name)
        for name in re.findall(r"^make (\w+)", "\n".join(code), flags=re.MULTILINE):
            assert name in targets, (page.name, name)
        for name in re.findall(r"pip install '?(?:coopenv|\.)\[(\w+)\]", text):
            assert name in extras["optional-dependencies"], (page.name, name)
