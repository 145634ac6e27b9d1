"""The observer of one mass on the base with one sensor: the common case, several times faster.

It differs from `kernel.observe` in what it does where a force jumps (dry friction as the mass
turns, a damper as it touches): the moment of the jump is located within the fine step, the
covariance follows it, and the sample beside it is expected to lie on either side, with the
probability that the state's uncertainty gives.
"""

import math

import numpy as np
from numba import njit

from shakerproc.diagnose.kernel import (
    CONTACT_DAMPING,
    COULOMB,
    CUBIC,
    GAP,
    N_MEMORY,
    OFFSET_GAP,
    STOP,
    STRIBECK,
    law,
)

_DRY = (COULOMB, STRIBECK)
_ROOT_TWO = math.sqrt(2.0)
DOUBT = 0.012
"""Squared uncertainty of a jump's time in filtered samples, over the squared spread: 0.05 of
a sample."""
LIMIT = 3.0
"""Expected sizes of an innovation by which a sample may move the state at most, where a contact
sticks and slips: one sample beside a jump says nothing of the motion [-]."""
_DENSITY = 1.0 / math.sqrt(2.0 * math.pi)


@njit(cache=True, nogil=True, inline="always")
def _level(ops, params, speed):
    """Return the force of all dry friction at a speed, and its slope over the speed."""
    force, slope = 0.0, 0.0
    for j in range(ops.shape[0]):
        if ops[j] == COULOMB:
            force += params[j, 0]
        elif ops[j] == STRIBECK:
            ratio = speed / params[j, 2]
            force += params[j, 0]
            if ratio < 6.0:
                more = (params[j, 1] - params[j, 0]) * math.exp(-ratio * ratio)
                force += more
                slope -= 2.0 * more * ratio / params[j, 2]
    return force, slope


@njit(cache=True, nogil=True, inline="always")
def _share(x):
    """Return the probability that a standard normal variate lies below x."""
    return 0.5 * (1.0 + math.erf(x / _ROOT_TWO))


@njit(cache=True, nogil=True, inline="always")
def _bell(x):
    return _DENSITY * math.exp(-0.5 * x * x) if abs(x) < 30.0 else 0.0


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz", "arcp"})
def observe_one(
    phi,
    g0,
    g1,
    acc,
    out,
    out_f,
    out_u,
    direct,
    minv,
    acc_u,
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
    step,
    t0,
    skip,
    keep,
    soften,
    innovations,
    states,
    dense,
    expected,
):
    """Do what `kernel.observe` does for one mass with one sensor.

    phi (4,), g0, g1 (2,), acc (2,), out (2,), spread (2,): flat; the rest are numbers. soften:
    over how many samples a recorder's filter spreads a jump, 0 for samples taken as they are.
    expected (n,): filled with the predicted samples, where keep.
    """
    n = measured.shape[0]
    laws = ops.shape[0]
    memory = np.zeros((laws, N_MEMORY))
    forces, stiff, damp = np.zeros(laws), np.zeros(laws), np.zeros(laws)
    f00, f01, f10, f11 = phi[0], phi[1], phi[2], phi[3]
    a0, a1, b0, b1 = g0[0], g0[1], g1[0], g1[1]
    z, v, w = 0.0, 0.0, 0.0
    p00, p01, p11 = spread[0] ** 2, 0.0, spread[1] ** 2
    sample = step * fine
    half = 0.5 * step
    gz, gv = 0.5 * sample * sample * acc_u * input_noise, sample * acc_u * input_noise
    pw = model_noise * model_noise
    logs = 0.0
    mass = 1.0 / minv
    last = u.shape[0] - 1
    dry, jumps = False, False
    for j in range(laws):
        if ops[j] in _DRY:
            dry, jumps = True, True
        elif ops[j] == CONTACT_DAMPING:
            jumps = True
    rest, _ = _level(ops, params, 0.0)
    stuck = dry and spread[1] == 0.0
    way = 1.0
    pull = 0.0  # what holds a mass that sticks
    for k in range(n):
        now = t0 + k * sample
        now_u = u[k * fine]
        total, through, unsure = 0.0, out_u, 0.0
        h0, h1, h2 = out[0], out[1], direct
        for j in range(laws):
            op = ops[j]
            if op in _DRY:
                continue
            if op == CONTACT_DAMPING and p00 > 0.0 and v != 0.0:
                blur = (soften * sample * v) ** 2
                spray = math.sqrt(p00 + blur)
                upper, lower = (z - params[j, 1]) / spray, (z + params[j, 1]) / spray
                inside = _share(upper) + _share(-lower)
                kt = params[j, 0] * v * (_bell(upper) - _bell(lower)) / spray
                ct = params[j, 0] * inside
                total += ct * v
                h0 += out_f * kt
                h1 += out_f * ct
                either = (params[j, 0] * v) ** 2 * inside * (1.0 - inside) - kt * kt * p00
                either = max(either, 0.0) * (p00 / (p00 + blur)) ** 2 + kt * kt * blur * DOUBT
                unsure += out_f * out_f * either
                continue
            total += forces[j]
            h0 += out_f * stiff[j]
            h1 += out_f * damp[j]
        if stuck:
            h0 = out[0] + out_f * mass * acc[0]
            h1 = out[1] + out_f * mass * acc[1]
            through += out_f * mass * acc_u
            f = mass * (acc_u * now_u + acc[0] * z) - total
            total += min(max(f, -rest), rest)
        elif dry:
            level, slope = _level(ops, params, abs(v))
            held = mass * (acc_u * now_u + acc[0] * z) - total
            blur = (soften * sample * minv * held) ** 2
            spray = math.sqrt(p11 + blur)
            if abs(v) >= 6.0 * spray:
                total += way * level
                h1 += out_f * slope
            else:
                beyond = held if abs(held) <= rest else -way * level
                still = _share(way * v / spray)
                rise = (way * level - beyond) * way * _bell(v / spray) / spray
                total += beyond + (way * level - beyond) * still
                h1 += out_f * rise
                either = (way * level - beyond) ** 2 * still * (1.0 - still)
                either = max(either - rise * rise * p11, 0.0) * (p11 / (p11 + blur)) ** 2
                unsure += out_f * out_f * (either + rise * rise * blur * DOUBT)
        w = 0.0
        pw0, pw1, pww = 0.0, 0.0, pw
        predicted = out_u * now_u + out[0] * z + out[1] * v + out_f * total
        if keep:
            expected[k] = predicted
        if weight[k] != 0.0:
            e = measured[k] - predicted
            c0 = p00 * h0 + p01 * h1
            c1 = p01 * h0 + p11 * h1
            c2 = pw * h2
            var = noise * noise + (through * input_noise) ** 2 + unsure
            var += h0 * c0 + h1 * c1 + h2 * c2
            inverse = 1.0 / var
            e_over = e * inverse
            if dry:
                most = LIMIT * math.sqrt(inverse)
                e_over = min(max(e_over, -most), most)
            z += c0 * e_over
            v += c1 * e_over
            w = c2 * e_over
            p00 -= c0 * c0 * inverse
            p01 -= c0 * c1 * inverse
            p11 -= c1 * c1 * inverse
            pw0 = -c0 * c2 * inverse
            pw1 = -c1 * c2 * inverse
            pww = pw - c2 * c2 * inverse
            innovations[k] = e * math.sqrt(inverse)
            if k >= skip:
                logs += math.log(var)
        else:
            innovations[k] = 0.0
        if not abs(z) + abs(v) < 1e12:
            return math.inf
        p11 = max(p11, 0.0)
        if dry and not stuck and v != 0.0:
            way = math.copysign(1.0, v)
        if keep:
            states[0, k] = z
            states[1, k] = v
        t00, t01, t02, t10, t11, t12 = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
        zp, vp = z, v
        s00, s01, s02, s10, s11, s12 = t00, t01, t02, t10, t11, t12
        for q in range(fine + 1):
            other, bump = 0.0, 0.0
            for j in range(laws):
                op = ops[j]
                kt, ct = 0.0, 0.0
                if op in _DRY:
                    continue
                if op == GAP:
                    f = abs(z) - params[j, 1]
                    kt = params[j, 0] if f > 0.0 else 0.0
                    f = math.copysign(kt * f, z)
                elif op == STOP:
                    f = z * params[j, 2] - params[j, 1]
                    kt = params[j, 0] if f > 0.0 else 0.0
                    f = kt * f * params[j, 2]
                elif op == CUBIC:
                    kt = params[j, 0] * z * z
                    f = kt * z
                    kt *= 3.0
                elif op == OFFSET_GAP:
                    f = z - params[j, 1] if z > 0.0 else -z - params[j, 2]
                    kt = params[j, 0] if f > 0.0 else 0.0
                    f = math.copysign(kt * f, z)
                else:
                    f, kt, ct = law(
                        op, params, memory, j, z, v, now + q * step, step if q else 0.0
                    )
                forces[j], stiff[j], damp[j] = f, kt, ct
                other += f
            parts = 2 if jumps and 0 < q < fine else 1
            for part in range(parts):
                push = step if 0 < q < fine and not jumps else half
                ends = q > 0 and part == 0
                if not stuck:
                    before, kick = v, minv * push
                    for j in range(laws):
                        if ops[j] in _DRY:
                            continue
                        # what depends on velocity is taken in the middle of its kick
                        own = kick / (1.0 + 0.5 * kick * damp[j])
                        v -= own * forces[j]
                        if stiff[j] != 0.0 or damp[j] != 0.0:
                            t10 -= own * (stiff[j] * t00 + damp[j] * t10)
                            t11 -= own * (stiff[j] * t01 + damp[j] * t11)
                            t12 -= own * (stiff[j] * t02 + damp[j] * t12)
                    if dry:
                        level, slope = _level(ops, params, abs(before))
                        own = kick / (1.0 + 0.5 * kick * slope)
                        v -= own * way * level
                        t10 -= own * slope * t10
                        t11 -= own * slope * t11
                        t12 -= own * slope * t12
                    v += push * w
                    t12 += push
                    for j in range(laws):
                        if damp[j] != 0.0:
                            other += damp[j] * (v - before)
                            forces[j] += damp[j] * (v - before)
                if not (ends and jumps):
                    continue
                # the step that ends here: did a force jump in it?
                jump, theta = 0.0, 0.5
                at = k * fine + q
                u1 = u[min(at, last)]
                u0 = u[at - 1]
                if stuck:
                    z, v = zp, 0.0
                    t00, t01, t02, t10, t11, t12 = s00, s01, s02, 0.0, 0.0, 0.0
                    need = mass * (acc_u * u1 + acc[0] * z + w) - other
                    if abs(need) > rest:
                        rising = abs(need) - abs(pull)
                        theta = (rest - abs(pull)) / rising if rising > 0.0 else 1.0
                        theta = min(max(theta, 0.0), 1.0)
                        way = math.copysign(1.0, need)
                        free = 0.5 * (1.0 - theta) * step
                        v = way * (abs(need) - rest) * minv * free
                        t10, t11, t12 = free * acc[0] * t00, free * acc[0] * t01, free
                        stuck = False
                    pull = need
                elif dry and v * way < 0.0:
                    width = vp - v
                    theta = min(max(vp / width, 0.0), 1.0) if width != 0.0 else 1.0
                    after = (1.0 - theta) * step
                    need = mass * (acc_u * (u0 + theta * (u1 - u0)) + acc[0] * z + w) - other
                    if abs(need) <= rest:
                        jump = need - way * rest
                        z -= 0.5 * v * after
                        v, stuck, pull = 0.0, True, need
                        t10, t11, t12 = 0.0, 0.0, 0.0
                    else:
                        jump = -2.0 * rest * way
                        kick = 2.0 * rest * way * minv
                        turn = kick * step / (width * width)
                        t10 += turn * (v * s10 - vp * t10)
                        t11 += turn * (v * s11 - vp * t11)
                        t12 += turn * (v * s12 - vp * t12)
                        v += kick * after
                        z += 0.5 * kick * after * after
                        way = -way
                        if v * way < 0.0:
                            v = 0.0
                for j in range(laws):
                    if ops[j] != CONTACT_DAMPING or stuck:
                        continue
                    edge = params[j, 1]
                    was, now_in = abs(zp) > edge, abs(z) > edge
                    if was == now_in:
                        continue
                    width = abs(z) - abs(zp)
                    theta = (edge - abs(zp)) / width
                    sense = 1.0 if now_in else -1.0
                    part_of = sense * (0.5 - theta) * step
                    kick = minv * params[j, 0]
                    turn = sense * kick * v * step / width
                    side = math.copysign(1.0, z)
                    t10 -= kick * part_of * t10 + turn * side * (
                        (1.0 - theta) * s00 + theta * t00
                    )
                    t11 -= kick * part_of * t11 + turn * side * (
                        (1.0 - theta) * s01 + theta * t01
                    )
                    t12 -= kick * part_of * t12 + turn * side * (
                        (1.0 - theta) * s02 + theta * t02
                    )
                    jump += sense * params[j, 0] * v
                    v -= kick * part_of * v
                if keep and jump != 0.0:
                    bump = out_f * jump * (0.5 - theta)
                    if q == fine and fine > 1:
                        dense[at - 1] += bump
                        bump = 0.0
                zp, vp = z, v
                s00, s01, s02, s10, s11, s12 = t00, t01, t02, t10, t11, t12
            if q == fine:
                break
            at = k * fine + q
            u0 = u[at]
            u1 = u[at + 1] if at < last else u0
            if q == 0 and stuck:
                pull = mass * (acc_u * u0 + acc[0] * z + w) - other
            if keep:
                total = other
                if stuck:
                    total += min(max(pull, -rest), rest)
                elif dry:
                    total += way * _level(ops, params, abs(v))[0]
                dense[at] = out_u * u0 + out[0] * z + out[1] * v + out_f * total + bump
            if stuck:
                continue
            y0 = a0 * u0 + b0 * u1 + f00 * z + f01 * v
            v = a1 * u0 + b1 * u1 + f10 * z + f11 * v
            z = y0
            m0, m1, m2 = t00, t01, t02
            t00 = f00 * m0 + f01 * t10
            t10 = f10 * m0 + f11 * t10
            t01 = f00 * m1 + f01 * t11
            t11 = f10 * m1 + f11 * t11
            t02 = f00 * m2 + f01 * t12
            t12 = f10 * m2 + f11 * t12
        r00 = t00 * p00 + t01 * p01 + t02 * pw0
        r01 = t00 * p01 + t01 * p11 + t02 * pw1
        r02 = t00 * pw0 + t01 * pw1 + t02 * pww
        r10 = t10 * p00 + t11 * p01 + t12 * pw0
        r11 = t10 * p01 + t11 * p11 + t12 * pw1
        r12 = t10 * pw0 + t11 * pw1 + t12 * pww
        p00 = r00 * t00 + r01 * t01 + r02 * t02
        p01 = r00 * t10 + r01 * t11 + r02 * t12
        p11 = r10 * t10 + r11 * t11 + r12 * t12
        if not stuck:
            p00 += gz * gz
            p01 += gz * gv
            p11 += gv * gv
    return logs
