"""Changes of expressions: arithmetic, comparisons, conditions, numbers, indices, arguments."""

import ast
from collections.abc import Iterator

from benchmarks.mutants.source import Source

Edit = tuple[str, int, int, str]  # operator, start, end, new text

ARITHMETIC: dict[type, tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
    ast.BitXor: ("^", "&"),
    ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
}
COMPARISON: dict[type, tuple[str, tuple[str, ...]]] = {
    ast.Lt: ("<", ("<=", ">=")),
    ast.LtE: ("<=", ("<", ">")),
    ast.Gt: (">", (">=", "<=")),
    ast.GtE: (">=", (">", "<")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
    ast.Is: ("is", ("is not",)),
    ast.IsNot: ("is not", ("is",)),
    ast.In: ("in", ("not in",)),
    ast.NotIn: ("not in", ("in",)),
}
TWINS = {
    name: other
    for pair in (
        ("min", "max"),
        ("minimum", "maximum"),
        ("fmin", "fmax"),
        ("nanmin", "nanmax"),
        ("argmin", "argmax"),
        ("any", "all"),
        ("sin", "cos"),
        ("floor", "ceil"),
        ("zeros", "ones"),
        ("zeros_like", "ones_like"),
        ("rotated", "rotated_back"),
        ("logical_and", "logical_or"),
        ("append", "extend"),
    )
    for name, other in (pair, pair[::-1])
}
SYMMETRIC = {  # or refused at once where the arguments change places
    *("add", "allclose", "array_equal", "dot", "fmax", "fmin", "hypot", "isclose", "logical_and"),
    *("logical_or", "max", "maximum", "min", "minimum", "multiply", "print"),
    *("cast", "getattr", "hasattr", "isinstance", "issubclass", "setattr"),
}
TINY = 1e-6  # a number as small is a tolerance: it changes by three orders of magnitude


def edits(source: Source, node: ast.AST, role: str) -> Iterator[Edit]:
    """All changes of a node itself, not of what is in it. ``role`` says what a number is."""
    match node:
        case ast.BinOp():
            yield from _arithmetic(source, node)
        case ast.AugAssign() if type(node.op) in ARITHMETIC:
            old, new = ARITHMETIC[type(node.op)]
            span = source.between(node.target, node.value, (old + "=",))
            yield "arithmetic", *span, new + "="
        case ast.Compare():
            yield from _comparison(source, node)
        case ast.BoolOp():
            old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                yield "and, or", *source.between(left, right, (old,)), new
        case ast.UnaryOp(op=ast.Not()):
            yield "condition", *source.span(node), f"({source.of(node.operand)})"
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as value)):
            for text in _numbers(-value, role):
                yield _kind(role), *source.span(node), text
        case ast.UnaryOp(op=ast.USub()):
            start, _ = source.span(node)
            yield "sign", start, source.span(node.operand)[0], ""
        case ast.Constant(value=bool() as value):
            yield _kind(role), *source.span(node), str(not value)
        case ast.Constant(value=int() | float() as value):
            for text in _numbers(value, role):
                yield _kind(role), *source.span(node), text
        case ast.Constant(value=str() as value) if role in ("default", "compared", "index"):
            yield _kind(role), *source.span(node), repr(value + "_")
        case ast.Slice():
            for bound in filter(None, (node.lower, node.upper)):
                yield "slice", *source.span(bound), ""
        case ast.If() | ast.IfExp():
            yield from _condition(source, node.test, ("not", "True", "False"))
        case ast.While() if not isinstance(node.test, ast.Constant):
            yield from _condition(source, node.test, ("not",))
        case ast.comprehension():
            for test in node.ifs:
                yield from _condition(source, test, ("not", "True"))
        case ast.Call():
            yield from _call(source, node)


def _arithmetic(source: Source, node: ast.BinOp) -> Iterator[Edit]:
    sides = (node.left, node.right)
    if any(_is_text(side) for side in sides) or type(node.op) not in ARITHMETIC:
        return
    old, new = ARITHMETIC[type(node.op)]
    yield "arithmetic", *source.between(*sides, (old,)), new


def _is_text(node: ast.AST) -> bool:
    """Whether text is joined here, or a union of types made."""
    if isinstance(node, ast.BinOp):
        return _is_text(node.left) or _is_text(node.right)
    types = ("int", "float", "str", "bool", "bytes", "tuple", "list", "dict", "Path", "None")
    return (
        isinstance(node, ast.JoinedStr)
        or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes | None))
        or (isinstance(node, ast.Name) and node.id in types)
    )


def _comparison(source: Source, node: ast.Compare) -> Iterator[Edit]:
    operands = [node.left, *node.comparators]
    for left, right, operator in zip(operands, operands[1:], node.ops, strict=False):
        old, replaced = COMPARISON[type(operator)]
        for new in replaced:
            yield "comparison", *source.between(left, right, old.split()), new


def _condition(source: Source, test: ast.expr, ways: tuple[str, ...]) -> Iterator[Edit]:
    start, end = source.span(test)
    for way in ways:
        if way != "not":
            yield "condition", start, end, way
        elif not (isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not)):
            simple = not isinstance(test, ast.Compare) or len(test.ops) > 1
            if simple:  # a comparison is negated by its own operator
                yield "condition", start, end, f"(not ({source.of(test)}))"


def _kind(role: str) -> str:
    return {"index": "index", "axis": "axis", "default": "default"}.get(role, "constant")


def _numbers(value: float, role: str) -> list[str]:
    """What stands for a number instead."""
    if isinstance(value, int):
        others = [value + 1, value - 1] if value else [1]
        if role == "index" and value == 0:
            others = [1, -1]
        if role == "shape" and value == -1:  # NumPy takes any negative length as the rest
            others = [1]
    elif value == 0.0:
        others = [1.0]
    elif abs(value) < TINY:
        others = [float(f"{1e3 * value:.6g}"), float(f"{1e-3 * value:.6g}")]
    else:
        others = [2.0 * value, -value]
    return [repr(other) if other >= 0 else f"({other!r})" for other in others if other == other]


def _call(source: Source, node: ast.Call) -> Iterator[Edit]:
    name = node.func
    word = name.id if isinstance(name, ast.Name) else getattr(name, "attr", "")
    if word in TWINS:
        end = source.span(name)[1]
        yield "twin", end - len(word.encode()), end, TWINS[word]
    if len(node.args) > 1 and word not in SYMMETRIC:
        first, second = node.args[:2]
        starred = isinstance(first, ast.Starred) or isinstance(second, ast.Starred)
        if not starred and ast.dump(first) != ast.dump(second):
            (start, middle), (other, end) = source.span(first), source.span(second)
            gap = source.text[middle:other].decode()
            yield "swapped", start, end, source.of(second) + gap + source.of(first)
    if node.args and word[:1].islower():
        for keyword in node.keywords:
            if keyword.arg and keyword.arg != "strict":
                yield from _dropped(source, node, keyword)


def _dropped(source: Source, node: ast.Call, keyword: ast.keyword) -> Iterator[Edit]:
    """A keyword left out, with the comma before it."""
    start, end = source.span(keyword)
    before = source.tokens[source.token_at(start) - 1]
    if before.text == "," and before.start >= source.span(node)[0]:
        yield "keyword", before.start, end, ""
