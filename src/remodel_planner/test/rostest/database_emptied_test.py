#!/usr/bin/env python3
"""A run whose database is emptied stops in words, and a backup can take its place."""

import os
import sqlite3
from contextlib import closing

import rostest
from database_loss_case import DATABASE, DatabaseLossCase


def empty():
    """Empty the database, once its log has nothing that would restore it."""
    with closing(sqlite3.connect(DATABASE)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        os.truncate(DATABASE, 0)


class DatabaseEmptiedTest(DatabaseLossCase):
    def test_the_file_is_emptied(self):
        self.lose(empty, "production database")


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_database_emptied", DatabaseEmptiedTest)
