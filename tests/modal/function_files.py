"""Response functions of a structure in closed form, and files of them by other programs."""

import gc
import warnings

import numpy as np
import pandas as pd
import pyuff

FREQUENCIES = np.array([52.3, 118.7, 231.4])
DAMPING = np.array([0.01, 0.006, 0.012])
SHAPES = np.array([
    [0.6, 0.9, 0.3, -0.5],
    [0.8, -0.2, -0.7, 0.6],
    [0.4, -0.6, 0.9, 0.2],
])  # fmt: skip
"""Mass-normalised, a row for each mode [1/sqrt(kg)]."""

LINES = 0.5 * np.arange(801)


def accelerance(rows, columns, lines=LINES, noise=0.002, seed=3):
    """Accelerances (n_rows, n_columns, n_lines) [m/s^2/N] with noise of one size [same]."""
    omega, own = 2.0 * np.pi * lines, 2.0 * np.pi * FREQUENCIES
    below = own[:, None] ** 2 - omega**2 + 2j * (DAMPING * own)[:, None] * omega
    exact = np.einsum("mr,mc,mf->rcf", SHAPES[:, rows], SHAPES[:, columns], -(omega**2) / below)
    rng = np.random.default_rng(seed)
    return exact + noise * (
        rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)
    )


def record(values, response, reference, *, kind=4, lines=LINES, binary=0, **said):
    """A record 58 between nodes (0-based; direction z) as pyuff prepares it."""
    about = {
        "ordinate_spec_data_type": 12, "ordinate_axis_units_lab": "m/s^2",
        "orddenom_spec_data_type": 13, "orddenom_axis_units_lab": "N",
    } | said  # fmt: skip
    return pyuff.prepare_58(
        binary=binary, id1="function", func_type=kind, ver_num=0, load_case_id=0,
        rsp_ent_name="NONE", ref_ent_name="NONE", rsp_node=response + 1, rsp_dir=3,
        ref_node=reference + 1, ref_dir=3, num_pts=lines.size, abscissa_spacing=1,
        abscissa_min=float(lines[0]), abscissa_inc=float(lines[1] - lines[0]),
        abscissa_spec_data_type=18, ord_data_type=5 if np.iscomplexobj(values) else 2,
        data=values, x=lines, **about,
    )  # fmt: skip


def nodes(points, factor=1.0):
    """A data set 15 of points [m], written in units of which `factor` are in a metre."""
    x, y, z = factor * np.asarray(points, float).T
    numbers = list(range(1, len(points) + 1))
    return pyuff.prepare_15(node_nums=numbers, x=x, y=y, z=z)


def write(path, sets):
    path.unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves the file open
        pyuff.UFF(str(path)).write_sets(sets, mode="add")
        gc.collect()


def copied_table(path, ending):
    """The place of a copy of a CSV, in another format that tables are read from."""
    frame, copy = pd.read_csv(path), path.with_suffix(ending)
    if ending == ".txt":  # comments, semicolons and decimal commas
        text = "# of an analyser\n" + frame.to_csv(sep=";", decimal=",", index=False)
        copy.write_text(text, encoding="utf-8")
        return copy
    write_frame = {".xlsx": "to_excel", ".parquet": "to_parquet", ".feather": "to_feather"}
    options = {"index": False} if ending == ".xlsx" else {}
    getattr(frame, write_frame[ending])(copy, **options)
    return copy
