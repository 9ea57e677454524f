"""Importers of other packages are found by their entry points, and their errors name them."""

import re
import textwrap

import pytest

from remodel_production.core.imports.design_format import Asked
from remodel_production.core.imports.formats import format_of, import_design
from remodel_production.edge.design_files import catalogue_file, design_formats, read_catalogue
from remodel_production.errors import DesignError

PLUG_IN = """
from remodel_production.core.imports.design_format import DesignFormat
from remodel_production.core.imports.values import Account, Imported
from remodel_production.core.imports.assembly import Connection, Device, assemble
from remodel_production.core.production import Order, TerminalRef

def read(data, name, source, catalogue):
    ends = [TerminalRef(*end.split(":")) for end in data.decode().split()[1:]]
    wires = [Connection(ends[0], ends[1], "BU", 1.5, "line 1", "W1")]
    assembly = assemble([Device(end.component) for end in ends], wires)
    order = Order(name, "", source, assembly.components, wires=assembly.wires)
    return Imported(order, Account("connections", 1, assembly.assumptions, ()))

PAIR = DesignFormat("pair", "pairs", lambda file: file.data.startswith(b"PAIR"), read)
"""


@pytest.fixture
def install(tmp_path, monkeypatch, request):
    """Return a function that puts a module on Python's path, with its entry point."""

    def place(code, target="PAIR", name="pair"):
        # A module of its own for each test: Python loads a name once.
        module = "plug_in_" + re.sub(r"\W", "_", request.node.name)
        (tmp_path / f"{module}.py").write_text(textwrap.dedent(code))
        info = tmp_path / f"{name}-1.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
        (info / "entry_points.txt").write_text(
            f"[remodel_production.importers]\n{name} = {module}:{target}\n"
        )
        monkeypatch.syspath_prepend(str(tmp_path))

    return place


def test_a_format_of_another_package_reads_modules_and_joins_files(install):
    code = PLUG_IN.replace(
        "PAIR = ",
        "def read_modules(data, name, source, catalogue, asked):\n"
        "    return read(data, '+'.join(asked.modules), source, catalogue)\n"
        "def join(before, data):\n"
        "    return JoinedFile(data + before[0][1], f' (after {before[0][0]})')\n"
        "PAIR = ",
    )
    code = code.replace("import DesignFormat\n", "import DesignFormat, JoinedFile\n")
    install(code.replace(", read)\n", ", read, read_modules, join)\n"))
    form = format_of(b"PAIR X1:1 ", design_formats(()))
    joined = form.join([("a.pair", b"K1:A1")], b"PAIR X1:1 ")
    assert joined.parts == " (after a.pair)"
    asked = Asked(modules=("M1", "M2"))
    catalogue = read_catalogue(catalogue_file())
    assert form.read_modules(joined.data, "x", "file", catalogue, asked).order.name == "M1+M2"
    with pytest.raises(DesignError, match=r"plug-in pair = .*: IndexError: "):
        form.join([], b"PAIR X1:1 ")
    with pytest.raises(DesignError, match=r"plug-in pair = .*: IndexError: "):
        form.read_modules(b"PAIR", "x", "file", catalogue, asked)


def test_a_format_of_another_package_is_recognised_and_read(install):
    install(PLUG_IN)
    formats = design_formats(())
    assert [form.name for form in formats] == ["qet", "kbl", "vec", "wireviz", "csv", "pair"]
    form = format_of(b"PAIR X1:1 K1:A1", formats)
    imported = import_design(
        b"PAIR X1:1 K1:A1", form, "x", "file", read_catalogue(catalogue_file())
    )
    assert [str(wire.a) for wire in imported.order.wires] == ["X1:1"]
    with pytest.raises(DesignError, match=r"known headings\), and pairs; a CSV file"):
        format_of(b"dear colleague,\n", formats)


def test_a_file_that_two_formats_recognise_needs_a_choice(install):
    install(PLUG_IN.replace('b"PAIR"', 'b"connections"'))
    with pytest.raises(DesignError, match="choose one: --format wireviz or --format pair"):
        format_of(b"connections: []", design_formats(()))


@pytest.mark.parametrize(
    ("ending", "said"),
    [
        ("", "AttributeError: .* 'PAIR'; correct the plug-in, or uninstall it"),
        ("PAIR = 3", "int found; needed: a DesignFormat"),
        ('PAIR = DesignFormat("csv", "", bool, read)', "there is a format 'csv' already"),
        ('PAIR = DesignFormat("A B", "", bool, read)', "'A B' found; needed: lower-case"),
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
    ],
)
def test_an_entry_point_that_names_no_format_is_refused_by_its_name(install, ending, said):
    install(PLUG_IN.replace("PAIR =", "OTHER =") + ending)
    with pytest.raises(DesignError, match=rf"importer plug-in pair = plug_in_.* pair: .*{said}"):
        design_formats(())


@pytest.mark.parametrize(
    ("read", "said"),
    [
        ("lambda *_: 1 / 0", "ZeroDivisionError: division by zero; correct the plug-in"),
        ("lambda *_: None", "its `read` returned NoneType; needed: an Imported"),
    ],
)
def test_a_reader_that_fails_is_named(install, read, said):
    install(PLUG_IN + f'\nPAIR = DesignFormat("pair", "pairs", bool, {read})\n')
    form = design_formats(())[-1]
    with pytest.raises(DesignError, match=re.escape(said)):
        import_design(b"PAIR", form, "x", "file", read_catalogue(catalogue_file()))
