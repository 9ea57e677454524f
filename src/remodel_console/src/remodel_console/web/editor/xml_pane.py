"""The XML of the chart that is edited: it follows the chart, and the chart what is typed."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from remodel_console.core.editor.inspection import Inspection

# What is typed into the XML means nothing else; but saving does, and is not the browser's.
_KEEP_KEYS = "(event) => { if (!(event.ctrlKey && event.key === 's')) event.stopPropagation(); }"
_TYPED_S = 0.4  # without a key pressed, after which typed XML is taken in


class XmlPane:
    """Shows the chart's XML.

    Attributes:
        text: what stands there, as far as it has been taken in.
        is_typing: the last change came from here, so the text stays as it was typed.
    """

    def __init__(self, take: Callable[[str], Awaitable[None]], *, is_dark: bool) -> None:
        """Build an empty pane; `take` gets the text after it was typed."""
        self.text = ""
        self.is_typing = False
        self._take = take
        self._editor = ui.codemirror(
            language="XML",
            line_wrapping=True,
            on_change=self._on_typed,
            theme="githubDark" if is_dark else "githubLight",
        ).classes("xml")
        self._editor.on("keydown", js_handler=_KEEP_KEYS)
        self._typed = ui.timer(_TYPED_S, self._take_typed, active=False, once=False)

    def show(self, text: str) -> None:
        """Show a chart's text, unless it is just being typed."""
        if not self.is_typing:
            self.text = text.replace("\r\n", "\n").replace("\r", "\n")  # as the page has it
            self._editor.set_value(self.text)

    def mark(self, inspection: Inspection, own: str) -> None:
        """Mark the lines of the problems in the file `own`."""
        self._editor.decorations = [
            {"kind": "line", "line": p.position.line, "class": f"xml-{p.code.severity.value}"}
            for p in inspection.problems
            if p.position.file == own and p.position.line > 0
        ]

    def reveal(self, line: int) -> None:
        """Show a line."""
        self._editor.reveal_line(line)

    def _on_typed(self) -> None:
        if (self._editor.value or "") != self.text:
            self._typed.deactivate()
            self._typed.activate()

    async def _take_typed(self) -> None:
        self._typed.deactivate()
        text = self._editor.value or ""
        if text != self.text:
            await self._take(text)
