"""Files of polhode's own that somebody changed: archives of runs, kept parts of a verb's work."""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import polhode
from fuzz import hostile_values as values
from fuzz.generate import mangled
from polhode import cli
from polhode.dynamics.sections import jobs  # noqa: F401  (imported before memory is measured)
from polhode.runs.sweep import sweep_checkpoint

Work = Callable[[], Any]
Words = list[str]

# -- archives -------------------------------------------------------------------------------------


def archive(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A saved run, changed in its arrays, its JSON or its bytes, loaded and asked."""
    saved = Path("folder/in/run.npz")
    if not saved.exists():
        watched = replace(scene, events=(polhode.Event("nutation"),), outputs=("angles",))
        polhode.integrate(watched, at=[0, "0.5", 1]).save(saved)
    with np.load(saved) as file:
        held = {name: file[name] for name in file.files}
    about, told = json.loads(str(held["about"])), []
    for _ in range(random.choice((1, 1, 2))):
        turn, name = random.random(), random.choice([*held])
        if turn < 0.35:
            key, value = random.choice([*about]), random.choice(values.JSON)
            about[key] = value
            held["about"] = np.array(json.dumps(about))
            told.append(f"about.{key} = {value!r}")
        elif turn < 0.5:
            held["about"] = np.array(str(held["about"]).replace(*random.choice(values.TEXTS)))
            told.append("text of about")
        elif turn < 0.7:
            held[name] = random.choice(values.arrays(held[name]))
            told.append(f"{name}: {held[name].dtype} {held[name].shape}")
        elif turn < 0.8:
            del held[name]
            told.append(f"without {name}")
            break
        else:
            cells = held[name].ravel().astype(object)
            if cells.size:
                cells[random.randrange(cells.size)] = random.choice(values.CELLS)
            held[name] = np.array(cells.astype(str)).reshape(held[name].shape)
            told.append(f"a cell of {name}")
    out = io.BytesIO()
    np.savez(out, **held)
    text = mangled(random, out.getvalue()) if random.random() < 0.2 else out.getvalue()
    Path("folder/in/changed.npz").write_bytes(text)

    def load() -> None:
        found = polhode.load_run("folder/in/changed.npz")
        _ = repr(found), found.drift, found.expected, found.state_strings(), found.time_strings()
        found("0.25")

    return "; ".join(told), load


# -- kept parts -----------------------------------------------------------------------------------

GENERAL = "general/asymmetric-regular"
KEEPERS: dict[str, Words] = {
    "sweep": ["sweep", "top.toml", "--vary", "start.omega[3]=1:2:40", "--workers", "1"],
    "section": ["section", GENERAL, "--grid", "2x2", "--crossings", "3", "--workers", "1"],
    "map": ["map", "lagrange/nutation", "--grid", "2x2", "--end", "10", "--workers", "1"],
}


class JobCheckpoint:
    """A verb's finished pieces in the middle of its work, and what it gives undisturbed."""

    def __init__(self, verb: str) -> None:
        self.words = [*KEEPERS[verb], "-o", f"folder/in/{verb}.npz"]
        self.whole = Path(f"folder/in/{verb}.npz")
        self.store = Path(f"folder/in/{verb}.store")
        self.folder = Path(f"folder/in/{verb}.npz.parts")
        every, sweep_checkpoint.EVERY = sweep_checkpoint.EVERY, 0.0
        removed = sweep_checkpoint.SweepCheckpoint.remove
        try:
            sweep_checkpoint.SweepCheckpoint.remove = lambda kept: kept.release()  # type: ignore[method-assign]
            from polhode.common.checkpoint import Checkpoint

            below = Checkpoint.remove
            Checkpoint.remove = lambda kept: kept.release()  # type: ignore[method-assign]
            assert cli.main([*self.words, "--json"]) == 0
            Checkpoint.remove = below  # type: ignore[method-assign]
        finally:
            sweep_checkpoint.SweepCheckpoint.remove, sweep_checkpoint.EVERY = removed, every  # type: ignore[method-assign]
        self.folder.rename(self.store)
        self.right = self.said()

    def said(self) -> dict[str, Any]:
        """The arrays of the result, but for what tells of this run."""
        with np.load(self.whole, allow_pickle=False) as held:
            return {name: held[name].tolist() for name in held.files if name != "about"}


_KEPT: dict[tuple[Path, str], JobCheckpoint] = {}


def kept(random: Random, scene: polhode.Scene) -> tuple[str, Work]:
    """A verb that finds pieces of before, one of them changed, and ends as if undisturbed."""
    verb = random.choice([*KEEPERS])
    known = _KEPT.get((Path.cwd(), verb)) or _KEPT.setdefault(
        (Path.cwd(), verb), JobCheckpoint(verb)
    )
    shutil.rmtree(known.folder, ignore_errors=True)
    shutil.copytree(known.store, known.folder)
    known.whole.unlink(missing_ok=True)
    piece = random.choice(sorted(known.folder.iterdir()))
    turn = random.random()
    if turn < 0.3 or piece.suffix == ".json":
        piece.write_bytes(mangled(random, piece.read_bytes()))
        told = f"bytes of {piece.name}"
    elif turn < 0.5:
        other = random.choice(sorted(known.folder.glob("*-*.npz")))
        piece.write_bytes(other.read_bytes())
        told = f"{other.name} as {piece.name}"
    elif turn < 0.6:
        piece.unlink()
        told = f"without {piece.name}"
    else:
        with np.load(piece, allow_pickle=False) as file:
            held = {name: file[name] for name in file.files}
        name = random.choice([*held])
        held[name] = random.choice(values.arrays(held[name]))
        np.savez(piece, **held)
        told = f"{name} of {piece.name}: {held[name].dtype} {held[name].shape}"

    def again() -> None:
        manifest = (known.folder / "manifest.json").read_bytes()
        changed = manifest != (known.store / "manifest.json").read_bytes()
        code = cli.main([*known.words, "--json"])
        if code == 2 and changed:  # of another work: refused, and left as it is
            shutil.rmtree(known.folder)
            raise polhode.BadInput("parts", "parts", None, "of this work")
        assert code == 0, code
        assert known.said() == known.right, "another result"
        assert not known.folder.exists()

    return f"{verb}: {told}", again
