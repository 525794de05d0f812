"""``polhode frequencies``: the lines of a motion, from a scene or from a trajectory file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.common.errors import BadInput
from polhode.scenes import library
from polhode.verbs.terminal import DONE, note, positive, print_json, print_table, word

HELP = "frequency analysis (Laskar) of a motion, from a scene or a trajectory file"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "what_of", type=word, metavar="SCENE|FILE", help="a case, a scene's path, or a CSV"
    )
    of = "signals: p+iq, gamma1+i gamma2, p, q, r, gamma1, gamma2, gamma3, axis (p+iq,gamma3)"
    parser.add_argument("--of", metavar="S,S...", help=of)
    parser.add_argument("--end", metavar="T", help="integrate to this time (the scene's end)")
    parser.add_argument("--lines", type=positive, metavar="N", help="lines of each signal (6)")
    parser.add_argument(
        "-o", dest="file", type=word, metavar="FILE", help="a figure, .svg, .png or .pdf"
    )


def main(options: Namespace) -> int:
    """Find the lines and print them."""
    from polhode.dynamics.frequencies.frequencies import LINES, frequencies
    from polhode.figures.canvas import canvas
    from polhode.output import frequencies as output
    from polhode.verbs.answer_file import answer_file

    inputs = [library.path_of(options.what_of)]
    file = answer_file(options.file, canvas.SUFFIXES, inputs, options.json)
    of = None if options.of is None else [name.strip() for name in options.of.split(",")]
    if of is not None and "" in of:
        raise BadInput(options.what_of, "--of", options.of, "names of signals, commas between")
    found = frequencies(options.what_of, of, options.end, options.lines or LINES)
    if file is not None:
        file.draw(found, found.name)
    if options.json:
        print_json(output.of_frequencies(found))
        return DONE
    if file is not None and file.on_stdout:
        return DONE
    rows = []
    for signal, lines in found.lines.items():
        for line in lines:
            number = f"{line.frequency:.{_digits(line.frequency, line.error)}g}"
            words = output.words(line.combination)
            amplitude = f"{abs(line.amplitude):.6g}"
            rows.append([signal, number, f"{line.error:.1e}", amplitude, words])
    print_table(["signal", "frequency", "error", "amplitude", "combination"], rows)
    for signal, lines in found.lines.items():
        if not lines:
            note(f"{found.name}: {signal} has no line above rounding")
    kind = "closed form" if found.closed_form else "basis"
    told = ", ".join(f"{name} = {value:.15g}" for name, value in found.known.items())
    if told:
        note(f"{found.name}: {kind}: {told}")
    return DONE


def _digits(frequency: float, error: float) -> int:
    """Significant digits that the error leaves, and one more."""
    import math

    if not frequency or error >= abs(frequency):
        return 2
    return max(2, min(17, math.ceil(math.log10(abs(frequency) / error)) + 1))
