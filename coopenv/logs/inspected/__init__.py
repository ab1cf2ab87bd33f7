"""What recorded files hold, which documented column each of theirs could be, and a first layout."""

from coopenv.logs.inspected.beginning import first_layout
from coopenv.logs.inspected.contents import Contents, inspect_file

__all__ = ["Contents", "first_layout", "inspect_file"]
