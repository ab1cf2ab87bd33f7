"""Frame of the soak test: workers, their runner, the ledger it goes on from, and the report."""
