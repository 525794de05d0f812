"""Hess's motions with f = 0 and on the steady cone: explicit.

f = 0: th, the angle from r0 to the vertical, is a pendulum's, del = th - pi, del'' = -om^2 sin del,
om^2 = b P, and

    Z = (th'/b) e^{i ch},    u = cos th,    Gm = i sin th e^{i ch},    ch' = -a12 Re Z,

solved by the halves of ch: al = (cos - sin)(ch0/2) e^X, be = (cos + sin)(ch0/2) e^-X,
X = a12 (th - th0)/2b.  Steady cone: |Z| = ro, u and Gm/Z are constant and ch obeys a linear equation
in (sin, cos)(ch/2).  Units: b = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath
from mpmath import mpf

from polhode.closed_forms.attitude.quaternions import about_first
from polhode.closed_forms.hess.axes import LIBRATION, SEPARATRIX, Start
from polhode.closed_forms.attitude.quaternion import Quaternion, product
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.functions.jacobi import Functions, Jacobi, jacobi
