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
from polhode.studies.proofs import page as proofs_page
from polhode.studies.speed.page import contest

ROOT = Path(__file__).parents[2]
WIDTH = 118
#: Where each part stands.
PLACES = {
    "ahead": ROOT / "README.md",
    "speed": ROOT / "src/polhode/guide/measured.md",
    "far": ROOT / "src/polhode/guide/measured.md",
    "proofs": ROOT / "src/polhode/guide/measured.md",
}


def parts() -> dict[str, str]:
    """The texts by their names."""
    found = {
        name: report.results(ROOT / "reports", name) for name in ("speed", "long-run", "proofs")
    }
    return {
        "ahead": _ahead(found["speed"]),
        "speed": _speed(found["speed"]),
        "far": _far(found["long-run"]),
        "proofs": _filled(proofs_page.finding(found["proofs"])),
    }


def _ahead(found: Any) -> str:
    """How polhode stands beside other programs, in a few sentences."""
    return _filled(contest.short(found))


def _table(made: PageTable) -> str:
    return markdown("", [made._replace(again="")]).partition("\n\n")[2].strip()


def _speed(found: Any) -> str:
    """Who is ahead where, in sentences."""
    told = contest.finding(found), _refined(found["refined"])
    return "\n\n".join(map(_filled, told))


def _refined(rows: Any) -> str:
    """Refined runs in quad at their furthest on each motion."""
    last = {row["motion"]: row for row in rows if row["bits"] == 113 and "," not in row["motion"]}
    last |= {row["motion"]: row for row in rows if row["motion"] == "brick, w3 = 3"}
    told = ", ".join(
        f"1/{row['gain']:.0f} ({row['motion']}, t = {row['end']})" for row in last.values()
    )
    return f"In quad a refined run takes so much of the time of heyoka's own steps: {told}."


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
