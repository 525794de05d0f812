"""The equations of motion in eleven forms, written once for any scalar.

Equation numbers such as (3.29) are those of H. M. Yehia, *Rigid Body Dynamics: A Lagrangian
Approach*, Birkhäuser 2022, chapter 3.
"""
