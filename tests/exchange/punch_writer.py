"""Punch files as Nastran writes them, for tests and benchmarks."""

import numpy as np


def write_punch(path, quantities, nodes, times):
    """Write SORT1 real results: quantities maps a heading to (n_nodes, 6, n_steps) values."""
    lines = []
    for heading, values in quantities.items():
        for k, time in enumerate(times):
            lines += ["$TITLE   =", "$SUBTITLE=", heading, "$REAL OUTPUT", "$SUBCASE ID =  1"]
            lines.append(f"$TIME ={time:16.7E}")
            for i, node in enumerate(nodes):
                row = values[i, :, k]
                lines.append(f"{node:10d}       G" + "".join(f"{v:18.6E}" for v in row[:3]))
                lines.append("-CONT-            " + "".join(f"{v:18.6E}" for v in row[3:]))
    numbered = (f"{line:<72}{i % 10**8:8d}\n" for i, line in enumerate(lines, 1))
    path.write_text("".join(numbered))


def moving_node(samples):
    """Return (1, 6, n) values of a node that moves along x only."""
    values = np.zeros((1, 6, samples.size))
    values[0, 0] = samples
    return values
