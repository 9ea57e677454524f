from types import SimpleNamespace

import pytest

from flexbe_synthesizer.core.chart.grammar import split_name
from flexbe_synthesizer.core.chart.problem import ChartError, ProblemKind
from flexbe_synthesizer.core.chart.xml_tree import XmlTree, as_utf8, read_utf8


class Element:
    """An element of a document, with the places of what is in it."""

    def __init__(self, element, places):
        self.namespace, self.name = split_name(element.tag)
        self.position, self.text = places[element].element, places[element].text
        self.attributes = [
            SimpleNamespace(
                namespace=split_name(spelled)[0],
                name=split_name(spelled)[1],
                value=value,
                position=places[element].attributes[spelled],
            )
            for spelled, value in element.attrib.items()
        ]
        self._element, self._places = element, places

    @property
    def children(self):
        return [Element(child, self._places) for child in self._element]


def read_xml(source, file):
    document = read_utf8(as_utf8(source, file), file)
    places = dict(zip(document.root.iter(), document.places, strict=True))
    return SimpleNamespace(root=Element(document.root, places), problems=document.problems)


def problem_of(source):
    with pytest.raises(ChartError) as caught:
        read_xml(source, "f.xml")
    (problem,) = caught.value.problems
    return problem.code, problem.position[1:], problem.message


def test_elements_attributes_and_text_know_where_they_stand():
    document = read_xml('<a  x="1"\n   y = \'2\'>\n\t<é z="&#10;"/> te\n xt</a>', "f.xml")
    root = document.root
    assert [(a.name, a.value, a.position[1:]) for a in root.attributes] == [
        ("x", "1", (1, 5)),
        ("y", "2", (2, 4)),
    ]
    child = root.children[0]
    assert (child.name, child.position[1:]) == ("é", (3, 2))
    assert (child.attributes[0].value, child.attributes[0].position[1:]) == ("\n", (3, 5))
    assert root.text[1:] == (3, 17)


def test_a_greater_than_sign_and_quotes_in_values_do_not_shift_the_places():
    root = read_xml("<a x='>\"=' y=\"'/>\" z=''/>", "f.xml").root
    places = [(a.name, a.value, a.position.column) for a in root.attributes]
    assert places == [("x", '>"=', 4), ("y", "'/>", 12), ("z", "", 20)]


def test_columns_count_characters_not_bytes():
    root = read_xml('<a é="é" b="2"/>', "f.xml").root
    assert [a.position.column for a in root.attributes] == [4, 10]


def test_prefixes_are_resolved_where_they_are_declared():
    root = read_xml('<a xmlns:p="urn:x" p:k="1"><b p:k="2" xmlns:p="urn:y"/></a>', "f").root
    assert root.attributes[0].namespace == "urn:x"
    assert root.children[0].attributes[0].namespace == "urn:y"


def test_an_undeclared_prefix_is_a_problem_that_hides_nothing_else():
    document = read_xml('<a>\n<b p:k="1" l="2"/></a>', "f.xml")
    (problem,) = document.problems
    assert (problem.code, problem.position[1:]) == (ProblemKind.UNBOUND_PREFIX, (2, 4))
    assert [a.name for a in document.root.children[0].attributes] == ["l"]


def test_an_attribute_that_stands_twice_is_a_problem_that_hides_nothing_else():
    document = read_xml('<a x="1"\n x="2"><b y="1" y="2" y="3"/></a>', "f.xml")
    places = [(p.code, p.position[1:]) for p in document.problems]
    twice = ProblemKind.DUPLICATE_ATTRIBUTE
    assert places == [(twice, (2, 2)), (twice, (2, 17)), (twice, (2, 23))]
    assert [a.value for a in document.root.attributes] == ["1"]


def test_a_flood_of_doubled_attributes_ends():
    with pytest.raises(ChartError) as caught:
        read_xml("<a " + 'x="1" ' * 5000 + "/>", "f.xml")
    assert len(caught.value.problems) == 100


def test_what_is_not_well_formed_says_where_and_what_is_open():
    code, place, message = problem_of("<a>\n  <b>\n</a>")
    assert (code, place) == (ProblemKind.NOT_XML, (3, 3))
    assert "<b> of line 2 is open" in message
    assert "empty" in problem_of("  \n")[2]
    assert problem_of("<a/><b/>")[:2] == (ProblemKind.NOT_XML, (1, 5))


@pytest.mark.parametrize(
    "source",
    [
        '<!DOCTYPE a [<!ENTITY x "y">]><a>&x;</a>',
        '<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>',
        '<!DOCTYPE a [<!ENTITY % p SYSTEM "http://localhost/x"> %p;]><a/>',
        "<!DOCTYPE a><a/>",
    ],
)
def test_document_types_are_refused_and_with_them_all_entities(source):
    assert problem_of(" \n" + source if "&" not in source else source)[0] is ProblemKind.DOCTYPE


def test_the_place_of_a_document_type_is_its_beginning():
    assert problem_of('<!-- é -->\n  <!DOCTYPE a [<!ENTITY x "y">]><a/>')[1] == (2, 3)


def test_encodings_are_read_or_refused_with_a_reason():
    text = '<?xml version="1.0" encoding="{}"?><a x="é"/>'
    for encoding in ("utf-8", "iso-8859-1", "windows-1252"):
        root = read_xml(text.format(encoding).encode(encoding), "f").root
        assert root.attributes[0].value == "é"
    assert read_xml("﻿<a x='é'/>".encode(), "f").root.attributes[0].value == "é"
    assert read_xml("<a x='é'/>".encode("utf-16"), "f").root.attributes[0].value == "é"
    for encoding in ("utf-16-le", "utf-16-be"):
        root = read_xml("<a\n x='é' y='1'/>".encode(encoding), "f").root
        assert [a.position[1:] for a in root.attributes] == [(2, 2), (2, 8)]
    assert problem_of(b"<a>\nb\0</a>")[:2] == (ProblemKind.NOT_XML, (2, 2))
    assert "NUL" in problem_of("<a/>".encode("utf-32"))[2]
    assert "'koi8-r'" in problem_of(text.format("koi8-r").encode("utf-8"))[2]
    code, place, message = problem_of(b"<a>\n\xc3\xa9 \xe9</a>")
    assert (code, place) == (ProblemKind.NOT_XML, (2, 3))
    assert "0xe9 is not utf-8" in message


@pytest.mark.parametrize(
    ("source", "place", "found"),
    [
        (b"\xef\xbb\xbf<a>\n\xff</a>", (2, 1), "0xff is not utf-8"),
        ("\ufeff<\u0a0a>\nb".encode("utf-16-le") + b"\0\xd8<\0", (2, 2), "is not utf-16"),
        (b"<a>\r\r\n \xff</a>", (3, 2), "0xff is not utf-8"),
        (b"<a>\r\r\n \0</a>", (3, 2), "NUL"),
        (b'<?xml version="1.0"?>\r <!DOCTYPE a><a/>', (2, 2), "document type"),
    ],
)
def test_places_are_those_of_an_editor_whatever_marks_and_line_ends_the_file_has(
    source, place, found
):
    _code, at, message = problem_of(source)
    assert at == place
    assert found in message


def test_attributes_on_lines_that_end_as_on_old_machines_know_where_they_stand():
    root = read_xml("<a x='1'\r  y='2'\r\nz='3'/>", "f").root
    assert [a.position[1:] for a in root.attributes] == [(1, 4), (2, 3), (3, 1)]


def test_an_attribute_that_two_prefixes_of_one_namespace_give_is_a_problem():
    document = read_xml('<a xmlns:p="urn:x" xmlns:q="urn:x" p:k="1"\n q:k="2" k="3"/>', "f.xml")
    (problem,) = document.problems
    assert (problem.code, problem.position[1:]) == (ProblemKind.DUPLICATE_ATTRIBUTE, (2, 2))
    assert "'q:k' stands twice" in problem.message
    assert [a.value for a in document.root.attributes] == ["1", "3"]


def test_half_characters_and_deep_nesting_are_no_trouble():
    assert problem_of("<a>\ud800</a>")[0] is ProblemKind.NOT_XML
    deep = read_xml("<a>" * 50_000 + "</a>" * 50_000, "f").root
    assert deep.children[0].name == "a"


def variants(text):
    yield text
    yield text.replace("\n", "\r\n")
    yield text.replace("\n", " ")
    yield text.replace(' name="', '\n  name = "').replace('"', "'")
    yield text.replace('type="', 'xmlns:x="x" x:type="é" type="').replace('value="', 'value="😀 > ')


@pytest.mark.parametrize("name", ["place_connector.xml", "two_arms.xml"])
def test_a_place_is_the_same_whether_or_not_all_places_are_read(golden, name):
    for text in variants((golden / "charts" / name).read_text()):
        tree = XmlTree(text, "chart.xml")
        waiting = [read_xml(text, "chart.xml").root]
        for element in tree.root.iter():
            read = waiting.pop(0)
            waiting[:0] = read.children
            assert tree.place(element) == tree.place(element, "no such") == read.position
            for given in read.attributes:
                same = [a for a in read.attributes if a.name == given.name]
                plain = [a for a in same if not a.namespace]
                assert tree.place(element, given.name) == (plain or same)[0].position
