"""Settings: what the environment may say, and what is refused."""

import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from service.data_dir import make_private
from service.queue.worker_memory import PROCESS_BYTES, usual_worker_memory
from service.settings import Settings, variable_of
from service.store.store import Store

ROOT = Path(__file__).parents[2]


def test_defaults_bind_loopback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("D3PG_TOKEN", "")
    settings = Settings()
    assert settings.host == "127.0.0.1"
    assert settings.is_loopback
    assert settings.token is None
    assert settings.workers >= 1
    assert str(settings.store_url).endswith("/d3pg-data/d3pg.sqlite")


def test_environment_variables(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("D3PG_HOST", "0.0.0.0")  # noqa: S104
    monkeypatch.setenv("D3PG_PORT", "8080")
    monkeypatch.setenv("D3PG_ALLOW_HOST", "Lab.example, 10.0.0.7,fe80::1")
    monkeypatch.setenv("D3PG_DATABASE_URL", "postgresql+psycopg://db/d3pg")
    settings = Settings()
    assert settings.allowed_hosts == {
        *("127.0.0.1", "localhost", "[::1]"),
        *("lab.example", "10.0.0.7", "[fe80::1]"),
    }
    assert str(settings.store_url) == "postgresql+psycopg://db/d3pg"
    assert settings.url == "http://127.0.0.1:8080"


@pytest.mark.parametrize(
    ("url", "origin", "prefix", "host", "is_secure"),
    [
        ("https://Lab.example/d3pg/", "https://lab.example", "/d3pg", "lab.example", True),
        ("https://lab.example:443", "https://lab.example", "", "lab.example", True),
        ("http://lab.example:81/a/b", "http://lab.example:81", "/a/b", "lab.example", False),
        ("http://[FE80::1]:80/", "http://[fe80::1]", "", "[fe80::1]", False),
    ],
)
def test_everything_follows_from_the_public_address(
    url: str, origin: str, prefix: str, host: str, is_secure: bool
) -> None:
    settings = Settings(public_url=url, host="0.0.0.0")  # noqa: S104
    public = settings.public
    assert (public.origin, public.prefix, public.host) == (origin, prefix, host)
    assert public.is_secure is is_secure
    assert host in settings.allowed_hosts
    assert settings.is_overheard is not is_secure
    assert settings.url == "http://127.0.0.1:8000", "where this machine finds it"


def test_without_a_public_address_it_is_found_where_it_listens(tmp_path: Path) -> None:
    assert Settings().public.url == "http://127.0.0.1:8000"
    tls = Settings(tls_certificate=tmp_path / "c", tls_key=tmp_path / "k")
    assert tls.public.url == "https://127.0.0.1:8000"
    assert tls.public.is_secure


def test_only_a_network_without_tls_is_overheard(tmp_path: Path) -> None:
    there = Settings(host="10.0.0.7", allow_host=("lab",))
    assert there.is_overheard
    assert not Settings().is_overheard
    assert not Settings(
        host="10.0.0.7", allow_host=("lab",), tls_certificate=tmp_path, tls_key=tmp_path
    ).is_overheard


def test_the_table_of_settings_lists_every_setting() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    lines = [line for page in pages for line in page.read_text(encoding="utf-8").splitlines()]
    rows = [line.split("|")[1] for line in lines if line.startswith("| `D3PG_")]
    listed = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert sorted(listed) == sorted(map(variable_of, Settings.model_fields))
    assert all(field.description for field in Settings.model_fields.values())


def test_no_more_workers_are_kept_than_there_may_be() -> None:
    assert Settings(min_workers=0).min_workers == 0
    with pytest.raises(ValidationError, match="D3PG_MIN_WORKERS=5 is more than D3PG_MAX_WORKERS=4"):
        Settings(min_workers=5, max_workers=4)


def test_worker_memory_is_by_default_a_share_of_the_machines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert Settings(workers=3).run_memory == usual_worker_memory(3)
    assert Settings(workers=4096).run_memory < Settings(workers=3).run_memory
    monkeypatch.setenv("D3PG_WORKER_MEMORY", "6GB")
    assert Settings().run_memory == 6 * 10**9
    assert Settings().promised_memory == 0
    assert Settings(ray_address="127.0.0.2:6379").promised_memory == 6 * 10**9 + PROCESS_BYTES


def test_a_bound_address_is_an_allowed_host() -> None:
    settings = Settings(host="10.0.0.7", allow_host=("lab.example",))
    assert "10.0.0.7" in settings.allowed_hosts
    assert not settings.is_loopback


@pytest.mark.parametrize(
    ("variable", "value", "says"),
    [
        ("D3PG_HOST", "0.0.0.0", "D3PG_ALLOW_HOST"),  # noqa: S104
        ("D3PG_HOST", "0.0.0.0", "D3PG_PUBLIC_URL"),  # noqa: S104
        ("D3PG_PUBLIC_URL", "lab.example", "https://HOST/PREFIX"),
        ("D3PG_PUBLIC_URL", "ftp://lab.example", "https://HOST/PREFIX"),
        ("D3PG_PUBLIC_URL", "https://me:SECRET@lab.example", "https://HOST/PREFIX"),
        ("D3PG_PUBLIC_URL", "https://lab.example/a b", "letters, digits"),
        ("D3PG_PUBLIC_URL", "https://lab.example/../d3pg", "letters, digits"),
        ("D3PG_PUBLIC_URL", "https://lab.example:99999", "0-65535"),
        ("D3PG_TLS_CERTIFICATE", "cert.pem", "D3PG_TLS_KEY belong together"),
        ("D3PG_TLS_KEY", "key.pem", "D3PG_TLS_KEY belong together"),
        ("D3PG_HOST", "192.168.1.5", "D3PG_ALLOW_HOST"),
        ("D3PG_TOKEN", "short", "16 characters"),
        ("D3PG_PORT", "70000", "65535"),
        ("D3PG_CHECKPOINTS", "gs://runs", "s3://BUCKET/PREFIX"),
        ("D3PG_CHECKPOINTS", "s3://KEY:SECRET@runs", "AWS_ACCESS_KEY_ID"),
        ("D3PG_WORKERS", "0", "greater than or equal to 1"),
        ("D3PG_WORKER_MEMORY", "10kB", "greater than or equal to 1048576"),
        ("D3PG_WORKER_MEMORY", "much", "byte"),
    ],
)
def test_refusals_say_what_to_do(
    monkeypatch: pytest.MonkeyPatch, variable: str, value: str, says: str
) -> None:
    monkeypatch.setenv(variable, value)
    with pytest.raises(ValidationError, match=says) as refusal:
        Settings()
    assert "SECRET@" not in str(refusal.value)


def test_the_token_is_not_printed() -> None:
    settings = Settings.model_validate({"token": "a-secret-token-of-tests"})
    assert "a-secret-token" not in repr(settings)


def test_checkpoints_lie_in_the_data_directory_or_where_they_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert Settings(data_dir=tmp_path).checkpoint_place == tmp_path / "checkpoints"
    for text, found in (
        ("/mnt/shared", Path("/mnt/shared")),
        ("s3://runs/lab/", "s3://runs/lab"),
    ):
        monkeypatch.setenv("D3PG_CHECKPOINTS", text)
        assert Settings(data_dir=tmp_path).checkpoint_place == found


def test_sqlite_lies_in_the_data_directory(tmp_path: Path) -> None:
    assert str(Settings(data_dir=tmp_path).store_url) == f"sqlite:///{tmp_path}/d3pg.sqlite"


@pytest.mark.parametrize("name", ["d?x=1", "a b", "100%", "ü#", "%3F"])
def test_whatever_the_directory_is_called(tmp_path: Path, name: str) -> None:
    settings = Settings(data_dir=tmp_path / name)
    make_private(settings.data_dir)
    Store.open(settings.store_url).close()
    assert (tmp_path / name / "d3pg.sqlite").stat().st_size > 0
    assert [each.name for each in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("text", ["d3pg", "mysql://lab/d3pg", "://", "/data/d3pg.sqlite"])
def test_what_is_no_database_is_refused(text: str) -> None:
    with pytest.raises(ValidationError, match="write postgresql://"):
        Settings(database_url=text)
