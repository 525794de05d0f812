"""``polhode about``: versions, number types, processor, caches."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

from polhode.common import citation
from polhode.common.provenance import __version__, cpu, versions
from polhode.numbers import number_types
from polhode.scenes import library
from polhode.verbs.terminal import DONE, print_json, say

HELP = "versions, number types, processor, caches; how to cite"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("--cite", action="store_true", help="BibTeX entries, nothing else")


def main(options: Namespace) -> int:
    """Versions, number types, processor, caches; or how to cite."""
    if options.cite:
        if options.json:
            print_json({"bibtex": citation.bibtex(), "version": __version__})
        else:
            say(citation.bibtex().rstrip())
        return DONE
    facts: dict[str, Any] = {
        "versions": versions(),
        "cpu": cpu(),
        "number_types": {
            n.name: {"bits": n.bits, "digits": round(n.most_digits, 1)}
            for n in (number_types.named(name) for name in number_types.NAMES)
        },
        "cases": len(library.names()),
        "cache": _cache(),
        "refined": _self_test(),
    }
    if options.json:
        print_json(facts)
        return DONE
    told: dict[str, str] = {**facts["versions"], "cpu": facts["cpu"]}
    for name, held in facts["number_types"].items():
        size = "any number of bits" if name == "mp" else f"{held['bits']} bits"
        told[name] = size + ("" if name == "mp" else f", {held['digits']} digits")
    cache = facts["cache"]
    told["cases"] = str(facts["cases"])
    told["cache"] = "off"
    if cache["enabled"] and "fault" not in cache:
        held, most = (f"{cache[key] / 1e6:.0f} MB" for key in ("bytes", "limit"))
        told["cache"] = f"{held} in {cache['path']}, at most {most} (POLHODE_CACHE_MB bounds it)"
    if "fault" in cache:
        told["cache"] = f"none, every run compiles again ({' '.join(cache['fault'].split())})"
    told["refined"] = facts["refined"]
    for name, fact in told.items():
        say(f"{name:<12} {fact}")
    return DONE


def _cache() -> dict[str, object]:
    from polhode.taylor.backend import engine, heyoka_numbers

    if not engine.installed:
        return {"enabled": False, "path": None, "bytes": None, "limit": None, "fault": "no heyoka"}
    return heyoka_numbers.cache()


def _self_test() -> str:
    """Whether runs of quad and more digits can be refined here."""
    from polhode.refined.errors import CannotRefine
    from polhode.refined.refinement import QUAD
    from polhode.refined.self_test import trusted_kernels, trusted_tables
    from polhode.taylor.backend import engine

    if not engine.installed:
        return "not here: no heyoka"
    try:
        trusted_kernels(QUAD.limbs)
        trusted_tables(QUAD.limbs, QUAD.nodes(6))
    except CannotRefine as fault:
        return f"not here: {fault}"
    return "self-test passed"
