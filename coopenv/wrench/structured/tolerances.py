"""Tolerances of the structured solver, in one table.

None has a unit; what each is relative to stands beside it. J(h) is the cost of the applied wrench.
"Of the sample" means in units in which no force, torque or lever of the sample exceeds 1
(`blocks`). A sine is that of the largest angle between a force and the sum of all forces.
"""

from math import sqrt

# Gaps between the cost of an answer and the bound on the optimum, relative to J(h)
WANTED_GAP = 1e-9  # the iterations stop at this gap
WANTED_GAP_IN_PLANE = 1e-12  # the same in the plane; flat costs turn a gap ε into √ε of the answer
GOOD_GAP = 1e-9  # from this gap on they also stop when the answer hardly improves any more
RETRIED_GAP = 1e-8  # above this gap a second, patient attempt is made
ACCEPTED_GAP = 1e-7  # above this gap another solver is asked; below it is seldom better
TRIFLE = 1e-5  # a saving up to this is taken back if all of it may be rounding

# Gaps of iterates from which answers are made, relative to J(h)
PROMISING_GAP = 1e-6  # where steps are careful
PROMISING_GAP_OF_LONG_STEPS = 1e-7  # where they are not, and the next is likely to go well
DOUBTFUL_GAP = 1e-8  # the last iterate is tried if the answer kept has more than this gap

# When the iterations stop
MAX_ITERATIONS = 80  # of one attempt
MAX_STALLED = 10  # iterations in a row without progress
STALLED = 0.9  # no progress: more than this part of the least residual is left
MAX_IDLE = 2  # iterations in a row by which a good answer improves little
IDLE = 0.3  # little: more than this part of the gap before is left
NO_STEP = 1e-6  # a step is none if both its lengths are no more than this, 1 being all of it

# How far a step goes, in parts of the way to the boundary, and what it aims at
USUAL_ITERATIONS = 16  # from this iteration on steps are careful and refined
CHUNKS_PER_ITERATION = 50  # a sample gets one more usual iteration for so many chunks
REACH = 0.98  # a step goes at least so far
REACH_LOSS = 0.1  # it stops short of all the way by this part of what the predictor leaves of s·z
CAREFUL_REACH, CAREFUL_REACH_LOSS = 0.8, 0.5  # the same for careful steps
PATIENT_REACH = 0.8  # a patient step goes so far
LONGEST_REACH = 0.999  # no step goes farther
PATIENT_CENTRING = 0.1  # a patient step leaves at least this part of s·z
START_PRODUCT = 0.5  # s·z of a ball at the start, in mean costs of a force or torque

# Forces that agree: sines
PARALLEL = 1e-12  # up to this forces count as parallel
CLOSE = 1e-4  # below this the feasible set is so thin that careful steps pay
THIN = 0.05  # below this the answer for parallel forces is tried
LEAST_SINE = 1e-15  # a smaller sine counts as this when multipliers are made from it

# Parts of a wrench that cannot move (`facial_reduction`)
SUSPECT_MULTIPLIER = 10.0  # a multiplier of a ball above this starts a search [J(h) a unit]
SUSPECT_GROWTH = 4.0  # the next search is at so many times the multiplier
SUSPECT_SHARE = 0.03  # parts with at least this share of the largest multiplier are suspected
PROOF_ERROR = 1e-13  # a component of the proof that counts as 0, relative to the largest
PROOF_POSITIVE = 1e-6  # a multiplier of the proof that counts as positive, relative to the largest

# What of a wrench counts
NEGLIGIBLE = 1e-12  # of the sample: forces and torques left as applied, levers that are none
NEGLIGIBLE_DEAR = 1e-14  # the same for torques that cost more than `CHEAP`
CHEAP = 1e-9  # cost of a torque that is left as applied, relative to that of the largest force
RADIAL = 1e-11  # sine of the angle to its lever up to which a force counts as along it

# Pivots
DEAD_PIVOT = 1e-11  # no block makes a resultant whose pivot in Σ G Gᵀ is less of its diagonal
VOID_PIVOT = 1e-26  # the same, relative to the largest of the diagonal
RAISED_PIVOT = 1e-14  # added to the diagonal of M, relative to it
LEAST_PIVOT = 1e-15  # of H, relative to its diagonal

# By how much an answer may miss balance and leave balls
BALANCED = 1e-13  # of the sample: the largest resultant of an internal wrench
BALANCED_PATIENT = 2e-15  # the same after patient iterations
BALANCE_ROUNDING = 1e-15  # a resultant that is not corrected, relative to the largest part of it
EXCESS = 1e-16  # of the sample: a ball may be left by this
LOOSE_EXCESS = 1e-12  # the same as a last resort
LOOSE_GAIN = 10.0 * sqrt(LOOSE_EXCESS)  # what leaving balls by `LOOSE_EXCESS` may save, of J(h)
TORQUE_EXCESS = 1e-10  # a torque may leave its ball by this part of the radius in the end
NO_DIRECTION = 1e-28  # of the sample, squared: an internal part that may point anywhere

# What rounding does
ROUNDING = 4e-16  # error of an inner product, relative to the product of lengths
CANCELLED = 1e-3  # below this part of s_0 z_0 the product s·z is not taken from the components
TORQUE_ROUNDING = 1e-15  # of the sample: torque by which balance may be missed unseen
MULTIPLIER_GROWTH = 4.0  # multipliers may still grow by this factor
DEPTH_LOSS = 4.0  # a set of wrenches may be so much thinner than that of their forces alone
