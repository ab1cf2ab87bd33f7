"""Pictures of a split: object, grips, arrows, arcs, and where plausible answers lie."""
