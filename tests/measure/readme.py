"""Numbers of the README and the guide from the report: ``python tests/measure/readme.py`` puts
them in.

They stand between two comments each; ``tests/test_documents.py`` compares them with ``reports/``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from textwrap import fill
from typing import Any

from polhode.studies import report
from polhode.studies.long_run.page import far_table
from polhode.studies.speed.draws import DRAWS
from polhode.studies.speed.page import SUMMARY_OUTPUTS, standing, summary

ROOT = Path(__file__).parents[2]
WIDTH = 118
#: Where each part stands.
PLACES = {
    "summary": ROOT / "README.md",
    "speed": ROOT / "src/polhode/guide/measured.md",
    "far": ROOT / "src/polhode/guide/measured.md",
    "proofs": ROOT / "src/polhode/guide/measured.md",
}


def parts() -> dict[str, str]:
    """The texts by their names."""
    speed = report.results(ROOT / "reports", "speed")
    table, refined = standing(speed["cells"]).markdown, _paragraph("speed", "a refined run takes")
    far = far_table(report.results(ROOT / "reports", "long-run"))
    return {
        "summary": _summary(speed),
        "speed": f"{table}\n\n{refined}",
        "far": far._replace(again="").markdown,
        "proofs": _paragraph("proofs", "The checker of certificates"),
    }


def _summary(speed: dict[str, Any]) -> str:
    """The table of four lengths and of many starts, and where it was measured."""
    origin = speed["provenance"]
    versions = ", ".join(f"{name} {origin['versions'][name]}" for name in ("polhode", "heyoka"))
    kinds = {cell["kind"] for cell in speed["cells"]}
    conditions = (
        f"Medians over {len(kinds)} kinds of motion of {DRAWS} bodies each (in n of m: in so many "
        "of the kinds both reach the digits), "
        f"{SUMMARY_OUTPUTS} outputs (many starts: the end), one thread; "
        f"{versions}, {origin['cpu']}. [All rows and rules](reports/speed.md)."
    )
    return f"{summary(speed['cells']).markdown}\n\n{fill(conditions, WIDTH)}"


def _paragraph(study: str, words: str) -> str:
    """The one paragraph of a study's page that has these words."""
    page = report.page(report.results(ROOT / "reports", study))
    found = [text for text in page.split("\n\n") if words in " ".join(text.split())]
    (one,) = found
    return fill(" ".join(one.split()), WIDTH, break_long_words=False, break_on_hyphens=False)


def put_in(text: str, path: Path) -> str:
    """The text of a file with today's parts."""
    for name, part in parts().items():
        if PLACES[name] != path:
            continue
        pattern = rf"(<!-- {name}: [^>]*-->\n).*?(<!-- end -->)"
        made = f"{part}\n" if part else ""
        text, count = re.subn(pattern, lambda m, p=made: m[1] + p + m[2], text, flags=re.DOTALL)
        if count != 1:
            raise ValueError(f"{path.name} has {count} places for {name}")
    return text


if __name__ == "__main__":
    for path in dict.fromkeys(PLACES.values()):
        sys.stdout.write(f"{path}\n")
        path.write_text(put_in(path.read_text(encoding="utf-8"), path), encoding="utf-8")
