"""What the behavior that is edited can do at most, on the editor's page."""

from __future__ import annotations

from nicegui import run, ui

from remodel_console.core.editor.inspection import Inspection, certificate_html

_NONE = "A chart with errors has no certificate."


class CertificatePanel:
    """Shows the certificate, as it is written when the chart is saved."""

    def __init__(self) -> None:
        """Build an empty panel."""
        self._words = ui.label(_NONE).classes("soft")
        self._tables = ui.html("", sanitize=False).classes("wide certificate")
        self._shown: Inspection | None = None

    async def show(self, inspection: Inspection) -> None:
        """Show what holds for the chart as it was checked last."""
        if inspection is self._shown:
            return
        self._shown = inspection
        certificate = await run.io_bound(inspection.certify)
        if inspection is self._shown:
            self._words.set_visibility(certificate is None)
            self._tables.set_content("" if certificate is None else certificate_html(certificate))
