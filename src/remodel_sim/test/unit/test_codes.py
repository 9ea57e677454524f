from pathlib import Path

from remodel_sim.core.codes import Code

MESSAGE = Path(__file__).parents[3] / "remodel_msgs" / "msg" / "ErrorCode.msg"


def test_codes_are_those_of_the_message():
    lines = [line.split("#")[0].strip() for line in MESSAGE.read_text().splitlines()]
    constants = dict(line.removeprefix("int16 ").split("=") for line in lines if "=" in line)
    assert {c.name: c.value for c in Code} == {name: int(v) for name, v in constants.items()}
