"""Who takes part in the study speed, and on which motions."""

from __future__ import annotations

from polhode.studies.speed import contenders, page
from polhode.studies.speed.contenders import reported


def test_what_is_slow_runs_on_some_long_motions_and_the_page_says_which():
    ran = {
        motion.name: {m.name for m in contenders.methods(motion, False) if reported(motion, m)}
        for motion in contenders.MOTIONS
    }
    on = {name: {x for x in ran if name in ran[x]} for name in set().union(*ran.values())}
    short = {"asymmetric body, chaotic"}
    assert on["SciPy LSODA, Python"] == on["diffrax Dopri8"]
    assert on["diffrax Dopri8"] == {"Euler top", "Kovalevskaya top"} | short
    assert contenders.TYPES_SHOWN in on["polhode mp projected"]
    assert "Euler top" not in on["polhode mp projected"] | on["polhode quad projected"]
    for name in ("polhode mp", "polhode double projected", "heyoka alone", "CyRK LSODA"):
        assert on[name] >= {m.name for m in contenders.MOTIONS if m.kind == "regular"}, name
    motions = [
        {
            "motion": m.name,
            "kind": m.kind,
            "end": m.end,
            "methods": [{"method": x} for x in ran[m.name]],
        }
        for m in contenders.MOTIONS
    ]
    told = page._left_out(motions)
    assert "SciPy LSODA, Python" in told
    assert "ran on Euler top and Kovalevskaya top alone" in told
    assert "CyRK" not in told
    assert page._left_out([m | {"methods": [{"method": "polhode"}]} for m in motions]) == ""
