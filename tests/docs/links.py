"""Links and pictures of a page that lead nowhere."""

import re
from pathlib import Path

_LINK = re.compile(r"\]\(([^)#\s:]*)#?([^)\s:]*)\)|<img src=\"([^\"]*)\"")


def broken(page: Path) -> list[str]:
    """Targets in files of this repository that do not exist, with their anchors."""
    found = []
    for link, anchor, picture in _LINK.findall(page.read_text(encoding="utf-8")):
        path = link or picture
        to = page.parent / path if path else page
        if not to.exists():
            found.append(path)
        elif anchor and anchor not in anchors(to):
            found.append(f"{path}#{anchor}")
    return found


def anchors(page: Path) -> list[str]:
    """What titles are called where they are linked to."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    kept = [re.sub(r"[^\w\- ]", "", title.lower()) for title in titles]
    return [title.replace(" ", "-") for title in kept]
