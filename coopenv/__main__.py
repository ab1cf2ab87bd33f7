"""``python -m coopenv``: the command line, without its installed command."""

import sys

from coopenv.cli import main

if __name__ == "__main__":
    sys.exit(main())
