"""What docstrings and comments of dataclasses say of their fields."""

import inspect
import re

_FIELD = re.compile(r"^    (\w+): [^=\n]+= .*?(?:  # (.*))?$", re.MULTILINE)
_PARAMETERS = re.compile(r"Parameters\n-+\n(.*?)(?=\n\n\w+\n-+\n|\nSource:|\Z)", re.DOTALL)


def prose(text: str) -> str:
    """A docstring's text as Markdown."""
    return text.replace("``", "`").strip()


def unit_of(kind: type, field: str) -> str:
    """What stands in brackets behind a field in its class, or in one below."""
    for each in kind.__mro__:
        if field in vars(each).get("__annotations__", {}):
            comments = dict(_FIELD.findall(inspect.getsource(each)))
            found = re.match(r"\[([^\]]+)\]", comments.get(field, ""))
            return found[1] if found else ""
    return ""


def parameters(kind: type) -> dict[str, str]:
    """What docstring, or else the comment behind a field, says of each."""
    told: dict[str, str] = {}
    for each in reversed(kind.__mro__[:-1]):
        if "__annotations__" not in vars(each):
            continue
        for field, comment in _FIELD.findall(inspect.getsource(each)):
            told[field] = re.sub(r"^\[[^\]]*\][;,]?\s*", "", comment)
        found = _PARAMETERS.search(inspect.getdoc(each) or "")
        entries = re.split(r"^(\S.*)\n", found[1], flags=re.MULTILINE)[1:] if found else []
        for names, text in zip(entries[::2], entries[1::2], strict=True):
            for field in names.split(", "):
                told[field] = prose(re.sub(r"\s+", " ", text))
    return told
