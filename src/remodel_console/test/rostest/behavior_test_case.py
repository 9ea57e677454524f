"""What tests share that need behaviors of their own, most of them with an engine and a mirror."""

import shutil
import subprocess
from pathlib import Path
from typing import ClassVar

from playwright.sync_api import expect

from remodel_console.testing.browser_test import BrowserTest

CHARTS = Path(__file__).parents[1] / "charts"
PACKAGE_XML = """<package format="3"><name>console_test_behaviors</name><version>0.1.0</version>
<description>Made by a test.</description><maintainer email="a@b.org">A</maintainer>
<license>BSD-3-Clause</license><export><flexbe_behaviors/></export></package>"""


class BehaviorTestCase(BrowserTest):
    """Starts everything with a package of behaviors of its own.

    Attributes:
        more_charts: texts of charts that a class has besides those in `test/charts`, by file name.
        has_engine: engine and mirror are started.
        package: folder of the package.
    """

    more_charts: ClassVar[dict[str, str]] = {}
    has_engine: ClassVar[bool] = True

    @classmethod
    def prepare(cls):
        cls.package = cls.folder / "console_test_behaviors"
        shutil.copytree(CHARTS, cls.package / "charts")
        for name, text in cls.more_charts.items():
            (cls.package / "charts" / name).write_text(text)
        (cls.package / "package.xml").write_text(PACKAGE_XML)
        for variable, folder in (("ROS_PACKAGE_PATH", "."), ("PYTHONPATH", "src")):
            cls.environment[variable] = f"{cls.package / folder}:{cls.environment[variable]}"
        charts = map(str, sorted((cls.package / "charts").glob("*.xml")))
        line = ["rosrun", "flexbe_synthesizer", "synthesize", *charts]
        subprocess.run(line, env=cls.environment, check=True, timeout=180)
        if cls.has_engine:
            cls.start_engine()
            cls.start_mirror()

    @classmethod
    def start_engine(cls):
        cls.start("engine", "flexbe_onboard", "start_behavior", "_start_at:=true")

    @classmethod
    def start_mirror(cls):
        cls.start("mirror", "flexbe_mirror", "behavior_mirror_sm")

    def write_xml(self, text):
        """Replace the chart in the editor's XML tab."""
        self.page.get_by_role("tab", name="XML").click()
        shown = self.page.locator(".cm-content")
        # A tab that opens gets its text a little later.
        expect(shown).to_contain_text("<statemachine")
        # By keys, as a person does: CodeMirror may draw its lines again between selecting and
        # typing, which loses a selection of the page but none of its own.
        shown.click()
        self.page.keyboard.press("Control+a")
        self.page.keyboard.insert_text(text)
