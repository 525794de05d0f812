"""Jacobi's functions against mpmath's own, which use other algorithms."""


import pytest

from polhode.closed_forms.functions.jacobi import MP, jacobi, numpy_functions
from polhode.numbers.mpmath_context import mpf, mpmath

PARAMETERS = ["0", "1e-20", "0.3", "0.5", "0.7", "0.999", "1"]
ARGUMENTS = ["0", "0.3", "-1.7", "7.3"]


@pytest.fixture(autouse=True)
def sixty_digits():
    with mpmath.workdps(60):
        yield


@pytest.mark.parametrize("k2", PARAMETERS)
@pytest.mark.parametrize("v", ARGUMENTS)
def test_sn_cn_dn(k2, v):
    k2, v = mpf(k2), mpf(v)
    j = jacobi(k2, 1 - k2)
    waves = j.waves(v, MP)
    sn, cn, dn = j.functions(waves)
    sign = (-1) ** waves.turns
    for name, value in (("sn", sign * sn), ("cn", sign * cn), ("dn", dn)):
        assert abs(value - mpmath.ellipfun(name, v, m=k2)) < 20 * mpmath.eps


@pytest.mark.parametrize(("k2", "kc2"), [("1e-200", "1"), ("1", "1e-200")])
def test_a_complement_of_1e_200_costs_nothing(k2, kc2):
    j = jacobi(mpf(k2), mpf(kc2))
    with mpmath.workdps(280):  # 1 - k^2 is formed here, with digits to lose
        small = min(mpf(k2), mpf(kc2))
        long = mpmath.ellipk(1 - small)
    assert abs(max(j.K, j.Kc) / long - 1) < 10 * mpmath.eps


@pytest.mark.parametrize("k2", PARAMETERS)
def test_numpy_takes_the_same_lines(k2):
    np = pytest.importorskip("numpy")
    k2 = mpf(k2)
    j = jacobi(k2, 1 - k2)
    v = np.linspace(-900, 900, 23)
    waves = j.floats().waves(v, numpy_functions())
    rows = j.floats().functions(waves)
    for i, x in enumerate(v):
        exact = j.functions(j.waves(mpf(x), MP))
        for row, value in zip(rows, exact, strict=True):
            assert abs(row[i] - value) < 1000 * 16 * 2.0**-53
