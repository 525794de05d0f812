"""Numbers of the README and the guide from the report: ``python tests/measure/readme.py`` puts
them in.

They stand between two comments each; ``tests/test_documents.py`` compares them with ``reports/``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from textwrap import fill

from polhode.studies import report
from polhode.studies.long_run.page import far_table

ROOT = Path(__file__).parents[2]
WIDTH = 118
#: Where each part stands.
PLACES = {
    "ahead": ROOT / "README.md",
    "many": ROOT / "README.md",
    "speed": ROOT / "src/polhode/guide/measured.md",
    "far": ROOT / "src/polhode/guide/measured.md",
    "proofs": ROOT / "src/polhode/guide/measured.md",
}


def parts() -> dict[str, str]:
    """The texts by their names."""
    ahead = _paragraph("speed", "A polhode propagator is ahead")
    far = far_table(report.results(ROOT / "reports", "long-run"))
    return {
        "ahead": ahead,
        "many": _paragraph("speed", "From an array of 100", rows_may_be_missing=True),
        "speed": f"{ahead}\n\n{_paragraph('speed', 'In quad a refined run takes')}",
        "far": far._replace(again="").markdown,
        "proofs": _paragraph("proofs", "The checker of certificates"),
    }


def _paragraph(study: str, words: str, rows_may_be_missing: bool = False) -> str:
    """The one paragraph of a study's page that has these words; or nothing, where that may be."""
    page = report.page(report.results(ROOT / "reports", study))
    found = [text for text in page.split("\n\n") if words in " ".join(text.split())]
    if rows_may_be_missing and not found:
        return ""
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
