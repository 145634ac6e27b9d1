"""Write modes.op2 by pyNastran 1.4.1, in an environment of its own: it wants numpy below 2.

    python -m venv pyn && pyn/bin/pip install "numpy<2" pyNastran==1.4.1
    pyn/bin/python write_modes_op2.py modes.op2

The numbers are those of `SHAPES` and `FREQUENCIES` in tests/exchange/test_op2.py.
"""

import sys

import numpy as np
from pyNastran.op2.op2 import OP2
from pyNastran.op2.tables.oug.oug_eigenvectors import RealEigenvectorArray

nodes = np.array([[1, 1], [2, 1], [7, 1], [90, 2]], "int32")  # three grids, one scalar point
frequencies = np.array([0.0, 31.25, 62.5, 180.125])
k, i, c = np.meshgrid(np.arange(4), np.arange(4), np.arange(6), indexing="ij")
shapes = np.cos(1.0 + k + 2.0 * i + 0.5 * c).astype("float32")
shapes[:, 3, 1:] = 0.0
values = ((2.0 * np.pi * frequencies) ** 2).astype("float32")
found = RealEigenvectorArray.add_modal_case(
    "OUGV1", nodes, shapes, 1, np.arange(1, 5, dtype="int32"), values,
    frequencies.astype("float32"), title="T", subtitle="S", label="L",
)  # fmt: skip
found.table_name, found.table_code = "OUGV1", 7
found.data_code["table_name"], found.data_code["table_code"] = b"OUGV1", 7
op2 = OP2(debug=False, mode="msc")
op2.is_nx, op2.is_msc, op2.date = False, True, (11, 28, 26)
op2.eigenvectors[1] = found
op2.write_op2(sys.argv[1], post=-1, nastran_format="msc")
again = OP2(debug=False)
again.read_op2(sys.argv[1])
assert np.array_equal(again.eigenvectors[1].data, shapes)
