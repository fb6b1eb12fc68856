"""Measurements that a report brings are one event: it names runs, where there was one for each."""

from alembic import op

revision: str = "0017"
down_revision: str | None = "0015"

# A payload is JSON with its keys in this order: sweep_id, run_id or run_ids, from, to.
OF_ONE = ('"run_id": "', '", "from": ')
OF_SEVERAL = ('"run_ids": ["', '"], "from": ')


def upgrade() -> None:
    """Write the run of each as a list."""
    _rewrite(OF_ONE, OF_SEVERAL)


def downgrade() -> None:
    """Drop what tells of several runs, which the version before cannot read."""
    several = """'%"run_ids": ["%", "%"], "from": %'"""
    op.execute(f"DELETE FROM events WHERE kind = 'measurements' AND payload LIKE {several}")  # noqa: S608
    _rewrite(OF_SEVERAL, OF_ONE)


def _rewrite(found: tuple[str, str], written: tuple[str, str]) -> None:
    text = "payload"
    for old, new in zip(found, written, strict=True):
        text = f"replace({text}, '{old}', '{new}')"
    op.execute(f"UPDATE events SET payload = {text} WHERE kind = 'measurements'")  # noqa: S608
