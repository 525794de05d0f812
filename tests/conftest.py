"""What holds for every test: the caller's precision is none that polhode would choose."""

import contextlib
import importlib
import os
import re
import signal
import sys
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any

import mpmath
import pytest
from hypothesis import HealthCheck, settings

# one thread of linear algebra: the matrices are small, and there is a process a core already
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# no example fails for a slow machine; CI draws the same ones each time and twice as many as others,
# who draw new ones
settings.register_profile(
    "polhode",
    deadline=None,
    derandomize="CI" in os.environ,
    max_examples=50 if "CI" in os.environ else 25,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("polhode")


def pytest_configure() -> None:
    """Tests of Ctrl-C need the signal, which a job in the background is started without."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True)
def callers_precision() -> Iterator[None]:
    """Plain mpmath at far more bits than any test asks for: what polhode gives is not rounded.

    Nothing in polhode may depend on it; see ``numbers/test_threads.py`` for other precisions.
    """
    with mpmath.workprec(6000):
        yield


@pytest.fixture(autouse=True)
def handlers_of_signals() -> Iterator[None]:
    """The command line, called in this process, leaves its handlers of signals: not to the next."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(autouse=True, scope="session")
def options_of_doubles() -> Iterator[Callable[..., dict[str, Any]]]:
    """Code is compiled unoptimised, in a sixth of the time; these are a user's options of double.

    In the wider types the bits are the same: an x87 or library operation has no faster form, and
    quad is never optimised, by polhode's own choice.  Doubles are as right, but their last bits are
    others, as most products and sums are rounded apart: see ``compiled_as_for_users``.
    """
    from polhode.taylor import heyoka

    doubles = heyoka._TYPES["double"]
    with pytest.MonkeyPatch.context() as patch:
        for name in ("double", "extended", "mp"):
            options = heyoka._TYPES[name]
            patch.setitem(heyoka._TYPES, name, lambda n, o=options: o(n) | {"opt_level": 0})
        yield doubles


@pytest.fixture(scope="session")
def engines_for_users() -> dict[Hashable, list[Any]]:
    """The idle engines of the tests whose doubles are compiled as for users."""
    return {}


@pytest.fixture
def compiled_as_for_users(
    monkeypatch: pytest.MonkeyPatch,
    options_of_doubles: Callable[..., dict[str, Any]],
    engines_for_users: dict[Hashable, list[Any]],
) -> None:
    """Doubles have a user's bits in this test: it prints digits, or asks other processes."""
    from polhode.taylor import engine, heyoka

    monkeypatch.setitem(heyoka._TYPES, "double", options_of_doubles)
    monkeypatch.setattr(engine, "IDLE", engines_for_users)


@pytest.fixture
def no_idle_engines(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """No compiled engine is left to be lent, now and whenever this is called."""
    from polhode.taylor import engine

    def forget() -> None:
        monkeypatch.setattr(engine, "IDLE", {})

    forget()
    return forget


@pytest.fixture
def parts_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Finished jobs are kept as soon as they are there, not every few seconds."""
    from polhode.common import checkpoint

    monkeypatch.setattr(checkpoint, "EVERY", 0.0)


@pytest.fixture
def quick_changes() -> Iterator[None]:
    """Threads take turns far more often than they would."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


@pytest.fixture
def refusal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    """The one line of a command that is refused in the test's folder, where it changes nothing."""
    from polhode import cli

    monkeypatch.chdir(tmp_path)

    def contents() -> dict[Path, object]:
        """What stands in the folder, links as links."""
        links = {path: path.readlink() for path in Path().iterdir() if path.is_symlink()}
        return {path: path.is_file() and path.read_bytes() for path in Path().rglob("*")} | links

    def line(*words: object) -> str:
        before = contents()
        capsys.readouterr()
        code = cli.main([*map(str, words)])
        out, err = capsys.readouterr()
        assert (code, out) == (2, "")
        assert re.fullmatch(r"polhode: [^\n]+: expected [^\n]+\n", err), err
        assert err[:-1].isprintable()
        assert contents() == before
        return err

    return line


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Each worker begins with its share of the files, whose compiled form the others then find.

    Where all were to begin with the first file, each of them would compile every file for itself.
    """
    worker = getattr(session.config, "workerinput", None)
    if worker is None or session.config.args_source is not pytest.Config.ArgsSource.TESTPATHS:
        return
    number, count = int(worker["workerid"].removeprefix("gw")), worker["workercount"]
    for path in sorted(Path(__file__).parent.rglob("test_*.py"))[number::count]:
        sys.path[:0] = [] if str(path.parent) in sys.path else [str(path.parent)]
        with contextlib.suppress(Exception, pytest.skip.Exception):  # met again by pytest
            importlib.import_module(path.stem)
