"""Any number of effectors, in time linear in their number: our own interior-point method."""
