#!/usr/bin/env python3
"""A run whose database is deleted stops in words, and a backup can take its place."""

import rostest
from database_loss_case import OUTPUT, DatabaseLossCase


def delete():
    """Delete the database and what SQLite keeps beside it."""
    for path in OUTPUT.glob("production.sqlite*"):
        path.unlink()


class DatabaseLossTest(DatabaseLossCase):
    def test_the_file_is_deleted(self):
        self.lose(delete, "gone")


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_database_loss", DatabaseLossTest)
