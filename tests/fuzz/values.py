"""Values that nobody should give: as TOML, as words of a command, as cells, and in Python."""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.numbers.mpmath_context import mpf


def _apart(text: str) -> list[str]:
    return [part for line in text.strip().splitlines() for part in line.split(" ; ")]


#: TOML text of a value.
TOML = _apart(r"""
nan ; inf ; -inf ; 1e400 ; -1e400 ; 1e-400 ; 1e4001 ; 1e99999999999 ; 0 ; -0.0 ; -1 ; 1e300
1e-300 ; true ; false ; [] ; {} ; [[]] ; "" ; " " ; "x" ; "1/0" ; "0**-1" ; "sqrt(-1)" ; "sqrt(2)"
"pi" ; "1/3" ; "9**9**9" ; "2**99999" ; "((((1))))" ; "1e5000" ; "sin(1e300)" ; "cos(10**4000)"
"+-+-1" ; "1 1" ; "1,2" ; "p" ; "t" ; "gamma3" ; "π" ; "\u0000" ; "\u001b[31m" ; "a\nb"
"\U0001F600" ; "1_000" ; "0x10" ; "1j" ; "nan" ; 1979-05-27 ; 07:32:00 ; 1979-05-27T07:32:00Z
0x1f ; 0b11 ; 0o17 ; 1_000_000 ; [1] ; [1, 2] ; [1, 2, 3] ; [1, 2, 3, 4] ; [0, 0, 0] ; [1, 1, 1]
[-1, 1, 1] ; [1, 1, 2] ; [1, 1, 2.0001] ; [nan, 1, 1] ; ["1/0", 1, 1] ; ["sqrt(2)", "sqrt(3)", 1]
[1, "a", 1] ; [true, 1, 1] ; [[1], 1, 1] ; [[1, 0, 0], [0, 1, 0], [0, 0, 1]] ; [[1, 2], [2, 1]]
[[1, 2, 0], [2, 1, 0], [0, 0, 1]] ; [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]] ; [1e-12, 1, 1]
[1e-300, 1e-300, 1e-300] ; [1e300, 1e300, 1e300] ; [1, 1e12, 1e12] ; [0.6, 0, 0.8] ; [0, 0, 1]
[0, 0, -1] ; [1e-30, 0, 1] ; [3, 4, 0] ; [0, 1] ; [1, 0] ; [0, 0] ; [1, -1] ; [1, 1] ; [0, 1e-400]
[5, 6, 7e9] ; "double" ; "mp" ; "quaternion" ; "angles" ; ["angles"] ; ["angles", "x"]
"hodographs" ; ["attitude", "hodographs"] ; "rising" ; "stop" ; "flip" ; "nutation" ; "section:p"
"section:" ; "1/(p-1)" ; "p-p" ; "sqrt(p)" ; "p**-3" ; "p**0.5" ; "sin(t)/t" ; "0*p" ; "euler"
"lagrange" ; "kovalevskaya" ; "pendulum" ; "two-precisions" ; "auto"
""")
TOML += ["9" * 400, "9" * 5000, "0." + "3" * 3000, f'"{"(" * 60}1{")" * 60}"']
TOML += [f'"{"1+" * 499}1"', f'"{"x" * 2000}"']

#: Words of a command line.
WORDS = _apart(r"""
- ; -- ; -1 ; 0 ; 1 ; 2 ; 1.5 ; 1e400 ; 1e-400 ; 1e300 ; 1e-300 ; nan ; inf ; -inf ; 1/0 ; 1/3 ; π
sqrt(-1) ; 0,1 ; 1,0 ; 1,1 ; 1,,2 ; , ; -1,-2 ; 1,-1 ; ../.. ; / ; /dev/null ; /dev/zero ; . ; ~ ; *
euler/* ; euler/separatrix ; euler/nothing ; EULER/SEPARATRIX ; top.toml ; double ; extended ; quad
mp ; Double ; float ; 0:1:3 ; 0:1:0 ; 0:1:99999999999 ; 0:1 ; 1:2 ; 2:1 ; 0:0 ; 1:1 ; 1e300:1e301
::: ; 2x2 ; 0x0 ; 1x1 ; 99999x99999 ; 2x ; p ; sqrt(q) ; 1/q ; momentum ; height ; orbit ; chaos
start.omega[1] ; start.omega[1]=1,2 ; start.omega[9]=1 ; body.weight=0:1:2 ; body.moments[1]=-1,2
start.omega[1]=0:1:100000000 ; = ; =1 ; start=1 ; title=1 ; a=b=c ; angles ; attitude,angles
hodographs ; angles,angles ; principal ; quaternion ; routhian ; motion ; x.csv ; x.npz ; x.svg
x.png ; x.txt ; x.html ; nowhere/x.csv ; table.csv ; latin.csv ; folder ; 40 ; 1e-9
""")
WORDS += ["", " ", "x" * 5000, "\x00", "\x1b[31m", "a\nb", "\udcff", "9" * 30, "9" * 5000]

#: Text of a table's cell.
CELLS = _apart("""
nan ; inf ; -inf ; 1e400 ; 1e-400 ; 1e5000 ; 1e99999999999 ; x ; 1/3 ; 0x10 ; 1,5 ; "1" ; " ; 1 1
--1 ; +1 ; .5 ; 5. ; . ; e5 ; 1e ; 1_0 ; ١ ; 1j ; true ; # ; null ; None
""")
CELLS += ["", " ", "9" * 400, "9" * 4001, "0." + "1" * 200, "1" * 3999, "\x00", "\x1b[0m"]

#: Headers of a table.
HEADERS = _apart("""
t ; p ; q ; r ; gamma1 ; gamma2 ; gamma3 ; psi ; theta ; phi ; q0 ; q1 ; q2 ; q3 ; time ; wx ; wy
wz ; omega_x ; yaw ; pitch ; roll ; T ; P ; x ; #t ; t,t ; psi_deg ; wx [deg/s] ; time [s] ; "p"
""")
HEADERS += ["", " ", "p ", "o1", "s1", "\x1b[0m", "n" * 5000]


class Odd:
    """An object that is nothing in particular."""

    def __repr__(self) -> str:
        return "Odd()\nover two lines"


#: Values in Python.
PYTHON: list[Any] = [
    *(None, True, False, 0, 1, -1, 2, 3, 10**6, 10**400, -(10**400), 0.5, -0.0, 1e300, 1e-300),
    *(math.nan, math.inf, -math.inf, 1j, Fraction(1, 3), mpf("0.1"), mpf("inf"), mpf("nan")),
    *("", " ", "x", "1", "1/3", "1/0", "sqrt(-1)", "1e400", "double", "mp", "euler/separatrix"),
    *("\x00", "\x1b[31m", "a\nb", "x" * 5000, b"", b"1", Odd(), Odd, object(), print, ...),
    *([], (), {}, set(), [1], [1, 2], [1, 2, 3], [1, 1, 1], ["1", "2", "3"], [0, 0, 1], [0, 1]),
    *([None, 1, 1], [math.nan, 1, 1], [[1], 1, 1], [1, 2, 3, 4], {"a": 1}, {1: 2}),
    *([[1, 2, 3]] * 3, range(3), range(0), np.array([1.0, 2.0, 3.0]), np.array([]), np.array(1.0)),
    *(np.eye(3), np.array(["a"]), np.array([1, 2])[0], np.array(True), {"x": [1]}),
    *({"start.omega[1]": [1, 2]}, {"start.omega[1]": "0:1:2"}, {"body.weight": None}),
]

#: What may stand anywhere in the JSON of a result or an archive, and should do no harm.
JSON: list[Any] = [
    *(None, True, False, 0, -1, 1, 10**30, 0.5, 1e308, "", "x", "nan", "1e999999999", "0x1p-52"),
    *([], {}, [1], [[]], {"a": 1}, "double", "mp", "reached end", "taylor", [{"name": "x"}]),
    *("1" * 5000, "\u202e", "\x00", ["h"] * 1000, {"onto": ["h"], "every": 0}),
    *({"t": 5}, {"run": []}, {"__class__": []}, {"reference": "/etc/passwd"}, {"kept": 0}),
]
