"""Where charts and behaviors lie: find, read, check and write them; what is installed.

Until Python 3.11.4, all threads count the depth of their syntax trees in one variable, so that two
which parse at the same time fail with "AST constructor recursion depth mismatch" (CPython issue
106905). Pages, the log and commands of the console parse charts and behaviors on threads of their
own.
"""

from __future__ import annotations

import ast
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import wraps
from pathlib import Path

from flexbe_core.engine.supervision import checksum
from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart, State, walk_nodes
from flexbe_synthesizer.core.chart.names import behavior_file
from flexbe_synthesizer.core.chart.problem import ChartError, errors_in
from flexbe_synthesizer.core.chart.xml_tree import decoded
from flexbe_synthesizer.core.library.resolve import scopes
from flexbe_synthesizer.core.library.signature import BehaviorClass, Library, StateClass
from flexbe_synthesizer.core.machine.lift import lift
from flexbe_synthesizer.core.machine.machine_reader import read_machine
from flexbe_synthesizer.edge.chart_files import (
    LARGEST_FILE,
    ChartMemory,
    chart_names,
    confined_to,
    find_chart,
    read_chart_file,
    read_charts,
)
from flexbe_synthesizer.edge.files import read_regular_text, write_all
from flexbe_synthesizer.edge.output_package import (
    OutputPackage,
    enclosing_package,
    expect_found,
    output_package,
    unwritten_package,
)
from flexbe_synthesizer.edge.package_path import Inventory, read_inventory
from flexbe_synthesizer.errors import ChartFileError, OutputError, SynthesisError
from flexbe_synthesizer.synthesis import CheckedFiles, check_files, write_behaviors
from remodel_console.core.editing import Draft, new_draft, read_draft
from remodel_console.core.inspection import Inspection, uses_by_path
from remodel_console.errors import ChartErrorsError, CommandError, FileChangedError
from remodel_run.whole_task import counted

# Beside a chart: what was saved of it while it had errors. No program but the editor reads it.
_KEPT = ".draft"
_READ_WITHIN_S = 10.0  # all charts of the folders; a person waits for them


@dataclass(frozen=True)
class ChartFolders:
    """Folders of charts. Files that are no charts, or cannot be read, are skipped."""

    folders: tuple[Path, ...]

    def files(self) -> tuple[str, ...]:
        """Return the names of the files in them."""
        return tuple(sorted({p.name for folder in self.folders for p in folder.glob("*.xml")}))

    def names(self) -> Iterator[tuple[str, Path]]:
        """Yield name and file of each chart.

        Raises:
            CommandError: if that takes too long.
        """
        return chart_names(self.folders, self._deadline())

    def too_large(self) -> Iterator[tuple[str, str]]:
        """Yield name and reason of each file that is not opened since it is too large."""
        for folder in self.folders:
            for path in sorted(folder.glob("*.xml")):
                if path.is_file() and path.stat().st_size > LARGEST_FILE:
                    size = f"{path.stat().st_size / 2**20:.1f} MiB"
                    yield path.name, f"{path} has {size}; charts have {LARGEST_FILE >> 20} at most"

    def kept_drafts(self) -> Iterator[tuple[str, Draft]]:
        """Yield name and draft of what was kept of charts that were never saved."""
        for folder in self.folders:
            for path in sorted(folder.glob(f"*.xml{_KEPT}")):
                file = path.with_suffix("")
                if file.exists():
                    continue
                try:
                    draft = read_draft(read_chart_file(path), str(file))
                except (ChartFileError, CommandError):
                    continue
                yield draft.chart.name, replace(draft, origin=None)

    def contents(self) -> Iterator[tuple[Path, bytes]]:
        """Yield file and content of each chart.

        Raises:
            CommandError: if that takes too long.
        """
        locate, expect_time = confined_to(self.folders), self._deadline()
        for _name, path in self.names():
            expect_time()
            try:
                yield path, read_chart_file(locate(str(path)))
            except ChartFileError:
                continue

    def expect_own(self, draft: Draft, file: Path) -> None:
        """Refuse to write a chart where another one is, or was meanwhile.

        Raises:
            CommandError: if the file or the behavior would be overwritten.
        """
        try:
            now = read_chart_file(file) if file.exists() else None
        except (ChartFileError, OSError) as error:
            raise CommandError(str(error)) from error
        if now is not None and now != draft.origin:
            raise FileChangedError(
                f"{file} was changed elsewhere since it was "
                f"{'opened' if draft.origin is None else 'loaded'}, and saving would undo that; "
                "load it again, or save this chart under another name",
                now.decode(errors="replace"),
            )
        if now is None and draft.origin is not None:
            return  # it was deleted: saving brings it back
        own = behavior_file(draft.chart.name)
        for name, path in self.names():
            is_beside = path.parent == file.parent and path.resolve() != file.resolve()
            if is_beside and behavior_file(name) == own:
                raise CommandError(
                    f"'{draft.chart.name}' and '{name}' of {path} become the same behavior; "
                    "rename one of them"
                )

    def _deadline(self) -> Callable[[], None]:
        end = time.monotonic() + _READ_WITHIN_S

        def expect_time() -> None:
            if time.monotonic() > end:
                where = ", ".join(map(str, self.folders))
                raise CommandError(
                    f"reading the chart folders takes more than {_READ_WITHIN_S:g} s; move other "
                    f"files out of {where}"
                )

        return expect_time


def kept_file(file: Path) -> Path:
    """Return where the draft of a chart is kept, beside the chart's file."""
    return file.with_name(file.name + _KEPT)


OUTPUT = "remodel_behaviors"  # package of the behaviors whose charts lie in none, as of the server
_SHIPPED = ("remodel_", "flexbe_")  # what names of packages that are no user's begin with
GENERATED = "remodel_order_behaviors"  # package that the supervisor writes, a chart for each task


@dataclass(frozen=True)
class Workspace:
    """The folders that charts are read from, and the ROS package path.

    Attributes:
        ros_package_path: on which packages, their charts, states and behaviors are found.
        more_folders: returns the other folders that hold charts now.
        output: package to which behaviors go whose charts lie in no package.
        memory: has the charts that were read and checked before.
    """

    ros_package_path: str
    more_folders: Callable[[], Iterable[Path]] = tuple
    output: str = OUTPUT
    memory: ChartMemory = field(default_factory=ChartMemory, compare=False, repr=False)

    @property
    def chart_folders(self) -> tuple[Path, ...]:
        """Return `charts/` of all packages that export behaviors, then the other folders."""
        packages = self._inventory().packages
        return (*(p.folder / "charts" for p in packages if p.has_behaviors), *self.more_folders())

    @property
    def own_folder(self) -> Path:
        """Return where a user's new chart goes: into a package of the user, if there is one."""
        packages = [package for package in self._inventory().packages if package.has_behaviors]
        folders = {package.name: package.folder / "charts" for package in packages}
        own = [name for name in folders if not name.startswith(_SHIPPED)]
        if self.output in own:
            return folders[self.output]
        if own:
            return folders[own[0]]
        return next(iter((*self.more_folders(), *folders.values())))

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
        """Return the chart of a behavior; see `load`."""
        return self.load(name).chart

    def load(self, name: str) -> Draft:
        """Return the chart of a behavior, and its text; one without is read back from its code.

        Raises:
            CommandError: if there is no such behavior, or no chart says what it does.
        """
        found = dict(self._folders().names())
        if name in found:
            path = found[name]
            try:
                content = read_chart_file(confined_to(self.chart_folders)(str(path)))
            except ChartFileError as error:
                raise CommandError(str(error)) from error
            return read_draft(content, str(path))
        return self._from_code(name, found)

    def never_saved(self, name: str) -> Draft | None:
        """Return the draft of a chart that was kept and never saved; None without it."""
        return dict(self._folders().kept_drafts()).get(name)

    def kept(self, draft: Draft) -> Draft | None:
        """Return what was kept of a chart after it was saved last; None if nothing was.

        A draft that is older than the chart stays on the disk, and is not opened over the chart.
        """
        chart = Path(draft.chart.file)
        file = kept_file(chart)
        try:
            if not file.exists() or (
                chart.exists() and file.stat().st_mtime_ns < chart.stat().st_mtime_ns
            ):
                return None
            return draft.retyped(decoded(read_chart_file(file), str(file)))
        except (OSError, ChartFileError, ChartError, CommandError):
            return None  # it is left as it is

    def keep(self, draft: Draft) -> Path:
        """Keep a chart that cannot be saved, beside its file; the engine never runs it.

        Raises:
            CommandError: if it cannot be written.
        """
        file = kept_file(Path(draft.chart.file))
        try:
            write_all({file: draft.content})
        except OutputError as error:
            raise CommandError(f"the draft is not kept: {error}") from error
        return file

    @staticmethod
    def has_file(path: str) -> bool:
        """Return whether there is a file of a path."""
        return Path(path).exists()

    def names(self) -> tuple[str, ...]:
        """Return the names of all charts."""
        folders = self._folders()
        return tuple({**dict(folders.names()), **dict(folders.kept_drafts())})

    def too_large(self) -> dict[str, str]:
        """Return why files of the folders are not opened, by name."""
        return dict(self._folders().too_large())

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
        return self._folders().files()

    def text_of(self, path: str) -> str:
        """Return the text of a file in the chart folders; empty if it cannot be read."""
        try:
            return read_chart_file(Path(find_chart(path, self.chart_folders))).decode()
        except (SynthesisError, ValueError):
            return ""

    def events(self, chart: Chart) -> dict[str, dict[str, tuple[str, ...]]]:
        """Return the events of the nodes by id, by the name of the container that they are in."""
        (checked, *_) = self.look(write_chart(chart), chart.file).charts.values()
        return {
            scope.chart.name: {node: entry.use.events or () for node, entry in scope.by_id.items()}
            for scope in scopes(checked.resolved)
        }

    def save(self, draft: Draft) -> tuple[Path, ...]:
        """Write a chart as its text is, and its behavior; return the files that changed.

        Raises:
            CommandError: if it has errors, its file or behavior is another one's by now, or it
                cannot be written; then nothing is.
        """
        file = Path(draft.chart.file)
        self._folders().expect_own(draft, file)
        files = self._check(str(file), {str(file): draft.text.encode()}, is_written=True)
        self._expect_right(files)
        try:
            for path, one in files.charts.items():
                expect_found(one.resolved.chart.name, files.packages[path], self._inventory())
            written = write_behaviors(files, {file.resolve(): draft.content})
        except OutputError as error:
            raise CommandError(str(error)) from error
        kept_file(file).unlink(missing_ok=True)
        return written

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
        for path, content in self._folders().contents():
            chart, _problems = read_chart(content, str(path))
            if chart is not None:
                yield chart

    def _inventory(self) -> Inventory:
        return read_inventory(self.ros_package_path)

    def _folders(self) -> ChartFolders:
        return ChartFolders(self.chart_folders)

    def _from_code(self, name: str, charts: Iterable[str]) -> Draft:
        """Return what the code of a behavior without a chart says."""
        inventory = self._inventory()
        packages, library = inventory.packages, inventory.library
        behaviors = {behavior.name: behavior for behavior in library.behaviors}
        if name not in behaviors:
            hint = names.allowed(name, sorted({*charts, *behaviors}))
            raise CommandError(f"there is no behavior '{name}'; {hint}")
        behavior = behaviors[name]
        package = next(p for p in packages if p.name == behavior.package)
        code = _file(package.module_folder, behavior.module)
        try:
            machine = read_machine(read_regular_text(code), str(code), library)
            chart = lift(machine, str(code))
        except (OSError, ValueError) as error:
            raise CommandError(f"'{name}' has no chart, and its code is none: {error}") from error
        file = package.folder / "charts" / f"{names.behavior_file(name)}.xml"
        return new_draft(replace(chart, file=str(file)))

    def _check(
        self, path: str, drafts: dict[str, bytes] | None = None, *, is_written: bool = False
    ) -> CheckedFiles:
        library = self.library()
        locate = confined_to((*self.chart_folders, Path(path).parent))
        package_of = self._package_of if is_written else _package_to_check_in
        try:
            return check_files(
                [path], library, package_of, locate, drafts=drafts or {}, memory=self.memory
            )
        except SynthesisError as error:
            raise CommandError(str(error)) from error

    def _package_of(self, path: str) -> OutputPackage:
        """Return the package that a chart lies in, else the one for all others."""
        try:
            return enclosing_package(Path(path))
        except OutputError:
            packages = self._inventory().packages
            folder = next((p.folder for p in packages if p.name == self.output), None)
            if folder is None:
                raise OutputError(
                    f"{path} lies in no ROS package, and there is no package '{self.output}' on "
                    "the ROS package path to write its behavior to; keep the chart in charts/ of "
                    "a package, or start the console with a package as `output`"
                ) from None
            return output_package(folder)

    @staticmethod
    def _expect_right(files: CheckedFiles) -> None:
        errors = errors_in(files.problems)
        if errors:
            lines = "\n".join(map(str, errors))
            text = f"{counted(len(errors), 'error')}:\n{lines}"
            raise ChartErrorsError(text, len(errors))


def _package_to_check_in(path: str) -> OutputPackage:
    """Return the package that a chart lies in, or one that stands for it: nothing is written."""
    try:
        return enclosing_package(Path(path))
    except OutputError:
        return unwritten_package(Path(path).parent)


def inspect_text(workspace: Workspace, text: str, file: str) -> tuple[Chart | None, Inspection]:
    """Return the chart that a text has the form of, if it has, and what the checks say about it."""
    chart, problems = workspace.memory.read(text.encode("utf-8", "surrogatepass"), file)
    is_formed = chart is not None and not errors_in(problems)
    try:
        files = workspace.look(text, file)
    except CommandError as error:
        return (chart if is_formed else None), Inspection(problems, unchecked=str(error))
    own = files.charts.get(file)
    uses = uses_by_path(own.resolved) if own else {}
    order = sorted(files.problems, key=lambda problem: problem.position.file != file)
    package = files.packages[file].name if own else ""
    found = Inspection(tuple(order), uses, checked=own, package=package)
    return (chart if is_formed else None), found


@dataclass(frozen=True)
class Installed:
    """A behavior that is installed.

    Attributes:
        behavior_id: by which the engine finds it.
        source_checksum: by which the engine publishes that it runs, and verifies the version.
    """

    behavior: BehaviorClass
    behavior_id: int
    source_checksum: int

    @property
    def name(self) -> str:
        """Return its display name."""
        return self.behavior.name


@dataclass(frozen=True)
class Catalogue:
    """What the packages of a ROS package path offer at the moment of each call."""

    ros_package_path: str

    def behaviors(self) -> tuple[Installed, ...]:
        """Return the behaviors that are installed, by name."""
        inventory = self._inventory()
        folders = {package.name: package.module_folder for package in inventory.packages}
        found = []
        for behavior in inventory.library.behaviors:
            text = _text(_file(folders[behavior.package], behavior.module))
            if text is not None:
                found.append(Installed(behavior, checksum(behavior.module), checksum(text)))
        return tuple(sorted(found, key=lambda one: one.name))

    def states(self) -> tuple[StateClass, ...]:
        """Return the state classes that are installed, by package and name."""
        return tuple(
            sorted(self._inventory().library.states, key=lambda state: (state.package, state.name))
        )

    def documentation(self, state: StateClass) -> str:
        """Return the docstring of a state class; empty if there is none."""
        packages = self._inventory().packages
        folder = next((p.module_folder for p in packages if p.name == state.package), None)
        text = _text(_file(folder, state.module)) if folder else None
        for node in ast.parse(text or "").body:
            if isinstance(node, ast.ClassDef) and node.name == state.name:
                return ast.get_docstring(node) or ""
        return ""

    def _inventory(self) -> Inventory:
        return read_inventory(self.ros_package_path)


def _file(folder: Path, module: str) -> Path:
    return folder.joinpath(*module.split(".")[1:]).with_suffix(".py")


def _text(file: Path) -> str | None:
    try:
        return read_regular_text(file)
    except (OSError, ValueError):
        return None


_FIXED = (3, 11, 5)


def lock_parsing() -> None:
    """Have `ast.parse`, and what calls it, wait for other threads; call it once, at the start."""
    if sys.version_info >= _FIXED:
        return
    parse, lock = ast.parse, threading.Lock()

    @wraps(parse)
    def parse_alone(*arguments: object, **named: object) -> ast.AST:
        with lock:
            return parse(*arguments, **named)  # type: ignore[call-overload, no-any-return]

    ast.parse = parse_alone  # type: ignore[assignment]
