"""One way for every result to leave a verb: files, JSON or a terminal; notes; the exit code."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common import files
from polhode.common.errors import BadInput
from polhode.verbs import options, scene_options, terminal
from polhode.verbs.catalogue import VERBS, Verb

if TYPE_CHECKING:
    from polhode.results.result import Result

_DATA = (".csv", ".json", ".npz", ".parquet")
_FIGURES = (".svg", ".png", ".pdf")


def add_options(parser: ArgumentParser, verb: Verb) -> None:
    """The options of a verb: its function's, those of its scene, its files."""
    function = options.front(verb.home, verb.function)
    options.add(parser, function, verb.named)
    scene_options.add(parser, verb.scene)
    for option, how in (verb.figure_options or {}).items():
        parser.add_argument(option, **how)
    endings = f"{', '.join(_endings(verb))}; may be repeated"
    if any(x.name == "parts" for x in function.parameters):
        endings += "; what was interrupted continues from FILE.parts"
    help_text = f"write a file, its ending says what: {endings}"
    parser.add_argument(
        "-o", dest="places", type=options.word, metavar="FILE", action="append", help=help_text
    )
    parser.set_defaults(main=partial(main, verb, function))


def _endings(verb: Verb) -> Sequence[str]:
    own = [x for x in verb.own if x not in _DATA]
    return [*own, *_DATA, *(() if verb.figure_options is None else _FIGURES)]


def main(verb: Verb, function: options.Front, namespace: Namespace) -> int:
    """Carry out a verb that is a function; the exit code."""
    from polhode.proofs.theorem import NotProved
    from polhode.scenes import library
    from polhode.verbs import notes

    arguments = {
        x.name: vars(namespace)[x.name]
        for x in function.parameters
        if verb.named.get(x.name, x.name) is not None and vars(namespace).get(x.name) is not None
    }
    inputs = [library.path_of(x) for x in _sources(arguments)]
    home = verb.home
    for name, kind in verb.other_kinds.items():
        if name in arguments:
            verb = VERBS.get(kind) or verb._replace(kind=kind)
    places = OutputFiles(verb, [*map(Path, namespace.places or ())], namespace.json, inputs)
    places.check()
    places.check_figure(vars(namespace))
    if verb.scene:
        from polhode.scenes.library import StartBox, load_box

        first = function.parameters[0].name
        source = arguments[first]
        if isinstance(source, list):
            arguments[first] = scene_options.applied_to_all(namespace, source, verb.scene)
        else:
            box = load_box(source) if verb.is_box else StartBox(library.load(source))
            scene = scene_options.applied(namespace, box.scene, verb.scene)
            namespace.scene = scene  # for notes: a pipe is read once
            arguments[first] = StartBox(scene, box.radii) if verb.is_box else scene
    with terminal.ProgressLine(verb.name) as line:
        try:
            module = import_module(home)
            arguments |= places.extras(function, line)
            try:
                several = arguments.pop(function.several, ())
                result, missed = getattr(module, function.name)(*several, **arguments), ""
            except terminal.NotEnough as fault:
                result, missed = fault.result, str(fault)
            written = places.write(result, vars(namespace), line)
            left_out = namespace.json or (verb.prints_rows and places.hold_rows)
            text = None if left_out else shown(result, arguments.get("details", False))
        except NotProved as why:
            line.clear()
            terminal.note(f"polhode: not proved: {why}")
            return terminal.NOT_REACHED
    if namespace.json:
        files.write_stdout(result.to_json())
    elif text is not None:
        (terminal.note if places.take_stdout else terminal.say)(text)
    for sentence in notes.of(verb, result, written, namespace):
        terminal.note(sentence)
    if missed:
        terminal.note(missed)
        return terminal.NOT_REACHED
    return code_of(result)


def _sources(values: Mapping[str, object]) -> Iterable[str]:
    """What may be a file that is read."""
    for value in values.values():
        yield from (x for x in (value if isinstance(value, list) else [value]) if type(x) is str)


class OutputFiles:
    """The files that a verb is to write."""

    def __init__(
        self, verb: Verb, paths: Sequence[Path], json: bool, inputs: Sequence[Path | None]
    ) -> None:
        self.verb, self.paths, self.json, self.inputs = verb, paths, json, inputs

    @property
    def take_stdout(self) -> bool:
        """Whether one of the files is the standard output."""
        return any(map(files.is_stdout, self.paths))

    @property
    def hold_rows(self) -> bool:
        """Whether one of the files has the rows of the result's table."""
        return any(not self._is_figure(x) and not self._is_own(x) for x in self.paths)

    def check(self) -> None:
        """Refuse, before any work is done, what cannot or must not be written; raises BadInput."""
        streams = [path for path in self.paths if files.is_stdout(path)]
        for path in streams:
            terminal.refuse_two_on_stdout(path, self.json)
        for path in self.paths:
            files.check_writable(path, _endings(self.verb), self.inputs)
            if self._is_figure(path):
                from polhode.figures import canvas

                canvas.pyplot()
            elif self._is_own(path):
                files.refuse_foreign(path)
                if ".json" in self.verb.own:
                    from polhode.certificates import certificate_file
                    from polhode.results.reader import refuse_facts

                    certificate_file.refuse_another(path)
                    refuse_facts(path)
            else:
                from polhode.results.reader import check_place

                check_place(path, self.verb.kind, self.inputs)
        places = {x.absolute() if files.is_stream(x) else x.resolve() for x in self.paths}
        if len(places) < len(self.paths) or len(streams) > 1:
            raise BadInput(str(self.paths[-1]), "-o", None, "each file once")

    def check_figure(self, values: Mapping[str, Any]) -> None:
        """Refuse options of a figure where none is written, and figures that there are not."""
        chosen = {x: values[x] for x in _figure_options(self.verb) if values[x] is not None}
        if not any(map(self._is_figure, self.paths)):
            for name, value in chosen.items():
                option = f"--{name.replace('_', '-')}"
                expected = f"it with a figure: -o FILE{_FIGURES[0]}"
                raise BadInput(self.verb.name, option, value, expected)
        elif "what" in chosen:
            from polhode.figures import catalogue

            catalogue.chosen(self.verb.kind, chosen["what"], self.verb.name)

    def extras(self, function: options.Front, line: terminal.ProgressLine) -> dict[str, object]:
        """What a function takes that no option says: how it shows progress, what it is for.

        Unfinished work is kept in ``parts`` beside the first file of data.
        """
        show = partial(line.show, what=self.verb.counts)
        calls = {
            "Progress": show,
            "Progress | bool": show,
            "Message": line.say,
            "ProgressLine": line,
        }
        extras = {x.name: calls[x.annotation] for x in function.parameters if x.annotation in calls}
        names = {x.name for x in function.parameters}
        if extras.get("forecast") == line.say:  # which stays
            extras["forecast"] = lambda text: terminal.note(f"{self.verb.name}: {text}")
        if "certificate" in names:
            extras["certificate"] = any(map(self._is_own, self.paths))
        data = [x for x in self.paths if not self._is_figure(x)]
        if "whole" in names:
            extras["whole"] = self.json or bool(data)
        if "parts" in names and data:
            from polhode.common import checkpoint

            extras["parts"] = checkpoint.beside(data[0])
        return extras

    def write(
        self, result: Result, values: Mapping[str, Any], line: terminal.ProgressLine
    ) -> Sequence[Path]:
        """Write all files or none, and tell them; none where what was interrupted is kept in parts,
        which go else.

        Files of a kind's own, which are checked as they are made, are written once all others are
        made.
        """
        checkpoint = getattr(result, "kept", None)
        if interrupted(result) and checkpoint is not None and checkpoint.folder.exists():
            return ()
        contents: dict[Path, str | bytes] = {}
        for path in self.paths:
            if self._is_figure(path):
                contents[path] = _drawn(result, path.suffix.lower(), self.verb, values)
            elif not self._is_own(path):
                from polhode.results import reader, writer

                content = result.content()
                reader.check_place(path, content.kind, self.inputs)
                contents |= writer.files(content, path)
        own = [x for x in self.paths if self._is_own(x)]
        if own and not getattr(result, "times", True):  # of nothing there is no certificate
            own = []
        for path in own:
            self._save(result, path, line)
        files.write_whole(contents)
        if checkpoint is not None:
            checkpoint.remove()
        return [*own, *contents]

    def _save(self, result: Any, path: Path, line: terminal.ProgressLine) -> None:
        """Write a file of the kind's own: a scene, a certificate."""
        if self.verb.checks:
            result.save(path, line.foretelling(partial(_foretell, result.scene.name)))
        else:
            result.save(path)

    def _is_figure(self, path: Path) -> bool:
        return path.suffix.lower() in _FIGURES

    def _is_own(self, path: Path) -> bool:
        suffix = path.suffix.lower()
        stream = files.is_stream(path) and suffix not in _DATA
        return bool(self.verb.own) and (suffix in self.verb.own or stream)


def _foretell(name: str, seconds: float) -> None:
    if seconds > 10:
        terminal.note(f"{name}: making the certificate will take about {seconds:.2g} s")


def _drawn(result: Result, suffix: str, verb: Verb, values: Mapping[str, Any]) -> bytes:
    """The figure of a result; of a run its scene's, integrated at as many times as curves need."""
    from polhode.figures import catalogue
    from polhode.figures.source import Request, drawing_of
    from polhode.verbs.notes import name_of

    drawing = drawing_of(result, values.get("what"), Request())
    for sentence in drawing.notes:
        terminal.note(sentence)
    chosen = {name: values.get(name) for name in _figure_options(verb) if name != "what"}
    return catalogue.drawn(drawing.subject, suffix, name_of(result), drawing.what, **chosen)


def _figure_options(verb: Verb) -> Sequence[str]:
    """The options of a verb's figures, by the names of the parameters of what draws."""
    return [option.removeprefix("--").replace("-", "_") for option in verb.figure_options or ()]


def shown(result: Any, details: bool = False) -> str:
    """A result on a terminal: its report, where it has one, else its table.

    ``details``: whether all that is known is asked for.
    """
    from polhode.results.cells import lines
    from polhode.results.result import Result as Base

    if details:
        return str(result.details())
    report = type(result).__str__
    if report not in (object.__str__, getattr(Base, "__str__", None)):
        return str(result)
    return "\n".join(lines(result.table()))


def interrupted(result: Result) -> bool:
    """Whether Ctrl-C ended the work."""
    return bool(getattr(result, "interrupted", False))


def code_of(result: Result) -> int:
    """The exit code that a result means."""
    if interrupted(result):
        checkpoint = getattr(result, "kept", None)
        if checkpoint is not None and checkpoint.folder.exists():
            terminal.note(f"polhode: the same command continues from {checkpoint.folder}")
        return terminal.INTERRUPTED
    if getattr(result, "passed", None) is False:
        return terminal.FAILED
    return terminal.DONE if getattr(result, "complete", True) else terminal.NOT_REACHED
