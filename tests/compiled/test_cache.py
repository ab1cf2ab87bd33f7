"""The cache on disk: whose kernels it keeps, and what a write that was broken off leaves."""

import pytest

from coopenv.compiled import cache
from coopenv.compiled.dependencies import KERNELS, is_constant


def test_the_cache_is_for_kernels_of_ours_alone():
    kernel = next(iter(KERNELS))
    assert cache.Locator.from_function(kernel, kernel.__code__.co_filename) is not None
    assert cache.Locator.from_function(pytest.fail, pytest.__file__) is None


def test_a_write_that_is_broken_off_leaves_nothing(tmp_path):
    files = cache.Files(str(tmp_path), "kernel", "stamp")

    def stopped():
        with files._open_for_write(str(tmp_path / "data")) as file:
            file.write(b"half of it")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert not list(tmp_path.iterdir())
    with files._open_for_write(str(tmp_path / "data")) as file:
        file.write(b"all of it")
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_a_kernel_depends_on_numbers_and_on_tuples_of_nothing_else():
    assert all(map(is_constant, (1, 0.5, (1, (2.0, True)))))
    assert not any(map(is_constant, ("word", (1, "word"), ((1, object()), 2), [1])))
