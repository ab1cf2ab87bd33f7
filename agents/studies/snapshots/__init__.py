"""The paper's snapshots of single wrenches: Figs. 2 to 8 and 17."""
