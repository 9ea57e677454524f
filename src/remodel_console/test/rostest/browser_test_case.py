"""What browser tests share: console, engine and mirror on a package of their own, Chromium."""

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import ClassVar

from playwright.sync_api import expect, sync_playwright

HERE = Path(__file__).parent
CHARTS = HERE.parent / "charts"
CHROMIUM = shutil.which("chromium")
LIMIT_S = 20.0
PACKAGE_XML = """<package format="3"><name>console_test_behaviors</name><version>0.1.0</version>
<description>Made by a test.</description><maintainer email="a@b.org">A</maintainer>
<license>BSD-3-Clause</license><export><flexbe_behaviors/></export></package>"""

expect.set_options(timeout=LIMIT_S * 1000)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


class BrowserTestCase(unittest.TestCase):
    """Starts everything once for all tests of a class.

    Attributes:
        more_charts: texts of charts that a class has besides those in `test/charts`, by file name.
        has_engine: engine and mirror are started too.
        first_page: address of the page that each test begins on.
    """

    more_charts: ClassVar[dict[str, str]] = {}
    has_engine: ClassVar[bool] = True
    first_page: ClassVar[str] = "/runtime"

    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp())
        cls.package = cls.folder / "console_test_behaviors"
        shutil.copytree(CHARTS, cls.package / "charts")
        for name, text in cls.more_charts.items():
            (cls.package / "charts" / name).write_text(text)
        (cls.package / "package.xml").write_text(PACKAGE_XML)
        cls.environment = {
            **os.environ,
            "ROS_PACKAGE_PATH": f"{cls.package}:{os.environ['ROS_PACKAGE_PATH']}",
            "PYTHONPATH": f"{cls.package / 'src'}:{os.environ['PYTHONPATH']}",
        }
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        charts = map(str, sorted((cls.package / "charts").glob("*.xml")))
        subprocess.run(
            ["rosrun", "flexbe_synthesizer", "synthesize", *charts], env=cls.environment, check=True
        )
        cls.processes = {}
        cls.addClassCleanup(cls.end_all)
        cls.port = free_port()
        cls.record = cls.folder / "commands.jsonl"
        cls.settings = cls.folder / "settings.json"
        if cls.has_engine:
            cls.start_engine()
            cls.start_mirror()
        cls.start_console()
        driver = sync_playwright().start()
        cls.addClassCleanup(driver.stop)
        cls.browser = driver.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"],
        )
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.page = self.open_page()

    def open_page(self, address=None, width=1280, height=800, port=None):
        """Return a page of a browser of its own; a mistake in its scripts fails the test."""
        context = self.browser.new_context(viewport={"width": width, "height": height})
        self.addCleanup(context.close)
        page = context.new_page()
        page.set_default_timeout(1000 * LIMIT_S)
        mistakes = []
        page.on("pageerror", lambda mistake: mistakes.append(mistake))
        self.addCleanup(lambda: self.assertEqual(mistakes, []))
        page.goto(f"http://127.0.0.1:{port or self.port}{address or self.first_page}")
        return page

    def take_picture(self, page, name):
        """Keep a picture of a page, if somebody wants them."""
        folder = os.environ.get("CONSOLE_PICTURES")
        if folder:
            page.mouse.move(0, 0)
            page.screenshot(path=Path(folder) / f"{name}.png", animations="disabled")

    def choose(self, page, label, option):
        page.get_by_role("combobox", name=label).click()
        page.get_by_role("option", name=option, exact=True).click()
        expect(page.get_by_role("option")).to_have_count(0)

    @classmethod
    def start_engine(cls):
        cls.start("engine", "flexbe_onboard", "start_behavior")

    @classmethod
    def start_mirror(cls):
        cls.start("mirror", "flexbe_mirror", "behavior_mirror_sm")

    @classmethod
    def start_console(cls):
        cls.start_console_at("console", cls.port)

    @classmethod
    def start_console_at(cls, name, port, *options, **environment):
        kept = ("--record", str(cls.record), "--settings", str(cls.settings))
        line = ("--port", str(port), *kept, *options)
        cls.start(name, "remodel_console", "console", *line, **environment)
        end = time.monotonic() + LIMIT_S
        while not listens(port):
            if time.monotonic() > end or cls.processes[name].poll() is not None:
                raise TimeoutError(f"the console does not listen on {port}")
            threading.Event().wait(0.05)

    @classmethod
    def start(cls, name, *line, **environment):
        cls.processes[name] = subprocess.Popen(
            ["rosrun", *line], env=cls.environment | environment, start_new_session=True
        )

    @classmethod
    def kill(cls, name):
        """End a process without a word."""
        process = cls.processes.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(20)

    @classmethod
    def end_all(cls):
        for process in cls.processes.values():
            os.killpg(process.pid, signal.SIGINT)
        for process in cls.processes.values():
            process.wait(20)
