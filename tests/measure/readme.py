"""Numbers of the README and the guide from the report: ``python tests/measure/readme.py`` puts
them in.

They stand between two comments each; ``tests/test_readme.py`` compares them with ``reports/``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from textwrap import fill
from typing import Any

from polhode.studies import report
from polhode.studies.long_run.page import far_table
from polhode.studies.page.blocks import PageTable, markdown
from polhode.studies.speed.page import lengths, verdicts

ROOT = Path(__file__).parents[2]
WIDTH = 104
#: Where each part stands.
PLACES = {
    "ahead": ROOT / "README.md",
    "speed": ROOT / "src/polhode/guide/measured.md",
    "far": ROOT / "src/polhode/guide/measured.md",
}


def parts() -> dict[str, str]:
    """The texts by their names."""
    found = {name: report.results(ROOT / "reports", name) for name in ("speed", "long-run")}
    return {
        "ahead": _ahead(found["speed"]["cells"]),
        "speed": _speed(found["speed"]),
        "far": _far(found["long-run"]),
    }


def _ahead(cells: Any) -> str:
    """Who is the fastest where, as a table: a row a number of digits, a column a length."""
    ends = sorted({cell["end"] for cell in cells})
    header = ("digits", *(f"t = {end}" for end in ends), "where another is ahead, or none arrives")
    rows = []
    for level in lengths.LEVELS:
        races = {end: lengths.race([c for c in cells if c["end"] == end], level) for end in ends}
        behind = [x for found in races.values() for x in found if not lengths.ahead(x)]
        alone = sum(found.count(None) for found in races.values())
        told = [f"{x.method} {x.factor:.2f}" for x in sorted(behind)]
        told += [f"none arrives in {alone}"] * (alone > 0)
        counts = (f"{sum(map(lengths.ahead, x))} of {len(x)}" for x in races.values())
        rows.append((f"{level:g}", *counts, "; ".join(told) or "–"))
    made = _table(PageTable(header, tuple(rows), "r" * (len(ends) + 1) + "l"))
    return f"{made}\n\n{_filled(lengths.beside_engine(cells))}"


def _table(made: PageTable) -> str:
    return markdown("", [made._replace(again="")]).partition("\n\n")[2].strip()


def _speed(found: Any) -> str:
    """Who is ahead where, in sentences."""
    told = [lengths.claim(found["cells"], x) for x in lengths.LEVELS] if "cells" in found else []
    regular = [m for m in found["motions"] if m["kind"] == "regular"]
    told += [verdicts.on_regular(found), _closest(regular), _engine(regular)]
    told += [lengths.beside_engine(found["cells"])] if "cells" in found else []
    return "\n\n".join(_filled(text) for text in (" ".join(told), _refined(found["refined"])))


def _closest(motions: Any) -> str:
    """Each program's seconds over ours where it comes closest, over the motions."""
    factors: dict[str, list[float]] = {}
    for motion in motions:
        for row in motion["verdict"]["peers"]:
            if row["least_factor"] is not None:
                factors.setdefault(row["method"], []).append(row["least_factor"])
    told = "; ".join(f"{name}: {_between(values)}" for name, values in factors.items())
    return f"Where each comes closest there, it takes so many times as long as polhode: {told}."


def _engine(motions: Any) -> str:
    """What a run takes beside heyoka written by hand."""
    rows = [m["verdict"]["engine"]["polhode double projected"] for m in motions]
    tight = _between([row["overhead_tightest"] for row in rows])
    most = max(row["overhead_most"] for row in rows)
    return (
        f"Beside heyoka written by hand a run to t = 1000 at the tolerance eps takes {tight} times "
        f"as long, a looser one up to {most:.2g} times: for checking the scene, exact output "
        "times, and putting the state back on its integrals."
    )


def _refined(rows: Any) -> str:
    """Refined runs in quad at their furthest on each motion."""
    last = {row["motion"]: row for row in rows if row["bits"] == 113 and "," not in row["motion"]}
    last |= {row["motion"]: row for row in rows if row["motion"] == "brick, w3 = 3"}
    told = ", ".join(
        f"1/{row['gain']:.0f} ({row['motion']}, t = {row['end']})" for row in last.values()
    )
    return f"In quad a refined run takes so much of the time of heyoka's own steps: {told}."


def _between(values: Any) -> str:
    return f"{min(values):.3g} to {max(values):.3g}"


def _filled(text: str) -> str:
    return fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def _far(found: Any) -> str:
    """The table of long runs."""
    return _table(far_table(found))


def put_in(text: str, path: Path) -> str:
    """The text of a file with today's parts."""
    for name, part in parts().items():
        if PLACES[name] != path:
            continue
        pattern = rf"(<!-- {name}: [^>]*-->\n).*?(<!-- end -->)"
        made = f"{part}\n"
        text, count = re.subn(pattern, lambda m, p=made: m[1] + p + m[2], text, flags=re.DOTALL)
        if count != 1:
            raise ValueError(f"{path.name} has {count} places for {name}")
    return text


if __name__ == "__main__":
    for path in dict.fromkeys(PLACES.values()):
        sys.stdout.write(f"{path}\n")
        path.write_text(put_in(path.read_text(encoding="utf-8"), path), encoding="utf-8")
