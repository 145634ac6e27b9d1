"""Run every benchmark: each module of this folder that has a `main`."""

import importlib
import pkgutil
import sys

import benchmarks


def main() -> None:
    """Run the modules named on the command line, or all, each under its name."""
    wanted = set(sys.argv[1:])
    for module in pkgutil.iter_modules(benchmarks.__path__):
        if module.name.startswith("_") or (wanted and module.name not in wanted):
            continue
        loaded = importlib.import_module(f"benchmarks.{module.name}")
        if hasattr(loaded, "main"):
            print(f"\n== benchmarks.{module.name}: {(loaded.__doc__ or '').splitlines()[0]}")
            sys.argv = [module.name]
            loaded.main()


if __name__ == "__main__":
    main()
