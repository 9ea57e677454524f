"""Behaviors as the files that they become."""

from collections.abc import Mapping

from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.export.render_python import render_python
from flexbe_synthesizer.core.machine.machine import Machine


def rendered(machine: Machine, manual: Mapping[str, str] | None = None) -> str:
    """Return the file of a behavior, with custom code by section."""
    return render_python(machine, lay_out(machine.root), manual or {})
