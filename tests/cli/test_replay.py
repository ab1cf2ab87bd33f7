"""coopenv replay, as a user calls it."""

import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("pygame")
pytest.importorskip("PIL")
from PIL import Image

from coopenv import cli
from coopenv.agents import record
from coopenv.render import film
from tests.logs import cases

SHORT = ("--horizon", 2, "--width", 160)
GRIPS = ("--grips", *cases.BEAM)


def run(*arguments) -> int:
    return cli.main(["replay", *(str(argument) for argument in arguments)])


@pytest.fixture(autouse=True)
def _here(monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def trial(tmp_path):
    columns = cases.planar(rows=31) | {"trial": np.repeat([1, 2], [20, 11])}
    return cases.save(columns, tmp_path / "trial.csv")


def seen(path) -> tuple[int, tuple[int, int]]:
    """Its length [ms] and size."""
    with Image.open(path) as image:
        lengths = []
        for k in range(getattr(image, "n_frames")):  # noqa: B009
            image.seek(k)
            lengths.append(image.info["duration"])
        return sum(lengths), image.size


def test_an_episode_is_a_film_with_its_time_series_beside_it(tmp_path, capsys):
    assert run("scripted", "--env", "coopenv/BeamDoorway-v0", "--partner", "follower", *SHORT) == 0
    printed = capsys.readouterr().out
    assert "scripted in coopenv/BeamDoorway-v0 with" in printed
    assert "episode 1 of evaluation 0: no success after 0.10 s, 2 steps" in printed
    assert "wrote replay.gif, 19 pictures, 20 a second" in printed
    length, (width, _) = seen(tmp_path / "replay.gif")
    assert length == 50 * (1 + 2 + 16)  # start, steps, and 0.8 s for which the last stays
    assert width == 160 + 136
    assert [path.name for path in tmp_path.iterdir()] == ["replay.gif"]


def test_several_episodes_make_a_mosaic(tmp_path, capsys):
    assert run("random", "--mosaic", 3, "--episode", 2, "--out", "a/m.gif", *SHORT) == 0
    printed = capsys.readouterr().out
    for episode in (2, 3, 4):
        assert f"episode {episode} of evaluation 0: no success" in printed
    assert seen(tmp_path / "a/m.gif")[1][0] == 2 * (160 + 136)


def test_the_time_series_can_be_left_out(trial, tmp_path):
    assert run("random", "--mosaic", 3, "--no-series", "--out", "m.gif", *SHORT) == 0
    assert seen(tmp_path / "m.gif")[1][0] == 2 * 160
    assert run(trial, *GRIPS, "--end", 0.03, "--no-series", "--width", 160) == 0
    assert seen(trial.with_name("trial.replay.gif"))[1][0] == 160


def test_a_trial_of_a_recording_is_a_film_beside_it(trial, capsys):
    assert run(trial, *GRIPS, "--trial", 2, "--speed", 0.1, "--width", 160) == 0
    assert "trial 2 of 2, 0.10 s, 11 rows\n" in capsys.readouterr().out
    assert seen(trial.with_name("trial.replay.gif"))[0] == 1000 + 50 + 800


def test_a_part_of_a_trial_is_what_lies_in_it(trial, capsys):
    assert run(trial, *GRIPS, "--start", 0.05, "--end", 0.08, "--width", 160) == 0
    assert "trial 1 of 2, 0.03 s, 4 rows\n" in capsys.readouterr().out


def test_what_a_recording_lacks_of_its_pose_is_said(tmp_path, capsys):
    columns = cases.planar(rows=5)
    for name in ("x", "y", "theta", "vx", "vy", "omega"):
        del columns[name]
    columns["f1x"][[0, 2]] = np.nan
    path = cases.save(columns, tmp_path / "felt.csv")
    assert run(path, *GRIPS, "--width", 160) == 1
    assert "f1x" in capsys.readouterr().err
    assert run(path, *GRIPS, "--width", 160, "--bad-rows", "skip") == 0
    said = capsys.readouterr().out
    assert "4 rows; without x, y and theta, which are drawn as 0" in said


def test_a_recording_in_space_is_a_film_too_and_in_the_plane_if_that_is_said(tmp_path, capsys):
    path = cases.save(cases.spatial(rows=3, num_effectors=3), tmp_path / "space.csv")
    assert run(path, "--width", 160) == 0
    assert "trial 1 of 1, 0.02 s, 3 rows\n" in capsys.readouterr().out
    assert seen(path.with_name("space.replay.gif"))[1][0] == 160 + 136
    assert run(path, "--width", 160, "--space", "plane", "--map", "vx=", "vy=") == 0
    assert "without theta" in capsys.readouterr().out


def test_what_a_recording_in_space_lacks_of_its_pose_is_said(tmp_path, capsys):
    columns = cases.spatial(rows=4)
    for name in [name for name in columns if name[0] in "qvo" or name in "xyz"]:
        del columns[name]
    columns["f1x"][1] = np.nan
    path = cases.save(columns, tmp_path / "felt.csv")
    assert run(path, "--width", 160, "--bad-rows", "skip") == 0
    said = capsys.readouterr().out
    assert "without x, y, z and qw, qx, qy, qz, which are drawn as if it neither moved" in said


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("scriptd",), "what must be a policy (scripted, random, pretrained:Beam"),
        (("random", "--out", "a.avi"), "out must end in one of .gif, .mp4"),
        (("random", "--fps", 60), "fps must be at most 50 in a GIF, got 60"),
        (("random", "--fps", 0), "fps must be positive"),
        (("random", "--fps", 0.5, "--out", "a.mp4"), "fps must be from 1 to 240, got 0.5"),
        (("random", "--speed", -1), "speed must be positive"),
        (("random", "--width", 10), "width must be a whole number of at least 160"),
        (("random", "--episode", 0), "episode must be a whole number of at least 1"),
        (("random", "--mosaic", 65), "mosaic must be"),
        (("random", "--trial", 2), "trial must be left out beside a policy"),
        (("random", *SHORT, "--speed", 1e-6), "film must have at most 20000 pictures"),
        (("trial.csv", "--seed", 1), "seed must be left out beside a recording"),
        (("trial.csv", "--horizon", 5), "options of the environment must be left out beside"),
        (("trial.csv", *GRIPS, "--trial", 3), "trial must be at most 2, got 3"),
        (("trial.csv", *GRIPS, "--start", 5), "start and end must leave rows"),
        (("trial.csv", *GRIPS, "--end", "nan"), "end must be"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_leaves_nothing(arguments, message, trial, capsys):
    assert run(*arguments) == 1
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert [path.name for path in trial.parent.iterdir()] == ["trial.csv"]


def test_a_recording_without_times_needs_a_rate(tmp_path, capsys):
    columns = cases.planar(rows=5)
    del columns["time"]
    path = cases.save(columns, tmp_path / "rows.csv")
    assert run(path, *GRIPS, "--width", 160) == 1
    assert "--sample-rate" in capsys.readouterr().err
    assert run(path, *GRIPS, "--width", 160, "--sample-rate", 10) == 0
    assert "0.40 s, 5 rows" in capsys.readouterr().out


def test_a_film_that_is_interrupted_leaves_the_old_one(tmp_path, monkeypatch, capsys):
    (tmp_path / "replay.gif").write_text("old")

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(film, "save_gif", stop)
    assert run("random", *SHORT) == 130
    assert "interrupted" in capsys.readouterr().err
    assert (tmp_path / "replay.gif").read_text() == "old"


def test_evaluated_steps_are_recorded_and_replayed(tmp_path, capsys):
    evaluate = ("evaluate", "scripted", "random", "--episodes", "2", "--horizon", "3")
    assert cli.main([*evaluate, "--record", "steps.csv"]) == 0
    columns = cases.load(tmp_path / "steps.csv")
    assert columns["condition"].tolist() == ["scripted"] * 6 + ["random"] * 6
    assert columns["trial"].tolist() == [1, 1, 1, 2, 2, 2] * 2
    assert run("steps.csv", "--trial", 4, "--width", 160) == 0
    assert "trial 4 of 4, 0.10 s, 3 rows" in capsys.readouterr().out


def test_steps_that_cannot_be_recorded_leave_the_old_ones(tmp_path, monkeypatch, capsys):
    for name in ("steps.xlsx", "steps.mat"):
        assert cli.main(["evaluate", "random", "--record", name]) == 1
        assert "file must end in one of .csv" in capsys.readouterr().err
    (tmp_path / "steps.csv").write_text("old")

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(record.Recorder, "end", stop)
    evaluate = ["evaluate", "random", "--episodes", "2", "--horizon", "2"]
    assert cli.main([*evaluate, "--record", "steps.csv"]) == 130
    assert (tmp_path / "steps.csv").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["steps.csv"]
