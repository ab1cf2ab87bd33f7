"""Records of the tests: the parent holds none of the code, and a broken file is told of."""

import subprocess
import sys

import pytest

from benchmarks.mutants.recording import Recorder
from benchmarks.mutants.tree import Tree
from tests.benchmarks.mutants.cases import toy

PARENT = """
import sys
import benchmarks.mutants.__main__
print([name for name in sys.modules if name.partition(".")[0] in ("coopenv", "agents", "rewards")])
"""


def test_children_come_from_a_process_without_any_code_under_test():
    done = subprocess.run([sys.executable, "-c", PARENT], capture_output=True, text=True)
    assert (done.stdout.strip(), done.stderr) == ("[]", "")


def test_a_file_of_tests_that_cannot_be_imported_is_told_of(tmp_path):
    project = toy(tmp_path / "project")
    (project.root / "tests/test_beam.py").write_text("import nothing_of_this_name\n")
    recorder = Recorder(Tree.copied(project, tmp_path / "work"), tmp_path / "records")
    recorder.complete(["tests/inner/test_sums.py"])
    with pytest.raises(RuntimeError, match=r"tests/test_beam\.py must leave a record"):
        recorder.complete(["tests/test_beam.py"])
