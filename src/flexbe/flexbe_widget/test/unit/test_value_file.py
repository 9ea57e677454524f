"""Values that are kept in files."""

import pytest

from flexbe_widget.edge.files import RequestError, resolved, yaml_text


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "values.yaml"
    path.write_text("outer: {inner: [1, 2], text: a b}\nnumber: 5\n")
    return path


def test_a_plain_value_is_itself():
    assert resolved("5:6") == "5:6"


def test_a_whole_file_is_its_text(file):
    assert resolved(f"file://{file}") == file.read_text()


@pytest.mark.parametrize(
    ("entry", "text"), [("number", "5"), ("outer/text", "a b"), ("outer/inner", "[1, 2]")]
)
def test_an_entry_of_a_file_is_chosen(file, entry, text):
    assert resolved(f"file://{file}:{entry}") == text
    assert yaml_text(f"{file}:{entry}") == text


def test_a_whole_yaml_file_is_one_line(file):
    assert yaml_text(str(file)) == "{number: 5, outer: {inner: [1, 2], text: a b}}"


def test_a_file_is_found_from_home_and_in_packages(file, monkeypatch):
    monkeypatch.setenv("HOME", str(file.parent))
    assert resolved("file://~/values.yaml:number") == "5"
    assert "<package" in resolved("file://flexbe_widget/package.xml")


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ("/no/such/file", "cannot read file /no/such/file"),
        ("no_such_package/x.yaml", "there is no ROS package 'no_such_package'"),
        ("{file}:other", "has no entry 'other'; at 'other' there are: outer, number"),
        ("{file}:number/deeper", "at 'deeper' there are: no entries"),
        ("{broken}:x", "is not YAML"),
        ("{binary}", "cannot read file"),
        ("~nobody_here/x", "cannot read file ~nobody_here/x"),
        ("/a\0b", "embedded null byte"),
        ("{deep}:x", "is not YAML"),
        ("{date}:x", "is not YAML: month must be in 1..12"),
        ("/dev/zero", "is longer than 16777216 characters"),
    ],
)
def test_what_cannot_be_read_is_explained(file, place, text):
    (broken := file.with_name("broken.yaml")).write_text("{")
    (binary := file.with_name("binary")).write_bytes(b"\xff\xfe")
    (deep := file.with_name("deep.yaml")).write_text("[" * 5000)
    (date := file.with_name("date.yaml")).write_text("x: 2026-13-01\n")
    names = {"file": file, "broken": broken, "binary": binary, "deep": deep, "date": date}
    with pytest.raises(RequestError, match=text):
        resolved("file://" + place.format(**names))


def test_a_file_is_found_although_another_package_is_broken(file, tmp_path, monkeypatch):
    for name, text in (("a", "<package><name>"), ("b", "<package><name>mine</name></package>")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.xml").write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert resolved("file://mine/package.xml") == "<package><name>mine</name></package>"
