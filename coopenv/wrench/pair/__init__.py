"""Two effectors in the plane: exact solvers that search one number."""
