"""Colours (after Okabe & Ito) and names of what a picture of a split shows."""

from typing import NamedTuple


class Look(NamedTuple):
    """How one kind of arrow is filled, edged and named."""

    name: str
    face: str
    edge: str
    width: float  # of the shaft, relative to the object's size


GREY, BLACK, BLUE, SKY, VERMILION, GREEN, PURPLE = (
    "#D0D0D0", "#333333", "#0072B2", "#56B4E9", "#D55E00", "#009E73", "#CC79A7",
)  # fmt: skip
APPLIED = Look("applied h", GREY, "#777777", 0.034)
MANIPULATION = Look("manipulation h_M", BLUE, BLUE, 0.014)
INTERNAL = Look("internal h_I", "white", VERMILION, 0.014)  # hollow: told from blue without colour
OBJECT_WRENCH = Look("object's h_o = G h", GREEN, GREEN, 0.010)
BALL = "disc of eq. 9"
BAND = "in the band of eq. 10 too"
FEASIBLE = "what is feasible"
