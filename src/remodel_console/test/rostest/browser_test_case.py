"""What browser tests share: console, engine and mirror on a package of their own, Chromium."""

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import unittest
from pathlib import Path

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


class BrowserTestCase(unittest.TestCase):
    """Starts everything once for all tests of a class."""

    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp())
        cls.package = cls.folder / "console_test_behaviors"
        shutil.copytree(CHARTS, cls.package / "charts")
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
        cls.start_engine()
        cls.start_mirror()
        cls.start_console()
        driver = sync_playwright().start()
        cls.addClassCleanup(driver.stop)
        cls.browser = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.page = self.open_page()

    def open_page(self, address="/runtime", width=1280, height=800):
        """Return a page of a browser of its own; a mistake in its scripts fails the test."""
        context = self.browser.new_context(viewport={"width": width, "height": height})
        self.addCleanup(context.close)
        page = context.new_page()
        page.set_default_timeout(1000 * LIMIT_S)
        mistakes = []
        page.on("pageerror", lambda mistake: mistakes.append(mistake))
        self.addCleanup(lambda: self.assertEqual(mistakes, []))
        page.goto(f"http://127.0.0.1:{self.port}{address}")
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
        options = ("--port", str(cls.port), "--record", str(cls.record))
        cls.start("console", "remodel_console", "console", *options)
        cls.wait_for_port()

    @classmethod
    def wait_for_port(cls):
        """Return once the console answers: it prints its address when it is about to listen."""
        for _ in range(200):
            try:
                socket.create_connection(("127.0.0.1", cls.port), timeout=0.1).close()
            except OSError:
                if cls.processes["console"].poll() is not None:
                    raise
                cls.processes["console"].poll()
                subprocess.run(["sleep", "0.1"], check=True)
            else:
                return
        raise TimeoutError("the console does not listen")

    @classmethod
    def start(cls, name, *line):
        cls.processes[name] = subprocess.Popen(
            ["rosrun", *line], env=cls.environment, start_new_session=True
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
