"""Threads of torch, for networks that are too small to share among several."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def torch_threads(count: int) -> Iterator[None]:
    """Let torch compute with so many threads meanwhile, if something has imported it.

    By default it takes one a core, which wait for each other in a loop: on a busy machine a batch
    of a few hundred rows then takes many times as long.
    """
    torch = sys.modules.get("torch")
    if torch is None:
        yield
        return
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        yield
    finally:
        torch.set_num_threads(before)
