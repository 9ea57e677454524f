"""What Alembic runs first: migrate over the connection that is given, within its transaction."""

from alembic import context

from remodel_production.edge.database.production_models import Base

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Base.metadata,
    compare_type=True,
)
context.run_migrations()
