"""One number of a model file changed: lines that differ, here and by ruamel.yaml.

python -m benchmarks.yaml_editing        (needs ruamel.yaml, which the program does not)

Every model file under configs and one laid out by hand get another value of the first
parameter of their first element. One line should differ. ruamel.yaml reads and writes the file
with its round-trip loader, quotes kept and lines never folded.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path

from shakerproc.model_files import change_parameters, read_model_file

CONFIGS = Path(__file__).parents[1] / "configs"
BY_HAND = """\
model: 1
title:   radial coupon, glued joint     # as of May
masses:  {coupon: 28.6 g}
elements:
- {kind: spring,  between: [base, coupon],  stiffness: 1.2e5 N/m}   # from F. 5.2
-   kind: damper                    # a guess
    between:  [base, coupon]
    damping:  1.5 N s/m

excitation: {base: acceleration}
sensors:
    ch3: {at: coupon, measures: acceleration}
    # ch4 broke off
    rel: {at: coupon, measures: relative displacement}
"""


def differing(before: str, after: str) -> int:
    """Return how many lines of a text are not those of the other, place by place."""
    old, new = before.splitlines(), after.splitlines()
    same = sum(a == b for a, b in zip(old, new, strict=False))
    return max(len(old), len(new)) - same


def ours(path: Path) -> str:
    """Return the changed text as the program writes it."""
    element = read_model_file(path).model.elements[0].effect
    name = next(iter(element.parameters))
    out = path.with_suffix(".new")
    change_parameters(path, {0: {name: 1.5 * getattr(element, name)}}, out)
    return out.read_text(encoding="utf-8")


def theirs(path: Path) -> str:
    """Return the changed text as ruamel.yaml writes it."""
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.preserve_quotes, yaml.width = True, 10**6
    document = yaml.load(path)
    first = document["elements"][0]
    name = next(key for key in first if key not in {"kind", "between"})
    first[name] = "1.8e5 N/m"
    told = StringIO()
    yaml.dump(document, told)
    return told.getvalue()


def model_files(folder: Path) -> Iterator[Path]:
    """Yield copies of all model files that can be changed in place."""
    by_hand = folder / "by_hand.yaml"
    by_hand.write_text(BY_HAND, encoding="utf-8")
    yield by_hand
    for i, path in enumerate(sorted(CONFIGS.rglob("*.yaml"))):
        text = path.read_text(encoding="utf-8")
        if text.startswith("model: 1") or "\nmodel: 1" in text:
            copy = folder / f"{i}_{path.name}"
            copy.write_text(text, encoding="utf-8")
            yield copy


def counted(change: Callable[[Path], str], path: Path) -> int | str:
    """Return the lines that a change makes differ, or what it ends in."""
    try:
        return differing(path.read_text(encoding="utf-8"), change(path))
    except Exception as error:  # noqa: BLE001 - any way to fail is a row
        return type(error).__name__


def main() -> None:
    """Print a row for each file, and the time for all."""
    with tempfile.TemporaryDirectory() as name:
        found = list(model_files(Path(name)))
        print("file                            lines  ours  ruamel.yaml")
        for path in found:
            lines = len(path.read_text(encoding="utf-8").splitlines())
            numbers = counted(ours, path), counted(theirs, path)
            print(f"{path.name:30} {lines:6} {numbers[0]!s:>5} {numbers[1]!s:>12}")
        for change in (ours, theirs):
            begun = time.process_time()
            for path in found:
                counted(change, path)
            spent = time.process_time() - begun
            print(f"{change.__name__}: {1e3 * spent / len(found):.1f} ms a file")


if __name__ == "__main__":
    main()
