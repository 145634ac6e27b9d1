"""The linear skeleton of a model as matrices, and the gain that corrects its state."""

from dataclasses import dataclass, replace

import numpy as np

from shakerproc.data import FloatArray


@dataclass(frozen=True, slots=True)
class Joint:
    """A linear spring and damper between two places; mass -1 is the base."""

    a: int
    b: int
    stiffness: float
    damping: float


@dataclass(frozen=True, slots=True)
class Sensing:
    """What one sensor measures: order 2 acceleration, 1 velocity, 0 displacement."""

    mass: int
    order: int
    absolute: bool


@dataclass(frozen=True, slots=True)
class Structure:
    """Masses, linear joints, sensors and where the input acts.

    Attributes
    ----------
    masses : (m,) array
        Masses [kg].
    joints : tuple of Joint
        Linear joints.
    sensing : tuple of Sensing
        One for each response channel.
    forced : int
        Mass on which the measured force acts; -1 where the base acceleration is measured.
    """

    masses: FloatArray
    joints: tuple[Joint, ...]
    sensing: tuple[Sensing, ...]
    forced: int = -1

    def with_linear(self, stiffness: FloatArray, damping: FloatArray) -> "Structure":
        """Return the same with other stiffnesses [N/m] and dampings [N s/m] of the joints."""
        joints = tuple(
            replace(joint, stiffness=float(k), damping=float(c))
            for joint, k, c in zip(self.joints, stiffness, damping, strict=True)
        )
        return replace(self, joints=joints)

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness of every joint [N/m]."""
        return np.array([joint.stiffness for joint in self.joints])

    @property
    def damping(self) -> FloatArray:
        """Damping of every joint [N s/m]."""
        return np.array([joint.damping for joint in self.joints])


@dataclass(frozen=True, slots=True)
class Matrices:
    """Continuous state equations; the state is displacement, then velocity of every mass."""

    state: FloatArray
    input: FloatArray
    force: FloatArray
    out: FloatArray
    out_force: FloatArray
    out_input: FloatArray


def pattern(joint: Joint, n: int) -> FloatArray:
    """Return the (n,) array that takes displacements to the extension of a joint."""
    row = np.zeros(n)
    if joint.a >= 0:
        row[joint.a] = -1.0
    if joint.b >= 0:
        row[joint.b] = 1.0
    return row


def matrices(structure: Structure) -> Matrices:
    """Return the state equations of a structure."""
    m = structure.masses.size
    inverse = 1.0 / structure.masses
    stiffness, damping = np.zeros((m, m)), np.zeros((m, m))
    for joint in structure.joints:
        row = pattern(joint, m)
        stiffness += joint.stiffness * np.outer(row, row)
        damping += joint.damping * np.outer(row, row)
    accelerations = -inverse[:, None] * np.hstack([stiffness, damping])
    state = np.vstack([np.hstack([np.zeros((m, m)), np.eye(m)]), accelerations])
    onto = np.zeros(m)
    if structure.forced < 0:
        onto[:] = -1.0
    else:
        onto[structure.forced] = inverse[structure.forced]
    force = np.vstack([np.zeros((m, m)), -np.diag(inverse)])
    n = len(structure.sensing)
    out, out_force, out_input = np.zeros((n, 2 * m)), np.zeros((n, m)), np.zeros(n)
    for i, sensing in enumerate(structure.sensing):
        if sensing.order == 2:
            out[i] = accelerations[sensing.mass]
            out_force[i, sensing.mass] = -inverse[sensing.mass]
            base = 1.0 if sensing.absolute and structure.forced < 0 else 0.0
            out_input[i] = onto[sensing.mass] + base
        else:
            out[i, sensing.mass + m * sensing.order] = 1.0
    return Matrices(
        state, np.concatenate([np.zeros(m), onto]), force, out, out_force, out_input
    )


def angular_frequencies(structure: Structure) -> FloatArray:
    """Return the angular natural frequencies (2m,), one for each state, ascending [rad/s]."""
    return np.sort(np.abs(np.linalg.eigvals(matrices(structure).state)))


def hold(state: FloatArray, onto: FloatArray, step: float) -> tuple[FloatArray, ...]:
    """Return propagators over a step: of the state, of the input at its start and at its end.

    The input runs linearly over the step (first-order hold).
    """
    n, u = onto.shape
    # displacements times the fastest frequency, so that all entries have one size
    fastest = float(np.sqrt(np.max(np.abs(state[n // 2 :, : n // 2])))) or 1.0
    scale = np.concatenate([np.full(n // 2, fastest), np.ones(n - n // 2)])
    block = np.zeros((n + 2 * u, n + 2 * u))
    block[:n, :n] = scale[:, None] * state / scale * step
    block[:n, n : n + u] = scale[:, None] * onto * step
    block[n : n + u, n + u :] = np.eye(u)
    whole = _exponential(block)
    constant, ramp = (whole[:n, i : i + u] / scale[:, None] for i in (n, n + u))
    return whole[:n, :n] / scale[:, None] * scale, constant - ramp, ramp


_SERIES = 16  # terms: 0.5^17 / 17! is below the last digit


def _exponential(matrix: FloatArray) -> FloatArray:
    """Return the exponential of a small matrix, by its series after halving.

    scipy's calls LAPACK, whose threads wait for each other: on a busy machine 100 times longer
    than the sums take.
    """
    size = float(np.max(np.sum(np.abs(matrix), axis=1)))
    halvings = max(0, int(np.ceil(np.log2(max(size, 0.5) / 0.5))))
    part = matrix / 2.0**halvings
    one = np.eye(matrix.shape[0])
    total = one + part / _SERIES
    for k in range(_SERIES - 1, 0, -1):
        total = one + part @ total / k
    for _ in range(halvings):
        total = total @ total
    return total


def correction(
    system: Matrices,
    sample_rate: float,
    input_noise: float,
    noise: FloatArray,
    model_noise: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the steady Kalman gain (2m, n_sensors) and the innovations' sizes (n_sensors,).

    Parameters
    ----------
    system : Matrices
        State equations of the linear skeleton.
    sample_rate : float
        Samples per second [Hz].
    input_noise : float
        Standard deviation of a sample of the input's noise [unit of the input].
    noise : (n_sensors,) array
        Standard deviation of a sample of every response sensor.
    model_noise : float
        Standard deviation of forces that no model has, as an acceleration of every mass [m/s²].
    """
    n = system.state.shape[0]
    m = n // 2
    onto = np.column_stack([system.input * input_noise, np.zeros((n, m))])
    onto[m:, 1:] = np.eye(m) * model_noise
    phi, start, end = hold(system.state, onto, 1.0 / sample_rate)
    push = start + end
    process = push @ push.T
    # a force that the model misses shows at once in the accelerometers: correlated noises
    direct = np.column_stack([
        np.zeros(system.out.shape[0]),
        system.out_force / np.diag(system.force[m:]) * model_noise,
    ])
    both = push @ direct.T
    measured = np.diag(noise**2) + direct @ direct.T
    omega = np.sqrt(np.max(np.abs(system.state[m:, :m])))
    scale = np.concatenate([np.full(m, omega), np.ones(m)])
    level = np.sqrt(np.trace(scale[:, None] * process * scale)) + 1e-300
    size = np.sqrt(np.max(np.diag(measured)))
    a = scale[:, None] * phi / scale
    c = system.out / scale * level / size
    q = scale[:, None] * process * scale / level**2 + 1e-14 * np.eye(n)
    r = measured / size**2
    s = scale[:, None] * both / level / size
    p = _riccati(a, c, q, r, s)
    spread = c @ p @ c.T + r
    gain = np.linalg.solve(a, (a @ p @ c.T + s) @ np.linalg.inv(spread))
    return gain * level / size / scale[:, None], np.sqrt(np.diag(spread)) * size


def _riccati(
    a: FloatArray, c: FloatArray, q: FloatArray, r: FloatArray, s: FloatArray
) -> FloatArray:
    """Return the covariance of the steady one-step prediction, by doubling.

    References
    ----------
    .. [1] E. K.-W. Chu, H.-Y. Fan, W.-W. Lin and C.-S. Wang, "Structure-preserving algorithms
       for periodic discrete-time algebraic Riccati equations", International Journal of
       Control 77, 767-788, 2004.
    """
    inverse = np.linalg.inv(r)
    one = np.eye(a.shape[0])
    f = (a - s @ inverse @ c).T
    g = c.T @ inverse @ c
    h = q - s @ inverse @ s.T
    for _ in range(60):
        w = np.linalg.inv(one + g @ h)
        f, g, new = f @ w @ f, g + f @ w @ g @ f.T, h + f.T @ h @ w @ f
        change = np.max(np.abs(new - h))
        h = 0.5 * (new + new.T)
        if change <= 1e-13 * np.max(np.abs(h)):
            break
    return h
