"""Decomposition of a recorded file to table, picture and summary, chunk by chunk."""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.files import require_writable, writing, written
from coopenv.logs.analysis import analyse
from coopenv.logs.consistency import Again, Check
from coopenv.logs.consistency.told import Checked
from coopenv.logs.figure import Picture
from coopenv.logs.formats import FORMATS, find_format, open_sink, table_beside
from coopenv.logs.formats.bags import require_recording
from coopenv.logs.formats.chunks import Sink
from coopenv.logs.layout import Layout
from coopenv.logs.limits import legible
from coopenv.logs.recording import Reader, naming
from coopenv.logs.summary import Collector, Summary
from coopenv.wrench import Settings


def check_file(
    path: str | os.PathLike,
    *,
    layout: Layout | None = None,
    bad_rows: str = "error",
    report: Callable[[float], object] | None = None,
) -> Checked:
    """Compare a recording with its motion, without decomposing it; nothing is written.

    Parameters
    ----------
    path, layout, bad_rows, report
        See `decompose_file`. With mass and inertia in ``layout.body`` the comparison has numbers.

    Raises
    ------
    InvalidInput
        If the file, a column or a row is wrong; the message names file, line and column.
    """
    layout = layout if layout is not None else Layout()
    reader = Reader(path, layout, bad_rows=bad_rows)
    again = Again(
        layout, tuple(reader.plan.source), lambda other: Reader(path, other, bad_rows=bad_rows)
    )
    check, rows = Check(reader.layout, reader.devices, again), 0
    for recording in reader:
        check.add(recording)
        rows += len(recording)
        if report is not None:
            report(reader.progress)
    return Checked(
        rows=rows,
        bad_rows=reader.faults.count,
        assumed=reader.assumed,
        done=reader.done,
        consistency=check.result(),
        notes=tuple(map(legible, reader.notes)),
    )


def decompose_file(
    path: str | os.PathLike,
    out: str | os.PathLike | None = None,
    *,
    layout: Layout | None = None,
    settings: Settings | None = None,
    bad_rows: str = "error",
    picture: bool = True,
    report: Callable[[float], object] | None = None,
) -> Summary:
    """Decompose every row of a file; write a table, a picture of its time series and a summary.

    Memory does not grow with the number of rows. All three are written whole, or none.

    Parameters
    ----------
    path
        A CSV, NPZ or Parquet file; docs/recordings.md lists its columns.
    out
        Of the table, whose suffix says its format; ``trial.decomposed.csv`` beside ``trial.csv`` if
        ``None``. The picture has the same name, ending in ``.png``, the summary in
        ``.summary.json``.
    layout
        How the columns are called, their frames and units.
    settings
        Which definition of internal wrench, which cost, which solver.
    bad_rows
        ``"error"``: raise at the first row that cannot be used; ``"skip"``: results are NaN there.
    picture
        Whether to draw.
    report
        Called with the share of the file that is done.

    Raises
    ------
    InvalidInput
        If the file, a column or a row is wrong, or a file cannot be read or written; the message
        names file, line and column.
    MissingExtra
        If a format or the picture needs the extra ``analysis``.
    """
    path, table = _places(Path(path), None if out is None else Path(out))
    settings = settings if settings is not None else Settings()
    reader = Reader(path, layout, bad_rows=bad_rows)
    drawing = Picture(f"{legible(path.name)}, {settings.method}") if picture else None
    beside = table.with_suffix(".png")
    image = beside if picture else None
    said = table.with_suffix(".summary.json")
    with writing(table), ExitStack() as stack:
        part = stack.enter_context(_begun(table))
        image_part = None if image is None else stack.enter_context(_begun(image))
        said_part = stack.enter_context(_begun(said))
        sink = open_sink(part)
        try:
            with writing(table):
                collector, check = _fill(sink, reader, settings, drawing, report)
                with naming(reader.path):
                    if reader.done:
                        sink.describe(reader.done)
                    sink.close()
        except BaseException:
            with suppress(OSError, ValueError):  # what went wrong first is what is told
                sink.abandon()
            raise
        if drawing is not None and image_part is not None:
            drawing.draw(image_part)
        summary = collector.summary(
            table=table,
            picture=image,
            written=said,
            method=settings.method,
            bad_rows=reader.faults.count,
            first_bad=reader.faults.first.partition(";")[0],
            left_out=tuple(reader.left_out),
            assumed=reader.assumed,
            done=reader.done,
            consistency=check.result(),
            notes=reader.notes,
            old_picture=beside if image is None and beside.is_file() else None,
        )
        summary.save(said_part)
    return summary


@contextmanager
def _begun(path: Path) -> Iterator[Path]:
    """Like `coopenv.files.written`, but raise at once where the file cannot be written."""
    require_writable(path)
    with written(path) as part:
        yield part


def _fill(
    sink: Sink,
    reader: Reader,
    settings: Settings,
    drawing: Picture | None,
    report: Callable[[float], object] | None,
) -> tuple[Collector, Check]:
    """Everything, chunk by chunk."""
    collector, check = Collector(), Check(reader.layout, reader.devices)
    for recording in reader:
        with naming(reader.path):
            analysis = analyse(recording, settings)
            sink.write(analysis.columns)
        collector.add(recording, analysis)
        check.add(recording)
        if drawing is not None:
            drawing.add(recording, analysis)
        if report is not None:
            report(reader.progress)
    return collector, check


def _places(path: Path, out: Path | None) -> tuple[Path, Path]:
    """Where the input is and the table goes."""
    require_recording(path)
    table = table_beside(path) if out is None else out
    find_format(table, FORMATS)
    with writing(table):
        if table.exists() and table.samefile(path):
            raise InvalidInput(
                f"out must not be the input, got {str(table)!r}; choose another name"
            )
    return path, table
