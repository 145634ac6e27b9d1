"""How the code is built: lengths, parameters, complexity, and what is documented with units.

python -m benchmarks.house [--source src/shakerproc] [--longest 5] [--undocumented]

Code lines of a function are those that hold code: no docstring, comment or empty line.
Complexity is that of McCabe. Compiled kernels (decorated for the compiler, or in a file of
kernels or of their laws) are counted on their own, and so are commands, whose parameters are
their options: of these the lines without the options are counted as well. A quantity is a
parameter that is annotated as a float or an array of them; a public function documents it where
its docstring names it and gives a unit in brackets, `[Hz]`, `[-]` for none, or, in a docstring
without an entry for it, gives a unit in its sentences. What overrides is documented where it is
declared.
"""

import argparse
import ast
import re
import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

NUMBER = re.compile(r"\b(float|FloatArray|ComplexArray|NDArray(?!\[np\.(bool_|u?int\w*)\]))\b")
COMPILED = re.compile(r"\b(n?jit|vectorize|compiled|kernel)\b")
UNIT = re.compile(r"\[[^\]\n]{1,40}\]|\bunits?\b")
BRANCHES = (
    ast.If, ast.For, ast.While, ast.ExceptHandler, ast.With, ast.IfExp, ast.comprehension,
    ast.Assert, ast.match_case,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Function:
    """A function of the source: where it is, and what is counted of it."""

    where: str
    lines: int
    body: int
    parameters: int
    complexity: int
    kind: str
    public: bool
    documented: bool
    quantities: tuple[str, ...]
    with_units: bool


Declared = dict[str, tuple[list[str], dict[str, str]]]
"""The bases of each class, and the docstrings of its methods; namesakes are taken together."""


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def classes_of(paths: Sequence[Path]) -> Declared:
    """Return what the classes of all files declare, by their names."""
    found: Declared = {}
    for path in paths:
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.ClassDef):
                methods = {
                    one.name: ast.get_docstring(one) or ""
                    for one in node.body
                    if isinstance(one, ast.FunctionDef)
                }
                bases = [ast.unparse(base).partition("[")[0] for base in node.bases]
                earlier = found.get(node.name, ([], {}))
                found[node.name] = ([*earlier[0], *bases], {**earlier[1], **methods})
    return found


def declared(owner: str, name: str, classes: Declared) -> str:
    """Return the docstring of the method that a method overrides; empty where it has none."""
    for base in classes.get(owner, ([], {}))[0]:
        told = classes.get(base, ([], {}))[1].get(name) or declared(base, name, classes)
        if told:
            return told
    return ""


def house(source: Path) -> tuple[list[Path], list[Function]]:
    """Return all files of a package, and their functions."""
    paths = sorted(source.rglob("*.py"))
    classes = classes_of(paths)
    return paths, [one for path in paths for one in functions_of(path, source, classes)]


def functions_of(path: Path, root: Path, classes: Declared) -> Iterator[Function]:
    """Yield the functions of a file, methods and inner functions too."""
    source = path.read_text(encoding="utf-8")
    tree = parsed(path)
    held = code_lines(source, tree)
    place = path.relative_to(root)

    def walk(node: ast.AST, owner: str, *, public: bool, inner: bool) -> Iterator[Function]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):  # neither class nor function stands in one
                continue
            if isinstance(child, ast.ClassDef):
                name = f"{owner}{child.name}."
                seen = public and not child.name.startswith("_")
                yield from walk(child, name, public=seen, inner=inner)
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                seen = public and not inner and not child.name.startswith("_")
                told = declared(owner.rstrip("."), child.name, classes)
                yield counted(child, f"{place}:{owner}{child.name}", held, told, public=seen)
                yield from walk(child, f"{owner}{child.name}.", public=False, inner=True)
            else:
                yield from walk(child, owner, public=public, inner=inner)

    yield from walk(tree, "", public=True, inner=False)


def code_lines(text: str, tree: ast.Module) -> set[int]:
    """Return the numbers of the lines that hold code: all of a string does."""
    held = {
        number
        for number, line in enumerate(text.split("\n"), 1)
        if (code := line.strip()) and not code.startswith("#")
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant | ast.JoinedStr) and node.end_lineno != node.lineno:
            held.update(range(node.lineno, node.end_lineno + 1))
    return held


def counted(
    node: ast.FunctionDef | ast.AsyncFunctionDef,
    where: str,
    held: set[int],
    told: str,
    *,
    public: bool,
) -> Function:
    """Return what is counted of a function; `told` is the docstring of what it overrides."""
    text = f"{ast.get_docstring(node) or ''}\n\n{told}".strip()
    lines = held & set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    if ast.get_docstring(node):
        own = node.body[0]
        lines -= set(range(own.lineno, (own.end_lineno or own.lineno) + 1))
    given = [
        *node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs,
        *filter(None, (node.args.vararg, node.args.kwarg)),
    ]  # fmt: skip
    given = [one for one in given if one.arg not in {"self", "cls"}]
    quantities = tuple(one.arg for one in given if is_quantity(one))
    marks = " ".join(ast.unparse(one) for one in node.decorator_list)
    place = where.partition(":")[0]
    return Function(
        where,
        len(lines),
        len(lines & set(range(node.body[0].lineno, (node.end_lineno or node.lineno) + 1))),
        len(given),
        complexity_of(node),
        kind_of(place, given, marks),
        public and not place.startswith(("cli", "_")),
        bool(text),
        quantities,
        all(has_unit(text, name) for name in quantities),
    )


def kind_of(place: str, given: Sequence[ast.arg], marks: str) -> str:
    """Return whether a function is compiled, a command or a plain one."""
    if COMPILED.search(marks) or "kernels" in place or "simulation/laws" in place:
        return "compiled"
    shown = " ".join(written(one.annotation) for one in given if one.annotation)
    return "command" if "typer." in shown or "Option" in shown else "plain"


def is_quantity(one: ast.arg) -> bool:
    """Return whether a parameter is a number that may have a unit."""
    return one.annotation is not None and bool(NUMBER.search(written(one.annotation)))


@cache
def written(annotation: ast.expr) -> str:
    """Return an annotation as it is written."""
    return ast.unparse(annotation)


def complexity_of(node: ast.AST) -> int:
    """Return McCabe's number: one more than the places where the way forks."""
    return 1 + sum(
        len(one.values) - 1 if isinstance(one, ast.BoolOp) else isinstance(one, BRANCHES)
        for one in ast.walk(node)
    )


def has_unit(text: str, name: str) -> bool:
    """Return whether a docstring gives the unit of a parameter."""
    section = re.search(r"Parameters\n-+\n(.*?)(\n\n\w+\n-+|\Z)", text, re.DOTALL)
    if section:
        entries = re.split(r"\n(?=\S)", section[1])
        for entry in entries:
            head = entry.partition("\n")[0].partition(" : ")[0]
            if name in {part.strip(" *") for part in head.split(",")}:
                return bool(UNIT.search(entry))
    return bool(UNIT.search(text.partition("Returns\n-")[0]))


def spread(what: str, values: Sequence[int]) -> str:
    """Return the median and the maximum of numbers, as a line."""
    return f"{what:40s} median {statistics.median(values):6.1f}   maximum {max(values):5d}"


def share(what: str, parts: Sequence[bool]) -> str:
    """Return how many of several hold, as a line."""
    return f"{what:40s} {sum(parts):5d} of {len(parts):5d}   {sum(parts) / len(parts):6.1%}"


def main() -> None:
    """Print the numbers."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--source", type=Path, default=Path("src/shakerproc"))
    parser.add_argument("--longest", type=int, default=5, help="how many to name")
    parser.add_argument("--undocumented", action="store_true", help="name those without units")
    options = parser.parse_args()
    paths, found = house(options.source)
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in paths}
    plain = [one for one in found if one.kind == "plain"]
    print(f"{len(paths)} files, {len(found)} functions")
    print(spread("lines of a file", list(lengths.values())))
    for kind in ("plain", "compiled", "command"):
        some = [one for one in found if one.kind == kind]
        print(spread(f"{kind}: code lines", [one.lines for one in some]))
        print(spread(f"{kind}: parameters", [one.parameters for one in some]))
        print(spread(f"{kind}: complexity", [one.complexity for one in some]))
    bodies = [one.body for one in found if one.kind == "command"]
    print(spread("command: code lines without options", bodies))
    print(f"{'files above 300 lines':40s} {sum(n > 300 for n in lengths.values()):5d}")
    print(f"{'plain: above 60 code lines':40s} {sum(f.lines > 60 for f in plain):5d}")
    print(f"{'plain: more than 8 parameters':40s} {sum(f.parameters > 8 for f in plain):5d}")
    public = [one for one in plain if one.public]
    taking = [one for one in public if one.quantities]
    print(share("public functions with a docstring", [one.documented for one in public]))
    print(share("of those with quantities: all with units", [one.with_units for one in taking]))
    for path in sorted(lengths, key=lengths.__getitem__, reverse=True)[: options.longest]:
        print(f"  {lengths[path]:4d} lines: {path.relative_to(options.source)}")
    name_longest(plain, options.longest)
    if options.undocumented:
        for one in taking:
            if not one.with_units:
                print(f"  no unit: {one.where} ({', '.join(one.quantities)})")


def name_longest(functions: Sequence[Function], count: int) -> None:
    """Print which functions are longest, and which have the most parameters."""
    for one in sorted(functions, key=lambda one: one.lines, reverse=True)[:count]:
        print(f"  {one.lines:4d} code lines: {one.where}")
    for one in sorted(functions, key=lambda one: one.parameters, reverse=True)[:count]:
        print(f"  {one.parameters:4d} parameters: {one.where}")
    for one in sorted(functions, key=lambda one: one.complexity, reverse=True)[:count]:
        print(f"  complexity {one.complexity}: {one.where}")


if __name__ == "__main__":
    main()
