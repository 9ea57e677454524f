"""Where charts and behaviors lie: find them by name, read them, check and write them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.codec import read_chart, write_chart
from flexbe_synthesizer.core.fold import fold
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.machine_reader import read_machine
from flexbe_synthesizer.core.model import Chart, State, walk_nodes
from flexbe_synthesizer.core.problem import Problem, errors_in
from flexbe_synthesizer.core.resolve import scopes
from flexbe_synthesizer.edge.chart_files import confined_to, find_chart, read_charts
from flexbe_synthesizer.edge.chart_memory import ChartMemory
from flexbe_synthesizer.edge.inventory import Inventory, read_inventory
from flexbe_synthesizer.edge.output_package import OutputPackage, enclosing_package
from flexbe_synthesizer.errors import OutputError, SynthesisError
from flexbe_synthesizer.synthesis import CheckedFiles, check_files, write_behaviors
from remodel_console.errors import CommandError


@dataclass(frozen=True)
class Workspace:
    """The folders that charts are read from, and the ROS package path.

    Attributes:
        ros_package_path: on which packages, their charts, states and behaviors are found.
        more_folders: returns the other folders that hold charts now.
        memory: has the charts that were read and checked before.
    """

    ros_package_path: str
    more_folders: Callable[[], Iterable[Path]] = tuple
    memory: ChartMemory = field(default_factory=ChartMemory, compare=False, repr=False)

    @property
    def chart_folders(self) -> tuple[Path, ...]:
        """Return `charts/` of all packages that export behaviors, then the other folders."""
        packages = self._inventory().packages
        return (*(p.folder / "charts" for p in packages if p.has_behaviors), *self.more_folders())

    def folder_words(self) -> Iterator[tuple[Path, str]]:
        """Yield each chart folder, and what a person calls it."""
        packages = self._inventory().packages
        owners = {package.folder / "charts": package.name for package in packages}
        for folder in self.chart_folders:
            if folder in owners:
                yield folder, f"charts of the package {owners[folder]}"
            elif folder.is_relative_to(Path.home()):
                yield folder, f"~/{folder.relative_to(Path.home())}"
            else:
                yield folder, str(folder)

    def find(self, name: str) -> Chart:
        """Return the chart of a behavior; one without a chart is read back from its code.

        Raises:
            CommandError: if there is no such behavior, or no chart says what it does.
        """
        found = {chart.name: chart for chart in self.charts()}
        if name in found:
            return found[name]
        inventory = self._inventory()
        packages, library = inventory.packages, inventory.library
        behaviors = {behavior.name: behavior for behavior in library.behaviors}
        if name not in behaviors:
            hint = names.allowed(name, sorted({*found, *behaviors}))
            raise CommandError(f"there is no behavior '{name}'; {hint}")
        behavior = behaviors[name]
        package = next(p for p in packages if p.name == behavior.package)
        code = package.module_folder.joinpath(*behavior.module.split(".")[1:]).with_suffix(".py")
        try:
            machine = read_machine(code.read_text(encoding="utf-8"), str(code), library)
            chart = fold(machine, str(code))
        except (OSError, ValueError) as error:
            raise CommandError(f"'{name}' has no chart, and its code is none: {error}") from error
        file = package.folder / "charts" / f"{names.behavior_file(name)}.xml"
        return replace(chart, file=str(file))

    def read(self, path: str) -> Chart:
        """Return the chart of a file that lies in the chart folders.

        Raises:
            CommandError: if it cannot be read, or is wrong.
        """
        try:
            folders = self.chart_folders
            file = find_chart(path, folders)
            self._expect_right(self._check(file))
            return read_charts([file], confined_to(folders)).charts[0]
        except SynthesisError as error:
            raise CommandError(str(error)) from error

    def check(self, chart: Chart) -> tuple[Problem, ...]:
        """Return all that is wrong with a chart and those that it names.

        Raises:
            CommandError: if a file cannot be read.
        """
        return self._checked(chart).problems

    def look(self, text: str, file: str) -> CheckedFiles:
        """Return the chart in a text as if it stood in a file, and all that is wrong with it.

        Raises:
            CommandError: if a chart that it names cannot be read.
        """
        return self._check(file, {file: text.encode("utf-8", "surrogatepass")})

    def library(self) -> Library:
        """Return the states and behaviors that are installed."""
        return self._inventory().library

    def files(self) -> tuple[str, ...]:
        """Return the names of the files in the chart folders, as `read` takes them."""
        folders = self.chart_folders
        return tuple(sorted({p.name for folder in folders for p in folder.glob("*.xml")}))

    def text_of(self, path: str) -> str:
        """Return the text of a file in the chart folders; empty if it cannot be read."""
        try:
            return Path(find_chart(path, self.chart_folders)).read_text(encoding="utf-8")
        except (SynthesisError, OSError, ValueError):
            return ""

    def events(self, chart: Chart) -> dict[str, dict[str, tuple[str, ...]]]:
        """Return the events of the nodes by id, by the name of the container that they are in."""
        (checked, *_) = self._checked(chart).charts.values()
        return {
            scope.chart.name: {node: entry.use.events or () for node, entry in scope.by_id.items()}
            for scope in scopes(checked.resolved)
        }

    def save(self, chart: Chart) -> tuple[Path, ...]:
        """Write a chart and its behavior, and return the files that changed.

        Raises:
            CommandError: if it has errors, or cannot be written; then nothing is.
        """
        files = self._checked(chart)
        self._expect_right(files)
        try:
            return write_behaviors(files, {Path(chart.file): write_chart(chart)})
        except OutputError as error:
            raise CommandError(str(error)) from error

    def users_of(self, state: str) -> Iterator[str]:
        """Yield where charts use a state class, `package.Class` or `Class`."""
        package, _, class_name = state.rpartition(".")
        spellings = {class_name}
        spellings |= {f"{package}/{class_name}", f"{package}__{class_name}"} if package else set()
        for chart in self.charts():
            for node in walk_nodes(chart):
                if isinstance(node, State) and node.type in spellings:
                    yield f"{chart.name}: {node.id} ({chart.file})"

    def charts(self) -> Iterator[Chart]:
        """Yield all charts of the folders that can be read."""
        for folder in self.chart_folders:
            for path in sorted(folder.glob("*.xml")):
                try:
                    chart, _problems = read_chart(path.read_bytes(), str(path))
                except OSError:
                    continue  # what cannot be read cannot be edited
                if chart is not None:
                    yield chart

    def _inventory(self) -> Inventory:
        return read_inventory(self.ros_package_path)

    def _checked(self, chart: Chart) -> CheckedFiles:
        return self.look(write_chart(chart), chart.file)

    def _check(self, path: str, drafts: dict[str, bytes] | None = None) -> CheckedFiles:
        library = self.library()
        locate = confined_to((*self.chart_folders, Path(path).parent))
        try:
            return check_files(
                [path], library, _package_of, locate, drafts or {}, memory=self.memory
            )
        except SynthesisError as error:
            raise CommandError(str(error)) from error

    @staticmethod
    def _expect_right(files: CheckedFiles) -> None:
        errors = errors_in(files.problems)
        if errors:
            lines = "\n".join(map(str, errors))
            raise CommandError(f"{len(errors)} error{'s' * (len(errors) > 1)}:\n{lines}")


def _package_of(path: str) -> OutputPackage:
    return enclosing_package(Path(path))
