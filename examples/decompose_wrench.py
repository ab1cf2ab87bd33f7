"""Which part of what two people push on a beam moves it, and which part fights the partner?"""

import numpy as np

from coopenv import wrench

grips = np.array([(-0.9, 0.0), (0.9, 0.0)])  # object frame [m]
applied = np.array(
    [
        # agent 1: fx, fy [N], tz [N·m]    agent 2
        [(3.0, 0.0, 0.0), (-1.0, 0.0, 0.0)],  # 2 holds back
        [(2.0, 0.0, 0.0), (0.0, 0.0, 0.0)],  # 1 does it alone: unequal, but no fight
        [(0.0, -0.7, 0.0), (0.0, 0.7, 0.0)],  # a couple that turns the beam
        [(5.0, 0.0, 0.0), (-5.0, 0.0, 0.0)],  # squeezing: all of it is internal
        [(4.0, 3.0, 1.0), (-2.0, 3.0, -2.0)],
    ]
)

split = wrench.decompose(applied, grips)
share = wrench.load_share(applied, grips)
print("applied 1, 2                             internal force 1       F_I    T_I  gamma  share 1")
for k in range(len(applied)):
    print(
        f"{applied[k, 0]} {applied[k, 1]!s:20}",
        f"({split.internal[k, 0, 0]:5.2f}, {split.internal[k, 0, 1]:5.2f}) N",
        f"{split.internal_force_level[k]:8.2f} {split.internal_torque_level[k]:6.2f}",
        f"{split.relative_cost[k]:6.2f} {share.force[k, 0]:8.2f}",
    )

print("largest residual:", max(float(part.max()) for part in split.residuals()))
for method in wrench.GENERAL_METHODS:
    other = wrench.decompose(applied, grips, method=method)
    print(f"{method:>16}: F_I = {np.round(other.internal_force_level, 3)}")
