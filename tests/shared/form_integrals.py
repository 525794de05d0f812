"""The first integrals that forms of the equations leave: written in each form's own variables."""

from __future__ import annotations

from polhode.equations.form import Form
from polhode.equations.forms import without_gamma
from polhode.equations.forms.hamiltonian import Hamiltonian
from polhode.equations.forms.lagrangian import Lagrangian
from polhode.equations.forms.momentum_only import MomentumOnly
from polhode.equations.forms.omega_only import OmegaOnly
from polhode.equations.forms.routhian import Routhian
from polhode.numbers.scalars import Functions, combination


def form_integrals(form: Form, values, k, fn: Functions) -> dict:
    """h and f in the scene's unit of mass, |gamma|^2; what the form is given is left out."""
    if isinstance(form, OmegaOnly | MomentumOnly):
        return {"gamma": _length(form, values, k, fn)}
    omega, gamma = form.state(values, k, fn)
    kinetic = sum(k[name] * w * w for name, w in zip("ABC", omega, strict=True)) / 2
    weight = combination(k, fn.zero, *zip("xyz", gamma, strict=True))
    found = {"h": k["mass"] * (kinetic + weight)}  # of Routh's equations Jacobi's integral, f given
    if isinstance(form, Lagrangian):  # (3.45), and f = dL/dpsi' (3.46)
        triples = zip("ABC", omega, gamma, strict=True)
        found["f"] = k["mass"] * sum(k[name] * w * g for name, w, g in triples)
    elif isinstance(form, Hamiltonian):  # H, and f = p_psi
        found["f"] = k["mass"] * values[3]
    else:
        assert isinstance(form, Routhian)
    return found


def _length(form: Form, values, k, fn: Functions):
    """|gamma|^2 = (u^2 + b^2 |N|^2)/|n|^2 + d D, see polhode.equations.forms.without_gamma."""
    known, D = values[:3], values[3]
    if isinstance(form, OmegaOnly):
        omega, G = known, [k[name] * w for name, w in zip("ABC", known, strict=True)]
    else:
        omega, G = [k[f"1/{name}"] * x for name, x in zip("ABC", known, strict=True)], known
    it = without_gamma.parts(omega, G, D, k, fn)
    return k["1/n2"] * (it.u * it.u + it.lean) + it.d * D
