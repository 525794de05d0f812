"""What is installed here, as a result: what ``polhode about`` shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from polhode.common import provenance
from polhode.common.provenance import __version__, cpu, versions
from polhode.common.values import ByValue
from polhode.numbers import number_types
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library


@dataclass(frozen=True, repr=False, eq=False)
class About(Result, ByValue):
    """What there is to tell of this installation; ``is_citation``: how to cite it, alone."""

    installation: Mapping[str, Any]
    is_citation: bool = False

    def __repr__(self) -> str:
        return f"<About polhode {__version__}>"

    def __str__(self) -> str:
        if self.is_citation:
            return str(self.installation["bibtex"]).rstrip()
        facts = {**self.installation["versions"], "cpu": self.installation["cpu"]}
        for name, bits, digits in _NUMBERS:
            facts[name] = "any number of bits" if name == "mp" else f"{bits} bits, {digits} digits"
        facts |= {key: self.installation[key] for key in ("cases", "cache", "refined")}
        facts["cache"] = _in_words(facts["cache"])
        return "\n".join(f"{name:<12} {value}" for name, value in facts.items())

    def table(self) -> Table:
        """One row per number type: its bits, and the digits that these hold."""
        names, bits, digits = zip(*_NUMBERS, strict=True)
        return Table([Column("number", names), Column("bits", bits), Column("digits", digits)])

    def facts(self) -> list[Fact]:
        """Versions, processor, cases, the cache of compiled code; or how to cite."""
        return [Fact(name, value) for name, value in self.installation.items()]


_NUMBERS = [
    (x.name, x.bits, round(x.most_digits, 1)) for x in map(number_types.named, number_types.NAMES)
]


def about(cite: bool = False) -> About:
    """Tell versions, number types, processor, caches; or how to cite.

    Parameters
    ----------
    cite : bool
        BibTeX entries, nothing else.
    """
    if cite:
        return About({"bibtex": provenance.bibtex()}, is_citation=True)
    return About(
        {
            "versions": dict(versions()),
            "cpu": cpu(),
            "cases": len(library.names()),
            "cache": _cache(),
            "refined": _refinement(),
        }
    )


def _in_words(cache: Mapping[str, Any]) -> str:
    if "fault" in cache:
        return f"none, every run compiles again ({' '.join(cache['fault'].split())})"
    if not cache["enabled"]:
        return "off"
    size, most = (f"{cache[key] / 1e6:.0f} MB" for key in ("bytes", "limit"))
    return f"{size} in {cache['path']}, at most {most} (POLHODE_CACHE_MB bounds it)"


def _cache() -> Mapping[str, object]:
    from polhode.taylor import heyoka

    if not heyoka.installed:
        return {"enabled": False, "path": None, "bytes": None, "limit": None, "fault": "no heyoka"}
    return heyoka.compiled_code_cache()


def _refinement() -> str:
    """Whether runs of quad and more digits can be refined here."""
    from polhode.refined.collocation_tables import tables
    from polhode.refined.compiled_field import CannotRefine, kernels
    from polhode.refined.refinement import QUAD
    from polhode.taylor import heyoka

    if not heyoka.installed:
        return "not here: no heyoka"

    try:
        kernels(QUAD.limbs)
        tables(QUAD.limbs, QUAD.nodes(6))
    except CannotRefine as fault:
        return f"not here: {fault}"
    return "compiled"
