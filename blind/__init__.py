"""Blind trials: hidden campaigns from a truth generator of its own, and their score.

Nothing here but `trial` imports shakerproc. The force laws, the integrator, the excitation and
the files are written afresh, so that a campaign cannot be explained by a mistake that the
simulation which fits it shares.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # campaigns fill the cores by themselves
