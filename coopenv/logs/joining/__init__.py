"""Files of several devices as one recording, and gaps between the samples of slower ones."""

from coopenv.logs.joining.opening import open_recording

__all__ = ["open_recording"]
