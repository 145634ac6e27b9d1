"""The observer: a model driven by the measured input and corrected by the measured response.

The linear part moves exactly (propagators for an input that is linear between the points of a
finer grid); the forces of the candidates act as kicks at both ends of every fine step (Strang
splitting, second order). At every sample the state is corrected by what was not predicted (the
innovation), as far as the noises of input and sensors justify (an extended Kalman filter), so
that chaotic motion stays on the measurement.

References
----------
.. [1] K. J. Astrom, "Maximum likelihood and prediction error methods", Automatica 16, 551-574,
   1980.
.. [2] A. H. Jazwinski, "Stochastic Processes and Filtering Theory", Academic Press, 1970.
"""

import math

import numpy as np
from numba import njit

GAP = 0
OFFSET_GAP = 1
STOP = 2
CUBIC = 3
QUADRATIC = 4
POWER = 5
COULOMB = 6
STRIBECK = 7
LUGRE = 8
QUADRATIC_DAMPING = 9
CONTACT_DAMPING = 10
JENKINS = 11
IWAN = 12
BOUC_WEN = 13
DRIFT = 14
N_MEMORY = 40


@njit(cache=True, nogil=True, inline="always")
def _slide(force, stiffness, step, limit):
    force = force + stiffness * step
    if force > limit:
        return limit
    return -limit if force < -limit else force


@njit(cache=True, nogil=True)
def law(op, p, memory, j, d, v, t, h):  # noqa: C901, PLR0911, PLR0912, PLR0915, PLR0917
    """Return force, tangent stiffness and tangent damping of law j; moves its memory.

    ``memory[j, 0]`` is the displacement of the last call, ``memory[j, 1:]`` the state. ``h`` is
    the time since the last call [s].
    """
    if op == GAP:
        r = abs(d) - p[j, 1]
        return (math.copysign(p[j, 0] * r, d), p[j, 0], 0.0) if r > 0.0 else (0.0, 0.0, 0.0)
    if op == OFFSET_GAP:
        if d > p[j, 1]:
            return p[j, 0] * (d - p[j, 1]), p[j, 0], 0.0
        if d < -p[j, 2]:
            return p[j, 0] * (d + p[j, 2]), p[j, 0], 0.0
        return 0.0, 0.0, 0.0
    if op == STOP:
        r = d * p[j, 2] - p[j, 1]
        return (p[j, 0] * r * p[j, 2], p[j, 0], 0.0) if r > 0.0 else (0.0, 0.0, 0.0)
    if op == CUBIC:
        return p[j, 0] * d * d * d, 3.0 * p[j, 0] * d * d, 0.0
    if op == QUADRATIC:
        return p[j, 0] * d * d, 2.0 * p[j, 0] * d, 0.0
    if op == POWER:
        ratio = abs(d) / p[j, 1]
        if ratio <= 0.0:
            return 0.0, 0.0, 0.0
        f = p[j, 0] * ratio ** p[j, 2]
        return math.copysign(f, d), f * p[j, 2] / abs(d), 0.0
    if op == QUADRATIC_DAMPING:
        return p[j, 0] * v * abs(v), 0.0, 2.0 * p[j, 0] * abs(v)
    if op == CONTACT_DAMPING:
        return (p[j, 0] * v, 0.0, p[j, 0]) if abs(d) > p[j, 1] else (0.0, 0.0, 0.0)
    if op == DRIFT:
        k = p[j, 0] * (t - p[j, 1])
        return k * d, k, 0.0
    step = d - memory[j, 0]
    memory[j, 0] = d
    if op == JENKINS:
        f = _slide(memory[j, 1], p[j, 0], step, p[j, 1])
        memory[j, 1] = f
        return f, (p[j, 0] if abs(f) < p[j, 1] else 0.0), 0.0
    if op == IWAN:
        # sliders that slip at the middles of n equal parts of 0..zs
        n = int(p[j, 2])
        part = p[j, 0] / n
        total, tangent = 0.0, 0.0
        for i in range(n):
            limit = part * p[j, 1] * (i + 0.5) / n
            f = _slide(memory[j, 1 + i], part, step, limit)
            memory[j, 1 + i] = f
            total += f
            if abs(f) < limit:
                tangent += part
        return total, tangent, 0.0
    if op == BOUC_WEN:
        pieces = 1 + int(abs(step) / (0.25 * p[j, 1]))
        pieces = min(pieces, 20)
        ds = step / pieces / p[j, 1]
        w = memory[j, 1]
        slope = 1.0
        for _ in range(pieces):
            k1 = 1.0 - abs(w) ** p[j, 2] if w * ds > 0.0 else 1.0
            wm = w + 0.5 * ds * k1
            slope = 1.0 - abs(wm) ** p[j, 2] if wm * ds > 0.0 else 1.0
            w = w + ds * slope
            if w > 1.0:
                w = 1.0
            elif w < -1.0:
                w = -1.0
        memory[j, 1] = w
        return p[j, 0] * p[j, 1] * w, p[j, 0] * max(slope, 0.0), 0.0
    if op == LUGRE:
        # p: sigma0, sigma1, sigma2, sliding, breakaway, stribeck velocity
        if h > 0.0:
            vm = step / h
            ratio = vm / p[j, 5]
            level = p[j, 3]
            if abs(ratio) < 6.0:
                level += (p[j, 4] - p[j, 3]) * math.exp(-ratio * ratio)
            x = p[j, 0] * abs(vm) / level * h
            if x < 1e-8:
                memory[j, 1] += step
            else:
                steady = math.copysign(level / p[j, 0], vm)
                memory[j, 1] = steady + (memory[j, 1] - steady) * (
                    math.exp(-x) if x < 40.0 else 0.0
                )
        ratio = v / p[j, 5]
        level = p[j, 3]
        if abs(ratio) < 6.0:
            level += (p[j, 4] - p[j, 3]) * math.exp(-ratio * ratio)
        bent = p[j, 0] * memory[j, 1] / level
        share = 1.0 - math.copysign(bent, v * bent) if v * bent > 0.0 else 1.0 + abs(bent)
        share = min(max(share, 0.0), 1.0)
        rate = v - abs(v) * bent
        return (
            p[j, 0] * memory[j, 1] + p[j, 1] * rate + p[j, 2] * v,
            p[j, 0] * share,
            p[j, 1] * share + p[j, 2],
        )
    return 0.0, 0.0, 0.0


@njit(cache=True, nogil=True, inline="always")
def _friction(op, p, j, speed):
    if op == COULOMB:
        return p[j, 0]
    ratio = speed / p[j, 2]
    return p[j, 0] + (p[j, 1] - p[j, 0]) * (math.exp(-ratio * ratio) if ratio < 20.0 else 0.0)


@njit(cache=True, nogil=True)
def _totals(
    x,
    now_u,
    ops,
    params,
    side_a,
    side_b,
    forces,
    stiff,
    reduced,
    minv,
    acc,
    acc_u,
    memory,
    total,
):  # noqa: C901, PLR0912, PLR0917
    """Fill total (m,) with the forces of all laws on the masses; friction holds what sticks.

    Where a contact sticks, stiff[j] becomes 1, else 0.
    """
    m = minv.shape[0]
    m2 = 2 * m
    for i in range(m):
        total[i] = 0.0
    friction = False
    for j in range(ops.shape[0]):
        if ops[j] == COULOMB or ops[j] == STRIBECK:
            friction = True
        else:
            if side_b[j] < m:
                total[side_b[j]] += forces[j]
            if side_a[j] < m:
                total[side_a[j]] -= forces[j]
    if not friction:
        return
    for j in range(ops.shape[0]):
        if ops[j] == COULOMB or ops[j] == STRIBECK:
            a, b = side_a[j], side_b[j]
            vr = (x[m + b] if b < m else 0.0) - (x[m + a] if a < m else 0.0)
            stiff[j] = 0.0
            if memory[j, 1] != 0.0:
                free = 0.0
                if b < m:
                    free += acc_u[b] * now_u - minv[b] * total[b]
                    for i in range(m2):
                        free += acc[b, i] * x[i]
                if a < m:
                    free -= acc_u[a] * now_u - minv[a] * total[a]
                    for i in range(m2):
                        free -= acc[a, i] * x[i]
                f = free * reduced[j]
                limit = _friction(ops[j], params, j, 0.0)
                stiff[j] = 1.0 if abs(f) <= limit else 0.0
                f = min(max(f, -limit), limit)
            else:
                f = math.copysign(_friction(ops[j], params, j, abs(vr)), vr)
            if b < m:
                total[b] += f
            if a < m:
                total[a] -= f


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz", "arcp"})
def observe(
    phi,
    g0,
    g1,
    acc,
    acc_u,
    out,
    out_f,
    out_u,
    direct,
    minv,
    u,
    fine,
    measured,
    weight,
    noise,
    input_noise,
    model_noise,
    spread,
    ops,
    params,
    side_a,
    side_b,
    step,
    t0,
    skip,
    keep,
    innovations,
    states,
    dense,
    expected,
):  # noqa: C901, PLR0912, PLR0915, PLR0917
    """Fill whitened innovations (n_sensors, n) and, where keep, the states (2 n_mass, n).

    An extended Kalman filter: the state's covariance follows the tangents of the laws.

    phi (2m, 2m), g0, g1 (2m,): propagator of a fine step and of the input at its ends.
    acc (m, 2m), acc_u (m,): accelerations relative to the base without the laws.
    out (s, 2m), out_f (s, m), out_u (s,): sensors from state, forces on the masses, input.
    direct (s, m): how an acceleration that no model explains shows in the sensors at once.
    u (n * fine,) input on the fine grid. measured (s, n); weight (s, n) 0 or 1.
    noise (s,), input_noise, model_noise: standard deviations of a sample. spread (2m,): of the
    state at the start. side_a, side_b (n_laws,): masses on both sides of each law, m the base.
    dense (s, n * fine), expected (s, n): filled with the sensors on the fine grid and with the
    predicted samples, where keep.
    Returns the sum of the logarithms of the innovations' variances of the samples after `skip`,
    infinite where the run blew up.
    """
    m = minv.shape[0]
    m2, m3 = 2 * m, 3 * m
    n = measured.shape[1]
    s = measured.shape[0]
    laws = ops.shape[0]
    memory = np.zeros((laws, N_MEMORY))
    forces, stiff, damp = np.zeros(laws), np.zeros(laws), np.zeros(laws)
    x = np.zeros(m3)  # displacement, velocity, acceleration that is not explained
    y = np.zeros(m2)
    total = np.zeros(m)
    cov = np.zeros((m3, m3))
    tangent = np.zeros((m2, m3))
    moved = np.zeros((m2, m3))
    h = np.zeros(m3)
    ph = np.zeros(m3)
    for i in range(m2):
        cov[i, i] = spread[i] ** 2
    sample = step * fine
    logs = 0.0
    reduced = np.zeros(laws)
    for j in range(laws):
        if side_a[j] < m:
            reduced[j] += minv[side_a[j]]
        if side_b[j] < m:
            reduced[j] += minv[side_b[j]]
        reduced[j] = 1.0 / reduced[j]
    for k in range(n):
        now = t0 + k * sample
        now_u = u[k * fine]
        for i in range(m):
            cov[m2 + i, m2 + i] = model_noise * model_noise
        _totals(
            x,
            now_u,
            ops,
            params,
            side_a,
            side_b,
            forces,
            stiff,
            reduced,
            minv,
            acc,
            acc_u,
            memory,
            total,
        )
        biggest = 0.0
        values = 0.0
        # all sensors are predicted before any corrects the state
        for r in range(s):
            values = out_u[r] * now_u
            for i in range(m2):
                values += out[r, i] * x[i]
            for i in range(m):
                values += out_f[r, i] * total[i]
            innovations[r, k] = measured[r, k] - values
            if keep:
                expected[r, k] = values
        for i in range(m):
            x[m2 + i] = 0.0
        for i in range(m2):
            y[i] = x[i]
        for r in range(s):
            if weight[r, k] == 0.0:
                innovations[r, k] = 0.0
                continue
            for i in range(m2):
                h[i] = out[r, i]
            for i in range(m):
                h[m2 + i] = direct[r, i]
            through = out_u[r]
            for j in range(laws):
                a, b = side_a[j], side_b[j]
                lever = (out_f[r, b] if b < m else 0.0) - (out_f[r, a] if a < m else 0.0)
                if lever == 0.0:
                    continue
                if ops[j] == COULOMB or ops[j] == STRIBECK:
                    if stiff[j] != 0.0:
                        rise = (acc_u[b] if b < m else 0.0) - (acc_u[a] if a < m else 0.0)
                        through += lever * reduced[j] * rise
                        for i in range(m2):
                            rise = (acc[b, i] if b < m else 0.0) - (acc[a, i] if a < m else 0.0)
                            h[i] += lever * reduced[j] * rise
                    continue
                if b < m:
                    h[b] += lever * stiff[j]
                    h[m + b] += lever * damp[j]
                if a < m:
                    h[a] -= lever * stiff[j]
                    h[m + a] -= lever * damp[j]
            var = noise[r] * noise[r] + (through * input_noise) ** 2
            e = innovations[r, k]
            for i in range(m3):
                value = 0.0
                for l in range(m3):
                    value += cov[i, l] * h[l]
                ph[i] = value
            for i in range(m3):
                var += h[i] * ph[i]
                # what earlier sensors have moved
                e -= h[i] * (x[i] - (y[i] if i < m2 else 0.0))
            for i in range(m3):
                gain = ph[i] / var
                x[i] += gain * e
                for l in range(m3):
                    cov[i, l] -= gain * ph[l]
            innovations[r, k] = e / math.sqrt(var)
            if k >= skip:
                logs += math.log(var)
        for i in range(m2):
            biggest += abs(x[i])
        if not biggest < 1e12:
            return math.inf
        if keep:
            for i in range(m2):
                states[i, k] = x[i]
        for i in range(m2):
            for l in range(m3):
                tangent[i, l] = 1.0 if i == l else 0.0
        for q in range(fine + 1):
            # forces of the laws, then their kick: half of it at the samples
            push = step if 0 < q < fine else 0.5 * step
            for j in range(laws):
                a, b = side_a[j], side_b[j]
                d = (x[b] if b < m else 0.0) - (x[a] if a < m else 0.0)
                v = (x[m + b] if b < m else 0.0) - (x[m + a] if a < m else 0.0)
                op = ops[j]
                kt, ct = 0.0, 0.0
                if op == COULOMB or op == STRIBECK:
                    # a contact that has stuck through the step has all of its force to give
                    able = step if memory[j, 1] != 0.0 and q > 0 else push
                    impulse = _friction(op, params, j, abs(v)) * able
                    need = reduced[j] * v
                    memory[j, 1] = 0.0
                    if abs(need) <= impulse:
                        impulse = need
                        ct = reduced[j] / push
                        memory[j, 1] = 1.0
                    elif v < 0.0:
                        impulse = -impulse
                else:
                    f, kt, ct = law(
                        op, params, memory, j, d, v, now + q * step, step if q else 0.0
                    )
                    forces[j], stiff[j], damp[j] = f, kt, ct
                    impulse = f * push
                if b < m:
                    x[m + b] -= minv[b] * impulse
                if a < m:
                    x[m + a] += minv[a] * impulse
                if kt != 0.0 or ct != 0.0:
                    for l in range(m3):
                        rise = 0.0
                        if b < m:
                            rise += kt * tangent[b, l] + ct * tangent[m + b, l]
                        if a < m:
                            rise -= kt * tangent[a, l] + ct * tangent[m + a, l]
                        if b < m:
                            tangent[m + b, l] -= minv[b] * push * rise
                        if a < m:
                            tangent[m + a, l] += minv[a] * push * rise
            for i in range(m):
                x[m + i] += push * x[m2 + i]
                tangent[m + i, m2 + i] += push
            if q == fine:
                break
            at = k * fine + q
            if keep:
                _totals(
                    x,
                    u[at],
                    ops,
                    params,
                    side_a,
                    side_b,
                    forces,
                    stiff,
                    reduced,
                    minv,
                    acc,
                    acc_u,
                    memory,
                    total,
                )
                for r in range(s):
                    value = out_u[r] * u[at]
                    for i in range(m2):
                        value += out[r, i] * x[i]
                    for i in range(m):
                        value += out_f[r, i] * total[i]
                    dense[r, at] = value
            u0 = u[at]
            u1 = u[at + 1] if at + 1 < u.shape[0] else u[at]
            for i in range(m2):
                value = g0[i] * u0 + g1[i] * u1
                for l in range(m2):
                    value += phi[i, l] * x[l]
                y[i] = value
                for l in range(m3):
                    moved[i, l] = phi[i, 0] * tangent[0, l]
                for o in range(1, m2):
                    for l in range(m3):
                        moved[i, l] += phi[i, o] * tangent[o, l]
            for i in range(m2):
                x[i] = y[i]
                for l in range(m3):
                    tangent[i, l] = moved[i, l]
        # covariance of the next prediction
        for i in range(m2):
            for l in range(m3):
                moved[i, l] = tangent[i, 0] * cov[0, l]
            for o in range(1, m3):
                for l in range(m3):
                    moved[i, l] += tangent[i, o] * cov[o, l]
        for i in range(m2):
            for l in range(i + 1):
                value = 0.0
                for o in range(m3):
                    value += moved[i, o] * tangent[l, o]
                gi = 0.5 * sample * sample * acc_u[i] if i < m else sample * acc_u[i - m]
                gl = 0.5 * sample * sample * acc_u[l] if l < m else sample * acc_u[l - m]
                value += input_noise * input_noise * gi * gl
                cov[i, l] = value
                cov[l, i] = value
        for i in range(m2):
            for l in range(m2, m3):
                cov[i, l] = 0.0
                cov[l, i] = 0.0
        for i in range(m2, m3):
            for l in range(m2, m3):
                cov[i, l] = 0.0
    return logs


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz", "arcp"})
def filter_forces(phi, g0, g1, out, out_f, gain, f, columns):
    """Fill columns (n_columns, n_sensors, n): what linear innovations show of extra forces.

    f (n_columns, n_mass, n): generalised force on every mass that the model lacks, at the
    samples; g0, g1 (2m, m) propagate forces linear between the samples.
    """
    c, m, n = f.shape
    s = out.shape[0]
    x = np.zeros(2 * m)
    y = np.zeros(2 * m)
    for col in range(c):
        x[:] = 0.0
        for k in range(n):
            for r in range(s):
                value = 0.0
                for i in range(2 * m):
                    value += out[r, i] * x[i]
                for i in range(m):
                    value += out_f[r, i] * f[col, i, k]
                columns[col, r, k] = value
            for i in range(2 * m):
                for r in range(s):
                    x[i] -= gain[i, r] * columns[col, r, k]
            for i in range(2 * m):
                value = 0.0
                for l in range(m):
                    value += g0[i, l] * f[col, l, k]
                    if k + 1 < n:
                        value += g1[i, l] * f[col, l, k + 1]
                for l in range(2 * m):
                    value += phi[i, l] * x[l]
                y[i] = value
            x[:] = y


@njit(cache=True, nogil=True)
def force_along(op, p, d, v, t0, step, forces):
    """Fill forces (n,) of one law, parameters p (1, n_parameters), along a known motion."""
    memory = np.zeros((1, N_MEMORY))
    for k in range(d.shape[0]):
        if op == COULOMB or op == STRIBECK:
            level = _friction(op, p, 0, abs(v[k]))
            width = p[0, 3]
            share = math.tanh(v[k] / width) if width > 0.0 else float(np.sign(v[k]))
            forces[k] = level * share
        else:
            forces[k] = law(op, p, memory, 0, d[k], v[k], t0 + k * step, step if k else 0.0)[0]
