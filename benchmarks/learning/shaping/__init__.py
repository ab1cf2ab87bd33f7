"""The reward-shaping grid: its runs, its tables and its picture."""
