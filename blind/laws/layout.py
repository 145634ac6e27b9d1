"""Codes of the laws, and places in the one array that the kernels share.

Passing many arrays would cost more than the laws: masses, joints as a matrix, forces and tables
of the elements, five states, the drive of a step, reversals.
"""

SPRING, DAMPER, GAP, OFFSET_GAP, STOP, CUBIC, QUADRATIC, POWER = range(8)
COULOMB, STRIBECK, LUGRE, QUADRATIC_DAMPING, CONTACT_DAMPING, JENKINS, IWAN = range(8, 15)
BOUC_WEN, DRIFT = 15, 16
PARAMETRIC, HUNT_CROSSLEY, FRACTIONAL, SATURATING, POSITION_DAMPING = range(20, 25)
THIXOTROPIC, SINE_SPRING, ASYMMETRIC_DAMPER, WEDGE_FRICTION = range(25, 29)
CONSTANT, SERIES, GENERAL_BOUC_WEN = range(29, 32)

STATES = {
    LUGRE: 1, BOUC_WEN: 1, FRACTIONAL: 6, THIXOTROPIC: 1, JENKINS: 1, SERIES: 1,
    GENERAL_BOUC_WEN: 1,
}  # fmt: skip
SLIDING = (COULOMB, STRIBECK, WEDGE_FRICTION)

N_MASSES, N_ELEMENTS, STATE_SIZE, FORCE_ON, MASSES, JOINTS, FORCES = 0, 1, 2, 3, 4, 8, 40
ELEMENTS, STRIDE, Y, TRIAL, WORK, RATES, BEFORE = 48, 24, 192, 208, 224, 240, 256
DRIVE, STACK, REVERSALS, SIZE = 272, 288, 2**17, 288 + 2**18
TIME, STEP, BASE, PUSH = DRIVE, DRIVE + 1, DRIVE + 2, DRIVE + 5
"""Beginning and length of a step; base acceleration and force at its start, middle and end."""
MODES, SUBSTEPS, LIMIT, NOW = DRIVE + 8, DRIVE + 9, DRIVE + 10, DRIVE + 11
"""Whether anything crosses thresholds or slides; steps in a sample; bound; time of a stage."""
THRESHOLDS, FIRST, SECOND, KIND, REGION = 12, 14, 15, 16, 17
SIGN, SLIDES, N_THRESHOLDS, STATE, DEPTH = 18, 19, 20, 21, 22
"""Places in the table of an element: twelve parameters, two thresholds, ends, mode, memory."""
