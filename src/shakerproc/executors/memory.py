"""A limit on the memory of this process, where Linux can."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def limit_memory(limit: int) -> tuple[int, int] | None:
    """Let allocations fail that would take more than `limit` bytes from now on.

    Returns the limits as they were; None where the system has none.
    """
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    import resource

    used = next(
        int(line.split()[1]) * 1024
        for line in status.read_text(encoding="ascii").splitlines()
        if line.startswith("VmData:")
    )
    former = resource.getrlimit(resource.RLIMIT_DATA)
    known = [one for one in former if one != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min([used + limit, *known]), former[1]))
    return former


@contextmanager
def limited_memory(limit: int) -> Iterator[None]:
    """Let allocations fail within a ``with`` that would take more than `limit` bytes."""
    former = limit_memory(limit)
    try:
        yield
    finally:
        if former is not None:
            import resource

            resource.setrlimit(resource.RLIMIT_DATA, former)
