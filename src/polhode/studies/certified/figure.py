"""Figure of the study of certified digits: digits lost over time, and the price of a proof."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import as_svg, pyplot

_CASES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
_LOOKS = {
    "proof": ("#000000", "o"),
    "mp": ("#cc79a7", "^"),
    "quad": ("#009e73", "D"),
    "quad, refined": ("#56b4e9", "v"),
    "double": ("#0072b2", "s"),
}


def svg(found: dict[str, Any]) -> str:
    """Digits lost over time, and CPU seconds, from the study's JSON object."""
    plt = pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
    for colour, row in zip(_CASES, found["growth"], strict=False):
        left.plot(row["times"], row["lost"], "o-", color=colour, ms=3, lw=1, label=row["case"])
        left.plot(row["times"], row["lost_without"], "--", color=colour, lw=1)
    left.set_xscale("log")
    left.set_xlabel("t (units of the scene)")
    left.set_ylabel("digits lost (dashed: without the integrals)")
    left.legend(frameon=False, fontsize=8)
    left.grid(lw=0.3, color="#dddddd")
    names = [f"{row['case']}, {row['digits']} digits" for row in found["cost"]]
    for key, (colour, mark) in _LOOKS.items():
        points = [
            (seconds, len(names) - 1 - k)
            for k, row in enumerate(found["cost"])
            for name, seconds in row["seconds"].items()
            if name == key or (key == "mp" and name.startswith("mp"))
        ]
        x, y = zip(*points, strict=True) if points else ((), ())
        right.plot(x, y, mark, color=colour, ms=5, ls="none", label=key)
    right.set_xscale("log")
    right.set_yticks(range(len(names)), names[::-1], fontsize=7)
    right.set_ylim(-0.7, len(names) - 0.3)
    right.set_xlabel("CPU seconds to the same time")
    right.grid(lw=0.3, color="#dddddd")
    figure.legend(
        *right.get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False
    )
    return as_svg(figure)
