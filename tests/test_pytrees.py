"""JAX, here a module that stands for it, is told of infos when it is imported."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from coopenv.info import Info
from coopenv.pytrees import TREES, register_dictionary

FAKE = """
from collections import namedtuple

DictKey = namedtuple("DictKey", "key")
known = {}

def register_pytree_with_keys(kind, flatten_with_keys, unflatten, flatten):
    known[kind] = flatten_with_keys, unflatten, flatten
"""
LATER = """
import sys
from coopenv.info import Info
assert not [name for name in sys.modules if name.startswith("jax")]
told = Info({"success": True, "reward/progress": 0.5})
import jax
from jax.tree_util import DictKey, known
with_keys, made, flat = known[Info]
entries, names = flat(told)
assert (entries, names) == ([0.5, True], ("reward/progress", "success")), (entries, names)
assert flat(Info(reversed(told.items()))) == (entries, names)
assert with_keys(told) == ([(DictKey("reward/progress"), 0.5), (DictKey("success"), True)], names)
again = made(names, [[entry] for entry in entries])
assert again["reward_terms"] == {"progress": [0.5]}
assert type(again) is Info
assert len(known) == 1
assert "exec_module" not in vars(jax.tree_util.__spec__.loader)  # as it was
print("as wanted")
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One with a module that stands for JAX."""
    (tmp_path / "jax").mkdir()
    (tmp_path / "jax" / "__init__.py").write_text("from jax import tree_util as tree_util\n")
    (tmp_path / "jax" / "tree_util.py").write_text(FAKE)
    return tmp_path


def test_an_info_is_a_tree_of_its_entries_for_jax_that_is_imported_after_it(folder):
    setting = f"import sys; sys.path.insert(0, {str(folder)!r})\n"
    done = subprocess.run(
        [sys.executable, "-c", setting + LATER], capture_output=True, text=True, check=False
    )
    assert done.stdout == "as wanted\n", done.stderr


def test_a_dictionary_is_registered_at_once_where_jax_is_imported(monkeypatch):
    known = []
    trees = SimpleNamespace(register_pytree_with_keys=lambda kind, *_: known.append(kind))
    monkeypatch.setitem(sys.modules, TREES, trees)
    hooks = list(sys.meta_path)
    register_dictionary(Info)
    assert known == [Info]
    assert sys.meta_path == hooks
