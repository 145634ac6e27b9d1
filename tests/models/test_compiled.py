"""Parts of kernels: typed once, and made machine code only as parts of a whole."""

from numba import njit

from shakerproc.models.compiled import inlined, inner


@inlined
def power(base, exponent):
    total = 1.0
    for _ in range(exponent):
        total *= base
    return total


@inner
def two_powers(base, exponent):
    return power(base, 2) + power(base, exponent)


@njit(error_model="numpy")
def kernel(base, exponent):
    return two_powers(base, exponent) + power(base, 0)


def test_a_kernel_has_its_parts_in_it_and_they_have_no_machine_code():
    assert kernel(3.0, 3) == 9.0 + 27.0 + 1.0
    assert len(power.signatures) == 1  # though 0 and 2 stand in the source
    for part in (power, two_powers):
        (made,) = part.overloads.values()
        engine = made.target_context.codegen()._engine
        assert not engine.is_symbol_defined(made.fndesc.llvm_func_name)
    (made,) = kernel.overloads.values()
    assert engine.is_symbol_defined(made.fndesc.llvm_func_name)
