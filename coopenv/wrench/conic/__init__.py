"""Any number of effectors through a general cone solver: slow, and the oracle for the others."""
