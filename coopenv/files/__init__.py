"""Files: written whole or not at all, trouble as sentences, locks, left-overs of dead processes."""

from coopenv.files.checks import require_file, require_folder, require_writable
from coopenv.files.document import document, plain
from coopenv.files.ending import nothing_left
from coopenv.files.lock import LOCK, locked
from coopenv.files.temporary import sweep
from coopenv.files.trouble import file_trouble, reading, writing
from coopenv.files.whole import written

__all__ = [
    "LOCK",
    "document",
    "file_trouble",
    "locked",
    "nothing_left",
    "plain",
    "reading",
    "require_file",
    "require_folder",
    "require_writable",
    "sweep",
    "writing",
    "written",
]
