"""Ctrl-C during a run of a study: the run ends early, and the study with it."""

from __future__ import annotations

import pytest

from polhode.common.interrupts import heard
from polhode.studies.report import write_study


@pytest.mark.slow
def test_a_signal_that_ended_a_run_ends_the_study(tmp_path, monkeypatch):
    """A report went on and had a row of the interrupted run."""
    monkeypatch.setattr(heard, "came", False)
    names = []

    def tell(text):
        names.append(text)
        heard.came = True  # as the handler does while heyoka steps

    with pytest.raises(KeyboardInterrupt):
        write_study("accuracy", tmp_path, quick=True, tick=tell)
    assert len(names) == 1
    assert list(tmp_path.iterdir()) == []
