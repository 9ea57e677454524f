"""`remodel expectations` prints what was learned from runs."""

import re

from taught import TAUGHT

from remodel_planner.commands.runs import expectations


def test_the_command_prints_what_was_learned(monkeypatch, capsys):
    class Database:
        def __init__(self, url):
            self.url = url

        def close(self):
            pass

    monkeypatch.setattr(expectations, "ProductionDatabase", Database)
    monkeypatch.setattr(expectations, "ability_calls", lambda _: tuple(TAUGHT))
    assert expectations.main(["cabinet", "--database", "sqlite://"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"InsertCable +2.5 +180 +10.0 s +90.0% ", printed)
    assert re.search(r"InsertCable force_limit 14 +60 +frozen +[0-9]\.[0-9]%", printed)
    assert re.search(r"InsertCable force_limit 12 +60 +9[0-9]\.[0-9]%", printed)
    assert "force_limit 16" not in printed
