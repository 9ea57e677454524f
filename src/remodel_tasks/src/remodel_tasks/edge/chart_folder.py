"""The folder of the task charts."""

from __future__ import annotations

import re
from pathlib import Path

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_production.edge.text_file import write_text
from remodel_production.errors import InstanceError


def keep_chart(chart: Chart, folder: Path) -> tuple[Path, bool]:
    """Write a chart unless it is there, unchanged; return its file, and whether it was written.

    Raises:
        InstanceError: if the folder or the file cannot be written.
    """
    file = folder / f"{re.sub(r'[^a-z0-9]+', '_', chart.name.lower()).strip('_')}.xml"
    text = write_chart(chart)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if file.is_file() and file.read_text(encoding="utf-8") == text:
            return file, False
    except (OSError, UnicodeDecodeError) as error:
        raise InstanceError(f"{file}: cannot be used: {error}") from error
    write_text(file, text)
    return file, True
