"""Soak test of everything at once: random trials for an hour, a table, and what broke.

    python -m benchmarks.soak                            # an hour; after a kill the same goes on
    python -m benchmarks.soak --only actions --seed 12   # one trial, with its traceback
    python -m benchmarks.soak --again                    # begins with what failed, now mended
    python -m benchmarks.soak --write                    # and the table into docs/reliability.md

Failures are told as they come, each with the command that meets it again.
"""

if __name__ == "__main__":  # workers import this module too, and need no more than their campaign
    from benchmarks.soak.command import main

    main()
