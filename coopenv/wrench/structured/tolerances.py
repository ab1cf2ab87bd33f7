"""Tolerances of the structured solver, in one table.

All are numbers without a unit. What a number is relative to stands beside it: J(h) is the cost of
the applied wrench, "of the sample" is in units in which no force, torque or lever of the sample
exceeds 1 (`blocks`), and a sine is that of the largest angle between a force and the sum of forces.
"""

from math import sqrt

# Gaps between an answer's cost and its bound, relative to J(h)
WANTED_GAP = 1e-9  # at which the iterations stop
WANTED_GAP_IN_PLANE = 1e-12  # the same in the plane: flat costs turn ε into √ε of the answer
GOOD_GAP = 1e-9  # of an answer that need not be better once it hardly improves any more
RETRIED_GAP = 1e-8  # above which a second, patient attempt is made
ACCEPTED_GAP = 1e-7  # above which `conic` is asked as well; below it is seldom better
TRIFLE = 1e-5  # saving that is not called internal if all of it may be rounding

# Which iterates are made answers: their own gap, relative to J(h)
PROMISING_GAP = 1e-6  # of a careful step's
PROMISING_GAP_OF_LONG_STEPS = 1e-7  # of another's, after which the next is likely to go well
DOUBTFUL_GAP = 1e-8  # of the answer kept, above which the last iterate is made one in any case

# When the iterations stop
MAX_ITERATIONS = 80
MAX_STALLED = 10  # iterations in a row without progress
STALLED = 0.9  # residual and s·z, relative to the least before, from which on there is no progress
MAX_IDLE = 2  # iterations in a row that a good answer gains little by
IDLE = 0.3  # gap after an iteration, relative to the gap before, from which on it gained little
NO_STEP = 1e-6  # part of a Newton step that is none

# How far a step goes, in parts of the way to the boundary, and how low it aims
USUAL_ITERATIONS = 16  # from which on steps are careful and refined
CHUNKS_PER_ITERATION = 50  # chunks of a sample for which it gets one usual iteration more
REACH = 0.98  # of a step, at least
REACH_LOSS = 0.1  # what is left of the way, relative to what the predictor leaves of s·z
CAREFUL_REACH, CAREFUL_REACH_LOSS = 0.8, 0.5  # the same of careful steps
PATIENT_REACH = 0.8  # of a patient step
LONGEST_REACH = 0.999  # of any step
PATIENT_CENTRING = 0.1  # what a patient step at least leaves of s·z
START_PRODUCT = 0.5  # s·z of a ball at the start, in mean costs of a force or torque

# Forces that agree: sines
PARALLEL = 1e-12  # up to which forces count as parallel
CLOSE = 1e-4  # below which the feasible set is so thin that careful steps pay
THIN = 0.05  # below which the answer for parallel forces is tried
LEAST_SINE = 1e-15  # that multipliers are made for

# Parts of a wrench that cannot move (`facial_reduction`)
SUSPECT_MULTIPLIER = 10.0  # of a ball or disc, J(h) a unit of the sample, from which on one looks
SUSPECT_GROWTH = 4.0  # of the largest multiplier, after which one looks again
SUSPECT_SHARE = 0.03  # of the largest multiplier, from which on a part is suspected
PROOF_ERROR = 1e-13  # of the proof's equations, relative to the largest multiplier
PROOF_POSITIVE = 1e-6  # a multiplier that is not 0, relative to the largest

# What of a wrench counts
NEGLIGIBLE = 1e-12  # of the sample: a force or torque that is left as applied, a lever that is none
NEGLIGIBLE_DEAR = 1e-14  # the same for torques that cost more than `CHEAP`
CHEAP = 1e-9  # cost of the largest torque left as applied, relative to that of the largest force
RADIAL = 1e-11  # sine of the angle to its lever up to which a force counts as along it

# Pivots
DEAD_PIVOT = 1e-11  # of Σ G Gᵀ, relative to its diagonal: a resultant that cannot be made
VOID_PIVOT = 1e-26  # the same, relative to the largest
RAISED_PIVOT = 1e-14  # added to the diagonal of M, relative to it
LEAST_PIVOT = 1e-15  # of H, relative to its diagonal

# What an answer may miss
BALANCED = 1e-13  # of the sample: largest resultant of what is internal
BALANCED_PATIENT = 2e-15  # the same after patient iterations
BALANCE_ROUNDING = 1e-15  # resultant, relative to the largest part of it, that is not corrected
EXCESS = 1e-16  # of the sample: by how much a ball may be left
LOOSE_EXCESS = 1e-12  # the same as a last resort
LOOSE_GAIN = 10.0 * sqrt(LOOSE_EXCESS)  # what that may save, relative to J(h)
TORQUE_EXCESS = 1e-10  # of its radius: by how much a torque may leave its ball in the end
NO_DIRECTION = 1e-28  # of the sample, squared: an internal part that may point anywhere

# What rounding does
ROUNDING = 4e-16  # of an inner product, relative to the product of lengths
CANCELLED = 1e-3  # s·z, relative to s_0 z_0, below which it is not taken from the components
TORQUE_ROUNDING = 1e-15  # of the sample: torque that an answer may miss without our seeing it
MULTIPLIER_GROWTH = 4.0  # factor by which multipliers may still grow
