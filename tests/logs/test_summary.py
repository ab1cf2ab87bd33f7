"""The summary of a recording, by hand: its statistics over pieces, and every line it prints."""

import io
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from coopenv.logs import Layout, decompose_file
from coopenv.logs import summary as summaries
from coopenv.logs.analysis import Worst
from coopenv.logs.consistency import Consistency
from coopenv.logs.consistency.mistakes import Fit
from coopenv.logs.recording import Recording
from coopenv.logs.summary import Collector, Measure, Summary
from tests.logs import cases


def part(values, *, time=None, trial=None, good=None):
    """A recording of as many rows, and its analysis with one column."""
    rows = len(values)
    recording = Recording(
        time=None if time is None else np.array(time, dtype=float),
        applied=np.zeros((rows, 1, 3)),
        grips=np.zeros((1, 2)),
        position=None, orientation=None, twist=None, carried={},
        trial=np.zeros(rows, np.int64) if trial is None else np.array(trial),
        good=np.ones(rows, np.bool_) if good is None else np.array(good),
    )  # fmt: skip
    return recording, np.array(values, dtype=float)


def collected(*parts, **analysis: Any) -> Summary:
    collector = Collector()
    known = {"gap": 0.0, "fallbacks": 0, "solver": "pair", "worst": Worst(), **analysis}
    for number, (recording, values) in enumerate(parts):

        class Columns(SimpleNamespace):
            def __getitem__(self, name):
                return self.columns[name]

        each = {
            name: value[number] if isinstance(value, list) else value
            for name, value in known.items()
        }
        columns = {"wasted_cost": values, "force_load_share_1": -values, "note": values}
        each["results"] = [name for name in columns if name != "note"]
        collector.add(recording, Columns(columns=columns, **each))  # pyright: ignore[reportArgumentType]
    here = Path("a")
    return collector.summary(
        table=here, picture=None, written=here, method="optimal", bad_rows=0, first_bad="",
        left_out=(), assumed=(), consistency=Consistency(),
    )  # fmt: skip


def test_statistics_are_those_of_all_good_rows_of_all_pieces():
    first = part([1.0, 2.0, np.nan, 99.0], good=[True, True, True, False])
    second = part([6.0, 3.0, 4.0])
    made = collected(first, second)
    assert made.rows == 7
    waste, share = made.measures
    assert (waste.name, waste.unit) == ("wasted_cost", "N")
    assert (share.name, share.unit) == ("force_load_share_1", "")
    assert (waste.mean, waste.median, waste.largest) == pytest.approx((3.2, 3.0, 6.0))
    assert (waste.low, waste.high) == pytest.approx((1.2, 5.6))  # of 1, 2, 3, 4, 6
    assert waste.undefined == pytest.approx(1 / 6)
    assert (share.mean, share.largest) == pytest.approx((-3.2, -1.0))


def test_a_column_that_is_never_defined_has_no_statistics():
    (waste, _) = collected(part([np.nan, np.nan])).measures
    assert waste.undefined == 1.0
    for name in ("mean", "median", "low", "high", "largest"):
        assert np.isnan(getattr(waste, name)), name
    (none, _) = collected(part([1.0], good=[False])).measures
    assert none.undefined == 1.0
    assert np.isnan(none.mean)


@pytest.mark.parametrize(("piece", "every"), [(1, 16), (3, 16), (7, 16), (1000, 2)])
def test_percentiles_of_many_rows_are_of_an_even_sample(piece, every, monkeypatch):
    monkeypatch.setattr(summaries, "SAMPLE", 100)
    values = np.arange(1000.0)
    waste = collected(*(part(values[k : k + piece]) for k in range(0, 1000, piece))).measures[0]
    assert (waste.mean, waste.largest, waste.undefined) == (499.5, 999.0, 0.0)
    kept = values[::every]
    wanted = np.percentile(kept, [5, 50, 95])
    assert (waste.low, waste.median, waste.high) == pytest.approx(tuple(wanted))


def test_trials_last_from_their_first_row_to_their_last_also_across_pieces():
    made = collected(
        part([1, 1, 1], time=[5.0, 5.5, 0.0], trial=[0, 0, 1]),
        part([1, 1, 1], time=[1.0, 9.0, 7.0], trial=[1, 1, 2], good=[True, False, True]),
        part([1, 1], time=[7.25, 8.0], trial=[2, 2]),
    )
    assert made.trials == 3
    assert made.duration == pytest.approx(0.5 + 1.0 + 1.0)
    assert collected(part([1.0])).duration is None


def test_the_worst_of_all_pieces_counts_and_fallbacks_add_up():
    made = collected(
        part([1.0]), part([1.0]),
        gap=[3e-9, 2e-9], fallbacks=[2, 3], solver=["structured", "conic"],
        worst=[Worst(1e-9, 4e-9, 0, 5e-9), Worst(2e-9, 3e-9, 1e-9, 0)],
    )  # fmt: skip
    assert made.gap == 3e-9
    assert made.fallbacks == 5
    assert made.solver == "structured, conic"
    assert made.worst == Worst(2e-9, 4e-9, 1e-9, 5e-9)


def hand_made(**changes: Any) -> Summary:
    measures = (
        Measure(name="wasted_cost", unit="N", mean=1.234, median=0.5, low=0.012, high=9.87,
                largest=12345.0, undefined=0.0),
        Measure(name="force_load_share_2", unit="", mean=0.4, median=np.nan, low=np.nan,
                high=np.nan, largest=0.75, undefined=0.0625),
    )  # fmt: skip
    known = {
        "table": Path("out.csv"), "picture": None, "written": Path("out.json"), "rows": 12345,
        "bad_rows": 0, "first_bad": "", "trials": 1, "duration": None, "method": "optimal",
        "solver": "pair", "fallbacks": 7, "gap": 1.5e-9,
        "worst": Worst(1e-12, 2e-12, 3e-12, 4e-12), "measures": measures, "left_out": (),
        "assumed": (), "consistency": Consistency(unchecked="it has no time"),
    }  # fmt: skip
    return Summary(**{**known, **changes})


def printed(summary: Summary) -> list[str]:
    rich = pytest.importorskip("rich.console")
    console = rich.Console(width=200, record=True, file=io.StringIO())
    summary.print(console)
    return [line for line in console.export_text().splitlines() if line.strip(" ─")]


def test_every_cell_is_the_number_of_its_heading():
    lines = printed(hand_made())
    heading, first, second = (line.split() for line in lines[-3:])
    assert heading == ["mean", "median", "5", "%", "95", "%", "largest", "undefined"]
    assert first == ["wasted_cost", "[N]", "1.23", "0.5", "0.012", "9.87", "1.23e+04", "0.0", "%"]
    assert second == ["force_load_share_2", "0.4", "-", "-", "-", "0.75", "6.2", "%"]


def test_every_line_says_its_number():
    assert printed(hand_made())[:3] == [
        "12,345 rows; optimal by pair",
        "not compared with the motion: it has no time",
        "worst residuals: balance 1.0e-12 N or N·m, force 2.0e-12 N, induced torque 3.0e-12 N·m, "
        "torque 4.0e-12 N·m; largest gap 1.5e-09 N; 7 fallbacks",
    ]
    checked = Consistency(fit=Fit(force=0.987, power=0.5), warnings=("turn it", "or that"))
    all_of_it = hand_made(
        trials=2, duration=1234.5678, bad_rows=3000, first_bad="row 7 is bad", left_out=("a", "b"),
        old_picture=Path("out.png"), assumed=("frames: x", "units: y"), consistency=checked,
    )  # fmt: skip
    assert printed(all_of_it)[:9] == [
        "12,345 rows, 2 trials, 1,234.568 s; optimal by pair",
        "3,000 bad rows are NaN; the first: row 7 is bad",
        "left out, as no columns or not used: a, b",
        "out.png was there before and shows another table",
        "assumed frames: x",
        "assumed units: y",
        "motion explains, as assumed, 99 % of force, 50 % of power",
        "warning: turn it",
        "warning: or that",
    ]


def test_the_file_of_the_summary_holds_its_numbers(tmp_path):
    hand_made(consistency=Consistency(fit=Fit(force=0.5))).save(tmp_path / "a.json")
    told = json.loads((tmp_path / "a.json").read_text("utf-8"))
    assert told["worst"] == {"balance": 1e-12, "force": 2e-12, "induced_torque": 3e-12,
                             "torque": 4e-12}  # fmt: skip
    assert told["measures"][1]["median"] is None
    assert told["measures"][0]["largest"] == 12345.0
    assert (told["table"], told["picture"], told["fallbacks"]) == ("out.csv", None, 7)
    assert told["consistency"]["fit"] == {"force": 0.5, "torque": None, "power": None}


@pytest.mark.parametrize("suffix", cases.FORMATS)
@pytest.mark.parametrize("first", [9, 10, 11, 12])
def test_the_first_bad_row_is_the_first_of_the_file_not_of_a_piece(
    suffix, first, tmp_path, monkeypatch
):
    pytest.importorskip("pyarrow")
    cases.set_chunk(5, monkeypatch)
    columns = cases.planar(20)
    columns["f2y"][first] = columns["f1x"][first + 1] = np.nan  # of two pieces, for some
    path = cases.save(columns, tmp_path / f"a{suffix}")
    made = decompose_file(path, layout=Layout(grips=cases.BEAM), bad_rows="skip", picture=False)
    assert made.bad_rows == 2
    place = f"line {first + 2}" if suffix == ".csv" else f"row {first + 1}"
    assert f"{place}, column 'f2y' must be" in made.first_bad
