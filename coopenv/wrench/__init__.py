"""Physically plausible wrench decomposition: arrays in, arrays out."""

from coopenv.wrench.decomposition import Decomposer, Decomposition, decompose
from coopenv.wrench.drawing.plot import plot
from coopenv.wrench.grasp import grasp_matrix, induced_torque, object_wrench
from coopenv.wrench.measures import cost
from coopenv.wrench.methods import GENERAL_METHODS, METHODS
from coopenv.wrench.methods.constraint_violation import constraint_violation
from coopenv.wrench.methods.optimal import SOLVERS
from coopenv.wrench.methods.pseudoinverse import allocate
from coopenv.wrench.plausibility import (
    Residuals,
    WorkResiduals,
    is_plausible,
    residuals,
    work_residuals,
)
from coopenv.wrench.settings import Settings
from coopenv.wrench.shares import EnergyShare, LoadShare, energy_share, load_share
from coopenv.wrench.synthesis.synthesize import synthesize
from coopenv.wrench.weight import weight_matters

__all__ = [
    "GENERAL_METHODS",
    "METHODS",
    "SOLVERS",
    "Decomposer",
    "Decomposition",
    "EnergyShare",
    "LoadShare",
    "Residuals",
    "Settings",
    "WorkResiduals",
    "allocate",
    "constraint_violation",
    "cost",
    "decompose",
    "energy_share",
    "grasp_matrix",
    "induced_torque",
    "is_plausible",
    "load_share",
    "object_wrench",
    "plot",
    "residuals",
    "synthesize",
    "weight_matters",
    "work_residuals",
]
