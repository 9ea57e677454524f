"""What is requested from the engine for the words of a user."""

from types import SimpleNamespace

import pytest

from flexbe_widget.edge.files import RequestError
from flexbe_widget.ros.request_server import start_request


@pytest.fixture
def library(tmp_path):
    (tmp_path / "a_sm.py").write_text("# a behavior\n")
    return SimpleNamespace(
        find_behavior=lambda name: (7, None), get_sourcecode_filepath=lambda _: tmp_path / "a_sm.py"
    )


def test_values_of_parameters_and_inputs_may_lie_in_files(library, tmp_path):
    file = tmp_path / "values.yaml"
    file.write_text("speed: 1.5\n")
    pairs = [("/speed", f"file://{file}:speed")], [("pose", f"file://{file}"), ("x", "[1]")]
    request = start_request(library, "A", *pairs)
    assert request.arg_values == ["1.5"]
    assert request.input_values == ["speed: 1.5\n", "[1]"]


def test_a_file_that_cannot_be_read_is_refused(library, tmp_path):
    with pytest.raises(RequestError, match="cannot read file"):
        start_request(library, "A", inputs=[("pose", f"file://{tmp_path}/none")])
