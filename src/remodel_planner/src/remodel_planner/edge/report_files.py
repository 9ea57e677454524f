"""Write a run's report."""

import json
from pathlib import Path

from remodel_planner.core.reports.run_report import Report, render_html, report_data
from remodel_production.edge.design_files import package_folder
from remodel_states.edge.exported_tables import read_abilities


def write_report(report: Report, folder: Path) -> Path:
    """Write report.html and report.json into a folder and return the page's path."""
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / "report.html"
    template = package_folder("remodel_planner") / "templates/report.html.j2"
    colours = {row.name: row.colour for row in read_abilities().values() if row.colour}
    page.write_text(
        render_html(template.read_text(encoding="utf-8"), report, colours), encoding="utf-8"
    )
    data = json.dumps(report_data(report), indent=2, ensure_ascii=False)
    (folder / "report.json").write_text(data + "\n", encoding="utf-8")
    return page
