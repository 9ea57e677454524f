"""A console and its pages in Chromium, for tests of whatever stands behind them."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

from playwright.sync_api import Browser, Locator, Page, expect, sync_playwright

LIMIT_S = 60.0
_POLL_S = 0.02
_IN_PASSING = ".q-notifications { display: none; }"  # what a picture leaves out
WEBGL_WITHOUT_GPU = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_WHERE = "(path) => document.querySelector('.canvas-frame').drawing.where(path)"
_OVERFLOW = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"

expect.set_options(timeout=LIMIT_S * 1000)


class BrowserTest(unittest.TestCase):
    """Starts a console and Chromium once for all tests of a class, and ends all it has started.

    Chromium is its headless shell: without the browser's own surfaces, a page takes less than half
    the processor time.

    Attributes:
        first_page: address of the page that each test begins on.
        folder: of this class alone; the home folder of what is started.
        environment: of what is started.
        record: file in which the console records commands.
        settings: file that keeps the console's configuration.
        graphics: options of Chromium; three dimensions need a GPU, which WEBGL_WITHOUT_GPU emulates
            at the cost of more processor time than the rest of a page.
    """

    first_page: ClassVar[str] = "/overview"
    graphics: ClassVar[tuple[str, ...]] = ("--disable-gpu",)
    folder: ClassVar[Path]
    environment: ClassVar[dict[str, str]]
    port: ClassVar[int]
    record: ClassVar[Path]
    settings: ClassVar[Path]
    processes: ClassVar[dict[str, subprocess.Popen[bytes]]]
    browser: ClassVar[Browser]

    @classmethod
    def setUpClass(cls) -> None:
        """Start console and browser; what must be there before is for `prepare`."""
        cls.folder = Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        ros_home = os.environ.get("ROS_HOME", str(Path("~/.ros").expanduser()))
        cls.environment = {**os.environ, "HOME": str(cls.folder), "ROS_HOME": ros_home}
        cls.port = free_port()
        cls.record = cls.folder / "commands.jsonl"
        cls.settings = cls.folder / "settings.json"
        cls.processes = {}
        cls.addClassCleanup(cls.end_all)
        cls.prepare()
        cls.start_console()
        driver = sync_playwright().start()
        cls.addClassCleanup(driver.stop)
        cls.browser = driver.chromium.launch(
            executable_path=shutil.which("chromium-headless-shell"),
            args=["--no-sandbox", "--disable-dev-shm-usage", *cls.graphics],
        )
        cls.addClassCleanup(cls.browser.close)

    @classmethod
    def prepare(cls) -> None:
        """Start the nodes that the console connects to."""

    def setUp(self) -> None:
        """Open the first page."""
        self.page = self.open_page()

    # Pages

    def open_page(
        self,
        address: str | None = None,
        width: int = 1280,
        height: int = 800,
        port: int | None = None,
    ) -> Page:
        """Return a page of a browser of its own; a mistake in its scripts fails the test."""
        context = self.browser.new_context(viewport={"width": width, "height": height})
        self.addCleanup(context.close)
        page = context.new_page()
        page.set_default_timeout(1000 * LIMIT_S)
        mistakes: list[object] = []
        page.on("pageerror", lambda mistake: mistakes.append(mistake))
        self.addCleanup(lambda: self.assertEqual(mistakes, []))
        page.goto(f"http://127.0.0.1:{port or self.port}{address or self.first_page}")
        return page

    def open_tablet_in_the_dark(self, address: str, shown: str) -> Page:
        """Return a dark page as wide as a tablet, with nothing beyond its edge."""
        page = self.open_page(address, width=1024, height=768)
        page.get_by_role("button", name="Dark or light").click()
        page.wait_for_function("() => document.cookie.includes('=dark')")
        page.reload()
        expect(page.locator("body.body--dark")).to_have_count(1)
        expect(page.locator(shown).first).to_be_visible()
        self.assertEqual(page.evaluate(_OVERFLOW), 0)
        return page

    def take_picture(self, page: Page, name: str) -> None:
        """Keep a picture of a page if CONSOLE_PICTURES names a folder."""
        folder = os.environ.get("CONSOLE_PICTURES")
        if folder:
            page.mouse.move(0, 0)
            file = Path(folder) / f"{name}.png"
            page.screenshot(path=file, animations="disabled", style=_IN_PASSING)

    def press(self, page: Page | Locator, name: str) -> None:
        """Press a button."""
        page.get_by_role("button", name=name, exact=True).click()

    def where(self, page: Page, path: str) -> tuple[float, float]:
        """Return where a state is drawn on a page, `Search/Look`, once it is [pixels]."""
        page.locator(f".canvas-outline [data-path='{path}']").first.wait_for(state="attached")
        found = page.evaluate(_WHERE, path)
        return found["x"], found["y"]

    def pick_drawn(self, page: Page, path: str) -> None:
        """Click a state in a drawing."""
        page.mouse.click(*self.where(page, path))

    def choose(self, page: Page, label: str, option: str, *, exact: bool = False) -> None:
        """Choose an option of a select."""
        page.get_by_role("combobox", name=label, exact=exact).click()
        page.get_by_role("option", name=option, exact=True).click()
        expect(page.get_by_role("option")).to_have_count(0)

    def wait_until(
        self, is_so: Callable[[], Any], what: str = "it", limit_s: float = LIMIT_S
    ) -> None:
        """Wait for a condition, while the browser goes on."""
        end_s = time.monotonic() + limit_s
        while not is_so():
            self.assertLess(time.monotonic(), end_s, f"waited {limit_s:.0f} s for {what}")
            self.page.wait_for_timeout(1000 * _POLL_S)

    # Processes

    @classmethod
    def start_console(cls) -> None:
        """Start the console; again, if it was killed."""
        cls.start_console_at("console", cls.port)

    @classmethod
    def start_console_at(cls, name: str, port: int, *options: str, **environment: str) -> None:
        """Start a console at a port, and return when it listens."""
        kept = ("--record", str(cls.record), "--settings", str(cls.settings))
        line = ("--port", str(port), *kept, *options)
        cls.start(name, "remodel_console", "console", *line, **environment)
        end_s = time.monotonic() + LIMIT_S
        while not _listens(port):
            if time.monotonic() > end_s or cls.processes[name].poll() is not None:
                raise TimeoutError(f"the console does not listen on {port}")
            threading.Event().wait(_POLL_S)

    @classmethod
    def start(cls, name: str, *line: str, **environment: str) -> None:
        """Start a node: package, executable, arguments."""
        cls.processes[name] = subprocess.Popen(
            ["rosrun", *line], env=cls.environment | environment, start_new_session=True
        )

    @classmethod
    def kill(cls, name: str) -> None:
        """End a process without a word."""
        process = cls.processes.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(LIMIT_S)

    @classmethod
    @contextmanager
    def stalled(cls, name: str) -> Iterator[None]:
        """Keep a process from computing meanwhile, as an overloaded computer does."""
        group = cls.processes[name].pid
        os.killpg(group, signal.SIGSTOP)
        try:
            yield
        finally:
            os.killpg(group, signal.SIGCONT)

    @classmethod
    def end(cls, *names: str) -> None:
        """End processes as Ctrl+C does."""
        ending = [cls.processes.pop(name) for name in names]
        for process in ending:
            os.killpg(process.pid, signal.SIGINT)
        for process in ending:
            process.wait(LIMIT_S)

    @classmethod
    def end_all(cls) -> None:
        """End all that was started and still runs."""
        cls.end(*tuple(cls.processes))


def free_port() -> int:
    """Return a port that is free."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
