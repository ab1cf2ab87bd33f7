"""Damaged recordings and layouts of every format are read or refused in words."""

import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("pandas")

from coopenv.logs import formats
from tests.reliability import damaged as campaign
from tests.reliability.damaged import KINDS, NAMES, NEEDS, check, damaged, is_damaged, remove
from tests.reliability.whole import WHOLE

EACH = 100  # files of a kind that is written
READ = 30  # of one that is only read
MANY = 500  # of every kind, where all of them are looked at


@pytest.mark.parametrize("kind", range(len(KINDS)), ids=NAMES)
def test_a_damaged_file_is_read_or_refused_in_words(kind, tmp_path):
    pytest.importorskip(NEEDS[kind])
    each = EACH if kind < len(KINDS) - len(WHOLE) else READ
    for seed in range(kind, each * len(KINDS), len(KINDS)):
        path = damaged(seed, tmp_path)
        check(path)
        remove(path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", range(len(KINDS)), ids=NAMES)
def test_each_of_five_hundred_damaged_files_is_read_or_refused_in_words(kind, tmp_path):
    pytest.importorskip(NEEDS[kind])
    found, seed = 0, kind
    while found < MANY:
        path = damaged(seed, tmp_path)
        check(path)
        remove(path)
        found, seed = found + is_damaged(seed), seed + len(KINDS)
    assert seed < kind + 3 * MANY * len(KINDS)


def test_every_format_that_is_read_is_damaged():
    damages = {suffix for suffix, _ in KINDS if suffix not in (".toml", ".json")}
    for known in (*formats.FORMATS, *formats.READ):
        assert damages & set(known.suffixes), known.suffixes
    assert "" in damages  # folders
    assert len(NAMES) == len(KINDS)


def test_a_seed_always_makes_the_same_file(tmp_path):
    (tmp_path / "again").mkdir()
    for seed in range(len(KINDS) - len(WHOLE)):  # libraries may write the time into others
        once, again = damaged(seed, tmp_path), damaged(seed, tmp_path / "again")
        assert once.name == again.name
        assert once.read_bytes() == again.read_bytes()


@pytest.mark.parametrize("fault", ["raises", "leaves", "several lines", "names nothing"])
def test_what_is_wrong_is_told_with_how_to_see_it_again(fault, tmp_path, monkeypatch):
    path = tmp_path / "damaged-0.csv"
    path.write_text("")

    def wrong(given, **_):
        if fault == "leaves":
            (tmp_path / "part").write_text("")
        if fault == "raises":
            raise KeyError("f1x")
        said = {"several lines": f"{given}\n; mend it", "names nothing": "bad; mend it"}
        raise campaign.CoopenvError(said.get(fault, f"{given} is bad; mend it"))

    monkeypatch.setattr(campaign, "decompose_file", wrong)
    says = {"raises": "raised KeyError", "leaves": "left .*part", "names nothing": "does not name"}
    with pytest.raises(AssertionError, match=says.get(fault, fault)) as raised:
        check(path)
    assert "check(damaged(0, " in str(raised.value)
    assert str(raised.value).count("\n") < 10


def test_some_are_read_and_most_refused(tmp_path):
    read = 0
    kinds = len(KINDS) - len(WHOLE)
    for number in range(120):
        path = damaged(number // kinds * len(KINDS) + number % kinds, tmp_path)
        try:
            made = campaign.use(path)
        except campaign.CoopenvError:
            continue
        read += 1
        for each in made:
            each.unlink()
    assert 12 < read < 80
