"""Physically plausible wrench decomposition: arrays in, arrays out."""

from coopenv.wrench.decomposition import Decomposer, Decomposition, decompose
from coopenv.wrench.grasp import grasp_matrix, induced_torque, object_wrench
from coopenv.wrench.methods import GENERAL_METHODS, METHODS
from coopenv.wrench.methods.constraint_violation import constraint_violation
from coopenv.wrench.methods.optimal import SOLVERS
from coopenv.wrench.methods.pseudoinverse import allocate
from coopenv.wrench.residuals import Residuals
from coopenv.wrench.settings import Settings
from coopenv.wrench.shares import EnergyShare, LoadShare, energy_share, load_share
from coopenv.wrench.synthesis.synthesize import synthesize

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
    "allocate",
    "constraint_violation",
    "decompose",
    "energy_share",
    "grasp_matrix",
    "induced_torque",
    "load_share",
    "object_wrench",
    "synthesize",
]
