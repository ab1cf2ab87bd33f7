"""Reading of recorded trials of pairs from the files of users."""

import os
from collections.abc import Sequence

import numpy as np
import pandas as pd

from coopenv.errors import InvalidInput
from coopenv.logs import Layout, Recording, read

from ..tables import Table
from .trials import COLUMNS, KEYS, checked_trials, table_of


def read_trials(paths: Sequence[str | os.PathLike], layout: Layout | None = None) -> Table:
    """Read CSV, NPZ or Parquet files of trials into one checked table.

    They are read as ``coopenv decompose`` reads them (docs/recordings.md), and must say the time,
    the pose, and in three columns pair, condition and trial.

    Parameters
    ----------
    paths
        Of the files.
    layout
        How columns are called, their frames and units, where the effectors hold; those of
        `coopenv.agents.studies.dyads.trials` if ``None``. Its ``trial_columns`` name those
        of pair, condition and trial, in this order.

    Raises
    ------
    InvalidInput
        If a file cannot be read, or its trials are refused as in `checked_trials`; the message
        names the file.
    """
    if not paths:
        raise InvalidInput("files must be given, got none; name CSV, NPZ or Parquet files")
    layout = layout if layout is not None else Layout()
    parts = []
    for path in paths:
        recording = read(path, layout)
        try:
            parts.append(_planar(recording, layout))
        except InvalidInput as error:
            raise InvalidInput(f"{os.fspath(path)}: {error}") from error
    return checked_trials(pd.concat(parts, ignore_index=True))


def _planar(recording: Recording, layout: Layout) -> Table:
    """What one file says, as a table."""
    names = layout.trial_columns
    missing = [name for name in names if name not in recording.carried]
    for name, value in (
        ("time", recording.time),
        ("x, y", recording.position),
        ("theta", recording.orientation),
    ):
        missing += [name] if value is None else []
    if missing or len(names) != len(KEYS):
        raise InvalidInput(
            f"trials must have the columns {', '.join(COLUMNS)}, got none for {', '.join(missing)} "
            f"and {names} for pair, condition and trial; add them, or name them in a layout"
        )
    if recording.applied.shape[1:] != (2, 3):
        raise InvalidInput(
            f"trials must be of two effectors in the plane, got {recording.num_effectors} with "
            f"{recording.applied.shape[2]} components; leave the others out, or say space = 'plane'"
        )
    assert recording.time is not None
    assert recording.position is not None
    assert recording.orientation is not None
    pair, condition, trial = (recording.carried[name] for name in names)
    return table_of(
        pair=pair,
        condition=condition,
        trial=trial,
        time=recording.time,
        pose=np.column_stack([recording.position, recording.orientation]),
        applied=recording.applied,
        grips=recording.grips,
        first=recording.carried.get("first"),
    )
