"""New databases get the tables of the models; those of unknown versions are refused."""

import shutil

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from databases import execute
from sqlalchemy import create_engine, inspect

from remodel_production.edge.database import production_database
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.database.production_models import Base
from remodel_production.errors import OrderError


def open_and_close(url):
    ProductionDatabase(url).close()


def differences_from_models(connection):
    context = MigrationContext.configure(connection, opts={"compare_type": True})
    return compare_metadata(context, Base.metadata)


def test_a_new_database_has_the_tables_of_the_models(url):
    open_and_close(url)
    engine = create_engine(url)
    with engine.connect() as connection:
        assert differences_from_models(connection) == []
        checks = {
            table: {check["name"] for check in inspect(connection).get_check_constraints(table)}
            for table in Base.metadata.tables
        }
    engine.dispose()
    assert "ck_clips_place" in checks["clips"]
    assert "ck_wires_section" in checks["wires"]


def test_the_newest_version_is_that_of_the_last_migration():
    config = Config()
    folder = production_database.__file__.replace("production_database.py", "migrations")
    config.set_main_option("script_location", folder)
    assert ScriptDirectory.from_config(config).get_current_head() == production_database.NEWEST


def test_a_database_of_a_newer_program_is_refused_and_left_alone(url):
    open_and_close(url)
    execute(url, "UPDATE alembic_version SET version_num = '0999'")
    with pytest.raises(OrderError, match=r"is of version 0999; .* versions 0006, 0007, 0008"):
        ProductionDatabase(url)
    assert execute(url, "SELECT version_num FROM alembic_version") == [("0999",)]


def test_a_database_of_the_version_before_is_migrated(url, tmp_path, monkeypatch):
    open_and_close(url)
    migrations = tmp_path / "migrations"
    shutil.copytree(production_database.MIGRATIONS, migrations)
    (migrations / "versions/m0009_more.py").write_text(
        "from alembic import op\n\n"
        "revision, down_revision = '0009', '0008'\n\n\n"
        "def upgrade():\n    op.execute('CREATE TABLE more (id INTEGER)')\n"
    )
    monkeypatch.setattr(production_database, "MIGRATIONS", migrations)
    monkeypatch.setattr(production_database, "NEWEST", "0009")
    open_and_close(url)
    assert execute(url, "SELECT version_num FROM alembic_version") == [("0009",)]
    assert execute(url, "SELECT id FROM more") == []


def test_a_database_of_version_0006_gets_numbers_of_wires_and_names_of_places(url):
    open_and_close(url)
    execute(
        url,
        "INSERT INTO products (id, title, source) VALUES (1, '', '')",
        "INSERT INTO components (id, product_id, name, kind, role, part_number, mount)"
        " VALUES (1, 1, 'M1', '', 'device', '', 'field')",
        "ALTER TABLE wires DROP COLUMN number",
        "DROP TABLE rehearsals",
        "UPDATE alembic_version SET version_num = '0006'",
    )
    open_and_close(url)
    engine = create_engine(url)
    with engine.connect() as connection:
        assert differences_from_models(connection) == []
    engine.dispose()
    assert execute(url, "SELECT mount FROM components") == [("outside",)]


def test_an_open_database_is_opened_again_without_migrating(url, monkeypatch):
    open_and_close(url)
    monkeypatch.setattr("remodel_production.edge.database.production_database.upgrade", None)
    open_and_close(url)


def test_every_table_and_column_has_a_comment():
    for table in Base.metadata.tables.values():
        assert table.comment, table.name
        assert all(column.comment for column in table.columns), table.name


def test_a_creation_that_fails_changes_nothing(url):
    # Other tables are created before this one is found to exist.
    execute(url, "CREATE TABLE wires (id INTEGER)", "INSERT INTO wires VALUES (7)")
    with pytest.raises(OrderError, match="wires"):
        ProductionDatabase(url)
    engine = create_engine(url)
    assert inspect(engine).get_table_names() == ["wires"]
    engine.dispose()
    assert execute(url, "SELECT id FROM wires") == [(7,)]
