"""Calibration of recordings: corrections as pure functions on arrays, and how layouts say them."""

from coopenv.logs.calibration.body import Body
from coopenv.logs.calibration.differentiation import acceleration, twist_from_pose
from coopenv.logs.calibration.filters import low_pass
from coopenv.logs.calibration.load import Load, load_wrench
from coopenv.logs.calibration.mounting import moved, turned, uncoupled
from coopenv.logs.calibration.orientation import heading, quaternions
from coopenv.logs.calibration.processing import Filters, Pose
from coopenv.logs.calibration.resampling import resampled, resampled_orientation
from coopenv.logs.calibration.sensor import Sensor
from coopenv.logs.calibration.tare import drift, tared

__all__ = [
    "Body",
    "Filters",
    "Load",
    "Pose",
    "Sensor",
    "acceleration",
    "drift",
    "heading",
    "load_wrench",
    "low_pass",
    "moved",
    "quaternions",
    "resampled",
    "resampled_orientation",
    "tared",
    "turned",
    "twist_from_pose",
    "uncoupled",
]
