"""The first release. It creates its tables from the models; later versions migrate from here."""

from __future__ import annotations

revision = "0006"
down_revision = None


def upgrade() -> None:
    """Change nothing: no release came before."""
