"""Cone programs for Clarabel: min qᵀx subject to b − A x in a product of cones, piece by piece."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import clarabel as compiled_clarabel
import numpy as np

from coopenv.arrays import FloatArray

clarabel: Any = compiled_clarabel  # it has no type stubs


class Affine(NamedTuple):
    """A vector of the program, ``block @ x[columns] + offset``."""

    columns: list[int]
    block: FloatArray  # (d, len(columns))
    offset: FloatArray  # (d,)

    def mapped(self, matrix: FloatArray) -> "Affine":
        """Return ``matrix`` times this vector."""
        return Affine(self.columns, matrix @ self.block, matrix @ self.offset)

    def value(self, x: FloatArray) -> FloatArray:
        """Return the vector at a solution."""
        return self.block @ x[self.columns] + self.offset


class ConeProgram:
    """Collects variables, costs and constraints on affine vectors.

    Parameters
    ----------
    cost_unit
        The objective is the sum of the costs divided by this.
    """

    def __init__(self, cost_unit: float):
        self.cost_unit = cost_unit
        self._cost: list[float] = []
        self._cones: list[Any] = []
        self._right: list[FloatArray] = []
        self._rows: list[int] = []
        self._columns: list[int] = []
        self._entries: list[FloatArray] = []
        self._num_rows = 0
        self._kept: list[tuple[FloatArray, slice, FloatArray | float]] = []

    def variables(self, count: int, cost: float = 0.0) -> list[int]:
        """Add ``count`` variables of the same cost; return their columns."""
        first = len(self._cost)
        self._cost += [cost] * count
        return list(range(first, first + count))

    def zero(self, *vectors: Affine) -> slice:
        """Require that the vectors sum to 0; return the rows of that."""
        size = len(vectors[0].offset)
        for vector in vectors:
            self._place(vector.columns, -vector.block)
        return self._close(clarabel.ZeroConeT, size, sum(vector.offset for vector in vectors))

    def between(self, scalar: Affine, bound: float) -> slice:
        """Require that a vector of length 1 lies between 0 and ``bound``; return the rows."""
        sign = np.array([[1.0], [-1.0]]) * np.sign(bound)
        self._place(scalar.columns, -sign @ scalar.block)
        right = sign @ scalar.offset + np.array([0.0, abs(bound)])
        return self._close(clarabel.NonnegativeConeT, 2, right)

    def ball(self, vector: Affine, centre: FloatArray, radius: float) -> slice:
        """Require ‖vector − centre‖ ≤ radius; return the rows of the vector."""
        size = len(vector.offset)
        self._place(vector.columns, -np.vstack([np.zeros(len(vector.columns)), vector.block]))
        right = np.concatenate([[radius], vector.offset - centre])
        rows = self._close(clarabel.SecondOrderConeT, size + 1, right)
        return slice(rows.start + 1, rows.stop)

    def norm(self, vector: Affine, cost: float) -> slice:
        """Add ``cost`` times ‖vector‖ to the objective; return the rows of the vector."""
        (epigraph,) = self.variables(1, cost)
        size = len(vector.offset)
        block = np.zeros((size + 1, len(vector.columns) + 1))
        block[0, -1] = 1.0
        block[1:, :-1] = vector.block
        self._place([*vector.columns, epigraph], -block)
        right = np.concatenate([[0.0], vector.offset])
        rows = self._close(clarabel.SecondOrderConeT, size + 1, right)
        return slice(rows.start + 1, rows.stop)

    def absolute(self, scalar: Affine, sign: float, cost: float) -> None:
        """Add ``cost`` times |scalar| to the objective, for a scalar whose sign is known."""
        for column, factor in zip(scalar.columns, scalar.block[0], strict=True):
            self._cost[column] += cost * sign * factor

    def keep(self, target: FloatArray, rows: slice, factor: FloatArray | float) -> None:
        """Have `write_multipliers` set ``target`` to the rows' multipliers times ``factor``."""
        self._kept.append((target, rows, factor))

    def write_multipliers(self, solution: Any) -> None:
        """Write what is wanted of the dual solution, in units of cost per unit of the vectors."""
        multipliers = self.cost_unit * np.array(solution.z)
        for target, rows, factor in self._kept:
            own = multipliers[rows]
            target[:] = factor @ own if np.ndim(factor) == 2 else factor * own

    def solve(self, tolerance: float, equilibrate: bool) -> Any:
        """Run Clarabel and return its solution, however far it came.

        Parameters
        ----------
        tolerance
            On feasibility and gap, in the units of the program.
        equilibrate
            Whether Clarabel chooses units of its own.
        """
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_threads = 1
        settings.equilibrate_enable = equilibrate
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        shape = (self._num_rows, len(self._cost))
        matrix, nothing = self._matrix(shape), _no_quadratic_cost(shape[1])
        cost, right = np.array(self._cost) / self.cost_unit, np.concatenate(self._right)
        return clarabel.DefaultSolver(nothing, cost, matrix, right, self._cones, settings).solve()

    def _matrix(self, shape: tuple[int, int]) -> Any:
        """Return A; its columns are put together here, as SciPy takes longer."""
        rows, columns = np.array(self._rows), np.array(self._columns)
        order = np.lexsort((rows, columns))
        starts = np.zeros(shape[1] + 1, dtype=np.int32)
        np.cumsum(np.bincount(columns, minlength=shape[1]), out=starts[1:])
        entries = np.concatenate(self._entries)[order]
        return _csc_matrix((entries, rows[order], starts), shape)

    def _place(self, columns: list[int], block: FloatArray) -> None:
        for row in range(self._num_rows, self._num_rows + len(block)):
            self._rows += [row] * len(columns)
            self._columns += columns
        self._entries.append(block.ravel())

    def _close(self, cone: Callable[[int], Any], size: int, right: Any) -> slice:
        self._cones.append(cone(size))
        self._right.append(np.asarray(right, dtype=np.float64))
        self._num_rows += size
        return slice(self._num_rows - size, self._num_rows)


@lru_cache(maxsize=32)
def _no_quadratic_cost(num_variables: int) -> Any:
    return _csc_matrix((num_variables, num_variables))


def _csc_matrix(*arguments: Any) -> Any:
    from scipy import sparse  # takes as long to import as half of this package

    return sparse.csc_matrix(*arguments)
