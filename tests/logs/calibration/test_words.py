"""What was done to a recording is said in a sentence each."""

from coopenv.logs import Layout
from coopenv.logs.corrections.words import sentences


def test_each_correction_is_said_and_nothing_else():
    assert sentences(Layout.load(), []) == ()
    said = sentences(
        Layout.load(filters={"twist_window": 0.1, "rate": 100.0}, pose={"delay": 0.04}), []
    )
    assert said == (
        "delay: pose and twist taken 0.04 s earlier",
        "twist: from the pose, by cubics over 0.1 s",
        "resampled: 100 rows a second, linear, orientation by slerp",
    )
