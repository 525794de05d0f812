"""A certificate of stability: that of a proved orbit, and how the jets of its return map are made.

Nothing here is believed but the body's and the level's numbers.
"""

from __future__ import annotations

from polhode.certificates import verify
from polhode.certificates.certificate_file import Made, by_checker
from polhode.numbers.flint_context import ctx


def zero_of(orbit: Made) -> verify.Zero:
    """What the checker proves of an orbit's certificate; raises its NotProved."""
    return by_checker(verify.zero_near, orbit)


def twist_of(zero: verify.Zero, guide: verify.Guide) -> verify.Twist:
    """What the checker proves of the return map; raises its NotProved."""
    return by_checker(verify.twist_of, zero, guide)


def stated(orbit: Made, guide: verify.Guide, twist: verify.Twist, statement: Made) -> Made:
    """The certificate, with a statement that the checker compares with what it proved.

    ``orbit``: the certificate of the orbit; ``statement``: rotation and twist.
    """
    claim = orbit["statement"]
    assert isinstance(claim, dict)
    with ctx.workprec(guide.jet_bits + verify.COARSE):
        balls = verify.read_stability({**claim, **statement})[1]
        verify.check_twist(balls, twist)
    return {**orbit, "kind": "stability", **guide._asdict(), "statement": {**claim, **statement}}
