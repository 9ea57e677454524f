"""Texts in states that few pages are in have enough contrast; axe sees only what is shown."""

import re
from pathlib import Path

import pytest

CSS = Path(__file__).parents[2] / "src/remodel_console/web/static/console.css"
LEAST = 4.5  # WCAG 2.2, 1.4.3
# What of the sheet has which colour on which ground, in both themes.
TEXTS = {
    ".log .warning .severity": "sheet",
    ".log .error .severity, .log .error .text": "sheet",
    ".left-unsaved a": "warn-fill",
    ".violated": "sheet",
}


def luminance(colour):
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a, b):
    dark, light = sorted((luminance(a), luminance(b)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("theme", [":root", ".body--dark"])
@pytest.mark.parametrize(("selector", "ground"), TEXTS.items())
def test_a_text_stands_out_from_its_ground(theme, selector, ground):
    css = CSS.read_text()
    rule = css.partition(f"\n{theme} {{")[2].partition("}")[0]
    colours = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", rule))
    (name,) = re.findall(rf"\n{re.escape(selector)} {{ color: var\(--([\w-]+)\)", css)
    assert contrast(colours[name], colours[ground]) >= LEAST
