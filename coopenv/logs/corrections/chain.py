"""The chain of corrections that a layout declares, over recordings that come chunk by chunk."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.differentiation import window_rows
from coopenv.logs.calibration.processing import Filters, Pose
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST
from coopenv.logs.convert import rotations
from coopenv.logs.corrections.mounted import Mounted, gravity_in_object, placed
from coopenv.logs.corrections.out_of_plane import LeftOut
from coopenv.logs.corrections.steps import Smoothing, at_rate, earlier, motion_of, with_twist
from coopenv.logs.corrections.tares import Bias, Opener, find_biases
from coopenv.logs.corrections.words import sentences
from coopenv.logs.layout import Layout
from coopenv.logs.plan import Plan
from coopenv.logs.recorded import Recording, by_runs

NOTHING = (Filters(), Pose())


class Corrections:
    """What is done to the rows of one file, in this order.

    Tracked origin to centre of mass, delay of the pose, twist from the pose, sensors, tares that
    are found in files, low pass, resampling. Without any of it recordings go through untouched.

    Parameters
    ----------
    path
        Of the file, for messages.
    layout
        What was declared.
    plan
        Which columns there are.
    opener
        Opens a file as recordings, to find tares in it.

    Raises
    ------
    InvalidInput
        If what is declared does not go with the file.
    """

    def __init__(self, path: str, layout: Layout, plan: Plan, opener: Opener):
        self._path, self._layout, self._opener = path, layout, opener
        self.done: tuple[str, ...] = ()
        self._late = 0  # rows for which no pose came
        for number in layout.sensors:
            if number > plan.num_effectors:
                raise InvalidInput(
                    f"sensors must be those of the {plan.num_effectors} effectors, got "
                    f"sensors.{number}; number them as the columns f1x, f2x …"
                )
        self._sensors = [
            Mounted.of(number, sensor, layout, plan.dimension)
            for number, sensor in sorted(layout.sensors.items())
        ]
        self._six_axes = [each.place for each in self._sensors if each.six_axes]
        flip = np.array([1.0, -1.0]) if layout.y == "down" else np.ones(plan.dimension)
        self._gravity = layout.body.pull(plan.dimension) * flip
        length = layout.factor("length")
        self._com = placed(layout.pose.com, plan.dimension, "pose.com") * length * flip
        self._check(plan)

    def __call__(self, recordings: Iterable[Recording]) -> Iterator[Recording]:
        """Corrected recordings."""
        layout = self._layout
        if not layout.sensors and (layout.filters, layout.pose) == NOTHING:
            yield from recordings
            return
        biases = find_biases(self._path, layout, self._opener)
        self.done, self._late = sentences(layout, biases), 0
        self._left_out = LeftOut(self._six_axes)
        for step in self._steps(biases):
            recordings = step(recordings)
        rows = 0
        for recording in recordings:
            rows += len(recording)
            yield replace(recording, done=self.done)
        if self._late:
            told = f"delay: for {self._late:,} rows at ends of trials no pose came: no results"
            self.done = (*self.done, told)
        self.done = (*self.done, *self._left_out.sentences())
        if not rows:
            raise InvalidInput(
                f"{self._path} must have good rows to be resampled, got none; leave out "
                "filters.rate"
            )

    def _steps(self, biases: list[Bias]):
        """Functions from recordings to recordings."""
        layout, filters = self._layout, self._layout.filters
        if self._com.any():
            yield lambda rows: map(self._centred, rows)
        if layout.pose.delay:
            yield self._earlier
        if filters.twist_window is not None:
            window = filters.twist_window
            yield lambda rows: with_twist(rows, window)
        if self._sensors:
            yield self._sensed
        if self._six_axes:
            yield self._left_out.of
        if biases:
            yield lambda rows: (self._tared(each, biases) for each in rows)
        if any(each is not None for each in (filters.wrench, filters.pose, filters.twist)):
            yield Smoothing(filters)
        if filters.rate is not None:
            rate = filters.rate
            yield lambda rows: at_rate(rows, rate)

    def _earlier(self, recordings: Iterable[Recording]) -> Iterator[Recording]:
        """With the delay of the pose taken off; counts rows for which none came."""

        def known() -> Iterator[Recording]:
            for recording in recordings:
                self._late -= int((~recording.good).sum())
                yield recording

        for recording in earlier(known(), self._layout.pose.delay):
            self._late += int((~recording.good).sum())
            yield recording

    def _centred(self, recording: Recording) -> Recording:
        """From the tracked origin to the centre of mass."""
        com, position, twist = self._com, recording.position, recording.twist
        if position is not None and recording.orientation is not None:
            turn = _turns(recording)
            position = position + np.einsum("tij,j->ti", turn, com)
        if twist is not None and len(com) == 2:
            shift = twist[:, 2:] * np.array([-com[1], com[0]])
            twist = np.concatenate([twist[:, :2] + shift, twist[:, 2:]], axis=-1)
        elif twist is not None:
            shift = np.cross(twist[:, 3:], com)
            twist = np.concatenate([twist[:, :3] + shift, twist[:, 3:]], axis=-1)
        return replace(recording, position=position, twist=twist, grips=recording.grips - com)

    def _sensed(self, recordings: Iterable[Recording]) -> Iterator[Recording]:
        """With every sensor's wrench as its effector applies it."""
        windows = [each.load.window for each in self._sensors if each.load and each.load.window]
        if not windows:
            return (self._sensors_of(each, np.nan) for each in recordings)
        return by_runs(
            recordings,
            self._sensors_of,
            lambda rate: 2 * (window_rows(rate, max(windows)) + 2),
        )

    def _sensors_of(self, recording: Recording, rate: float) -> Recording:
        beyond = recording.out_of_plane
        recording = replace(
            recording,
            applied=recording.applied.copy(),
            out_of_plane=None if beyond is None else beyond.copy(),
        )
        hangs = any(each.load is not None for each in self._sensors)
        turn = _turns(recording) if hangs and self._gravity.any() else None
        gravity = gravity_in_object(recording, self._gravity, turn)
        for sensor in self._sensors:
            motion = None
            if sensor.load is not None and sensor.load.window is not None:
                motion = motion_of(recording, rate, sensor.load.window)
            sensor.correct(recording, gravity, motion)
        recording.applied[~recording.good] = np.nan
        return recording

    def _tared(self, recording: Recording, biases: list[Bias]) -> Recording:
        applied = recording.applied.copy()
        for bias in biases:
            if bias.last is not None and recording.trial[-1] > 0:
                raise InvalidInput(
                    f"sensors.{bias.place + 1}.tare.rests must be one rest where a file has "
                    f"several trials, got two for {self._path}; a drift needs one clock"
                )
            applied[:, bias.place] -= bias.at(recording.time, len(recording))
        return replace(recording, applied=applied)

    def _check(self, plan: Plan) -> None:
        """What goes together, and what the file has."""
        layout, twist = self._layout, plan.has(TWIST[plan.dimension])
        if layout.body.mass is not None:
            layout.body.inertia_matrix(plan.dimension)
        pose = plan.has([*POSITION[plan.dimension], *ORIENTATION[plan.dimension]])
        if layout.filters.twist_window is not None and twist:
            raise InvalidInput(
                "filters.twist_window must be left out where the file has a twist, got "
                f"{layout.filters.twist_window:g}; leave it or the twist (--map vx= …) out"
            )
        if any(sensor.needs_motion() for sensor in self._sensors) and not (twist or pose):
            raise InvalidInput(
                "load.window must be left out where there is neither pose nor twist, got one; "
                "record the motion of the object"
            )
        delay = layout.pose.delay
        if delay and not (twist or pose):
            raise InvalidInput(
                f"pose.delay must be left out where there is neither pose nor twist, got {delay:g}"
                "; leave it out"
            )
        frames = (layout.frame, layout.twist_frame if twist else "", layout.grip_frame)
        if delay and "world" in frames:
            raise InvalidInput(
                f"pose.delay must be left out where something is in the world frame, got {delay:g};"
                " it would be turned by the pose of another time: shift the columns of the pose in "
                "the file"
            )


def _turns(recording: Recording) -> FloatArray:
    """Matrices ``(T, d, d)`` from the object's axes to the world's."""
    assert recording.orientation is not None
    return rotations(recording.orientation, recording.good)
