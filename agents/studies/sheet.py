"""Figure of one trial: quantities in columns over the same time, each with its legend."""

import os
from collections.abc import Sequence

from .figures import Panel, Trial, draw_panel, legend_beside, new_figure, save_figure, share_scale

_LEFT, _PLOT, _LEGEND, _ROW, _TOP, _BOTTOM = 0.85, 2.5, 1.9, 1.4, 0.6, 0.55  # [in]


def draw_sheet(
    trial: Trial,
    columns: Sequence[Sequence[Panel]],
    path: str | os.PathLike,
    *,
    marks: Sequence[float] = (),
) -> None:
    """Draw a trial into a PNG.

    Parameters
    ----------
    trial
        What is drawn; its title stands above everything.
    columns
        Panels from top to bottom, for each column; all of one length.
    path
        Of the picture.
    marks
        Instants at which a thin vertical line is drawn [s].

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    rows, wide = len(columns[0]), _LEFT + _PLOT + _LEGEND
    width, height = wide * len(columns), _TOP + _ROW * rows + _BOTTOM
    figure, grid = new_figure(rows, len(columns), size=(width, height), layout=None)
    for i, panels in enumerate(columns):
        for j, (label, curves_of) in enumerate(panels):
            axes = grid[j, i]
            bottom = height - _TOP - (j + 1) * _ROW + 0.12
            left = i * wide + _LEFT
            place = (left / width, bottom / height, _PLOT / width, (_ROW - 0.18) / height)
            axes.set_position(place)
            draw_panel(axes, trial.time, curves_of(trial), marks)
            share_scale([axes])
            axes.set_ylabel(label)
            legend_beside(axes)
        figure.align_ylabels(grid[:, i])
        grid[-1, i].set_xlabel("time [s]")
    figure.suptitle(trial.title)
    save_figure(figure, path)
