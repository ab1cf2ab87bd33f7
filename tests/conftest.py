"""Settings of all tests."""

import gc

from hypothesis import settings

settings.register_profile("coopenv", deadline=None)  # on a busy machine any example may take long
settings.load_profile("coopenv")


def pytest_collection_finish() -> None:
    """Leave what all tests share out of every later search for garbage, and of those of forks."""
    gc.collect()
    gc.freeze()
