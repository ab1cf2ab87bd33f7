"""Samples of mutants: seeded, over all folders; and mutants known as equivalent."""

from collections import Counter

import pytest

from benchmarks.mutants import equivalent
from benchmarks.mutants.places import places
from benchmarks.mutants.sample import sample
from benchmarks.mutants.source import Source
from tests.benchmarks.mutants.cases import change_of, source, toy
from tests.sources import ROOT


def test_a_sample_is_seeded_and_goes_through_all_folders(tmp_path):
    project = toy(tmp_path)
    keys = [change.key for _, change in sample(project, 12, seed=3)]
    assert keys == [change.key for _, change in sample(project, 12, seed=3)]
    assert keys[:5] == [change.key for _, change in sample(project, 5, seed=3)]
    assert keys != [change.key for _, change in sample(project, 12, seed=4)]
    folders = Counter(change.file.rpartition("/")[0] for _, change in sample(project, 6, seed=0))
    assert set(folders) == {"toy", "toy/inner"}
    everything = sample(project, 1000, seed=0)
    assert len({change.start for _, change in everything if change.file == "toy/inner/sums.py"}) > 2


def test_an_equivalent_mutant_is_known_wherever_its_line_stands(tmp_path):
    known = tmp_path / "equivalent.toml"
    known.write_text(
        '[[equivalent]]\nfile = "toy/text.py"\nline = "a = b < c"\n'
        'changed = "a = b <= c"\nreason = "b is never c"\n'
    )
    for text in ("a = b < c\n", "z = y\n\nif z:\n    a  =  b < c\n"):
        made = source(text)
        assert equivalent.reason(change_of(made, "<", "<="), made, known) == "b is never c"
        assert not equivalent.reason(change_of(made, "<", ">="), made, known)


@pytest.mark.parametrize("kind", ["equivalent", "left"])
def test_every_known_mutant_still_stands_in_its_file(kind):
    for (file, line, changed), reason in equivalent.entries(kind).items():
        made = Source(file, (ROOT / file).read_bytes())
        lines = {change.lines(made.text) for found in places(made) for change in found}
        assert (line, changed) in lines, f"{file}: {line}"
        assert reason
