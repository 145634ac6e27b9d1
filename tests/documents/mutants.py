"""``python -m tests.documents.mutants [N]``: logs, models and studies with one thing changed.

Each is read, or refused in one line whose line and column lie in the file; a value that is left
blank is refused at its line. Prints how many there are of each kind and what became of them.
"""

import random
import re
import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path

from tests.testlog.test_mistakes import GOOD

from shakerproc.errors import DocumentError, ShakerprocError
from shakerproc.model_files import read_model
from shakerproc.studies import read_study
from shakerproc.testlog import read_testlog

CONFIGS = Path(__file__).parents[2] / "configs"
SEED = 39
PIECES = (
    "\t", "\u2028", "\u2029", "\x85", "\x00", "\x07", "\ufeff", "\u00a0", " #", ": ", "- ", "{",
    "}", "[", "]", "'", '"', "&a ", "*a", "!!int ", "|", ">", "%", "@", "`", "\\", "?", "~",
    "\n", "null", "nan", "1e999", "-1", "0", "1e-320", "999999999999999999999", "\U0001f600",
)  # fmt: skip
VALUE = re.compile(r"(?<=[a-z_]: )(?![\s{\[&|>])([^,}\]\n#]+?)(?=[ \t]*(?:[,}\]\n#]|$))", re.M)


def sources():
    """Texts, what reads each, and where it lies."""
    yield GOOD, read_testlog, "log.yaml"
    yield (CONFIGS / "all_keys.yaml").read_text(encoding="utf-8"), read_testlog, "log.yaml"
    for path in sorted((CONFIGS / "studies" / "models").glob("*.yaml")):
        yield path.read_text(encoding="utf-8"), read_model, "model.yaml"
    for path in sorted((CONFIGS / "studies").glob("*.yaml")):
        yield path.read_text(encoding="utf-8"), read_study, "study.yaml"


def blank(text, rng):
    """A value left out, with its line; None where there is none."""
    written = [m for m in VALUE.finditer(text) if "#" not in _before(text, m.start())]
    found = rng.choice(written)
    return text[: found.start()] + text[found.end() :], text.count("\n", 0, found.start()) + 1


def _before(text, at):
    return text[text.rfind("\n", 0, at) + 1 : at]


def insert(text, rng):
    at = rng.randrange(len(text))
    return text[:at] + rng.choice(PIECES) + text[at:], None


def delete(text, rng):
    at = rng.randrange(len(text))
    return text[:at] + text[at + rng.choice((1, 1, 1, 3, 10)) :], None


def lines(text, rng):
    rows = text.split("\n")
    i, j = rng.randrange(len(rows)), rng.randrange(len(rows))
    if rng.random() < 0.5:
        rows[i], rows[j] = rows[j], rows[i]
    else:
        rows.insert(j, rows[i])
    return "\n".join(rows), None


def value(text, rng):
    found = rng.choice(list(VALUE.finditer(text)))
    return text[: found.start()] + rng.choice(PIECES) + text[found.end() :], None


def cut(text, rng):
    return text[: rng.randrange(len(text))], None


KINDS = (blank, insert, delete, lines, value, cut)


def outcome(path, read, text, line):
    """What becomes of a mutant: ``read``, ``refused``, or what is wrong with the refusal."""
    path.write_text(text, encoding="utf-8", newline="")
    try:
        read(path)
    except DocumentError as error:
        message = str(error)
        rows = re.split(r"\r\n|\r|\n", text)
        inside = 1 <= error.line <= len(rows) and 1 <= error.column <= (
            len(rows[error.line - 1]) + 2
        )
        if not message.isprintable() or not inside:
            return f"no place: {message}"
        if line is not None and error.line != line and "more below" not in message:
            return f"line {line} was left blank: {message}"
        return "refused"
    except ShakerprocError as error:
        return "refused" if str(error).isprintable() else f"not one line: {error}"
    except Exception as error:  # noqa: BLE001 - what is looked for
        return f"traceback: {type(error).__name__}: {error}"
    return "read" if line is None else f"line {line} was left blank, and it is read"


def campaign(n, folder, seed=SEED):
    """Counts of each outcome, and every outcome that is wrong, with its mutant."""
    rng = random.Random(seed)
    texts = list(sources())
    for path in (CONFIGS / "studies" / "models").glob("*.yaml"):
        (folder / "models").mkdir(exist_ok=True)
        (folder / "models" / path.name).write_bytes(path.read_bytes())
    found, wrong = Counter(), []
    for number in range(n):
        text, read, name = rng.choice(texts)
        kind = KINDS[number % len(KINDS)]
        mutant, line = kind(text, rng)
        what = outcome(folder / name, read, mutant, line)
        found[kind.__name__, what if what in {"read", "refused"} else "wrong"] += 1
        if what not in {"read", "refused"}:
            wrong.append((number, kind.__name__, name, what, mutant))
    return found, wrong


def main():
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 5000
    with tempfile.TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("error")
        found, wrong = campaign(n, Path(name))
    for (kind, what), count in sorted(found.items()):
        sys.stdout.write(f"{kind:8} {what:8} {count}\n")
    for number, kind, file, what, mutant in wrong[:20]:
        sys.stdout.write(f"{number} {kind} {file}: {what[:300]}\n")
        (Path(tempfile.gettempdir()) / f"mutant_{number}.yaml").write_text(mutant, "utf-8")
    sys.stdout.write(f"{n} mutants, {len(wrong)} wrong\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
