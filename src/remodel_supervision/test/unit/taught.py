"""Calls of an ability that teach which force is best."""

from remodel_supervision.core.learning.experience import Call


def forced(force_limit, error_code=0, section_mm2=2.5):
    features = {"section_mm2": section_mm2, "terminal_type": "clamp"}
    return Call("InsertCable", features, error_code, 5.0, {"force_limit": force_limit})


TAUGHT = [
    *[forced(8.0, 301), forced(10.0, 301), forced(20.0, 303)] * 20,
    *[forced(14.0, 301), forced(12.0)] * 60,
]
