"""heyoka's things by kind: it brings no types along, and these names say what is meant."""

from __future__ import annotations

from typing import Any, TypeAlias

#: float, numpy.longdouble, heyoka.real128 or heyoka.real, by the number type of the run.
HeyokaNumber: TypeAlias = Any

#: heyoka.expression, of variables, parameters and the time.
Expression: TypeAlias = Any

#: heyoka.taylor_adaptive, or taylor_adaptive_batch: compiled code, state and time of a system.
HeyokaIntegrator: TypeAlias = Any

#: heyoka.nt_event or t_event, and their batch kinds.
HeyokaEvent: TypeAlias = Any

#: heyoka.taylor_outcome: how steps ended.
HeyokaOutcome: TypeAlias = Any

#: heyoka.continuous_output: the polynomials of some steps.
HeyokaOutput: TypeAlias = Any

#: heyoka.cfunc: compiled code of some expressions.
CompiledFunction: TypeAlias = Any
