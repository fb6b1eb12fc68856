"""What an operator can set: environment variables `D3PG_*`, each also a flag of `d3pg serve`."""

import os
from functools import cached_property
from pathlib import Path
from typing import Annotated, Self

from pydantic import ByteSize, Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict
from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError

from service.address import LOOPBACK_HOSTS, WILDCARDS, Public, as_url_host, public_of, url_of
from service.queue.disposal import Retention
from service.queue.worker_memory import LEAST_BYTES, PROCESS_BYTES, usual_worker_memory
from workers.checkpoints.place import Place, place_of

MIN_TOKEN_LENGTH = 16
ENV_PREFIX = "D3PG_"


class Settings(BaseSettings):
    """The service's settings. When the service starts, it names each one that is wrong.

    The descriptions are what `d3pg serve --help` says; it adds the defaults.
    """

    model_config = SettingsConfigDict(
        env_prefix=ENV_PREFIX,
        env_ignore_empty=True,
        extra="ignore",
        frozen=True,
        hide_input_in_errors=True,  # it may hold a secret
    )

    host: str = Field(default="127.0.0.1", description="Address to bind")
    port: int = Field(default=8000, ge=0, le=65535, description="TCP port")
    data_dir: Path = Field(
        default=Path("d3pg-data"),
        description="Database, token, logs, checkpoints",
    )
    checkpoints: str = Field(
        default="",
        description="Another folder for checkpoints, as the workers see it, or s3://bucket/prefix",
    )
    database_url: str = Field(
        default="",
        description="SQLAlchemy URL of the database; SQLite in the data directory if unset",
    )
    ray_address: str = Field(
        default="",
        description="Address of a Ray cluster to join; a local Ray if unset",
    )
    driver: Path | None = Field(
        default=None,
        description="Socket of a separate process that drives Ray, such as in a container; "
        "the service starts one if unset",
    )
    workers: int = Field(
        default_factory=lambda: len(os.sched_getaffinity(0)),
        ge=1,
        le=4096,
        description="Local worker slots; the cores this process may use if unset",
    )
    min_workers: int = Field(
        default=1, ge=0, le=4096, description="Workers to keep on a joined cluster, even if idle"
    )
    max_workers: int = Field(
        default=1024,
        ge=1,
        le=4096,
        description="Workers on a joined cluster, at most; its autoscaler is asked for no more",
    )
    worker_memory: ByteSize | None = Field(
        default=None,
        ge=LEAST_BYTES,
        description="Memory that the runs of one worker may fill, such as 6GB",
    )
    keep_last: ByteSize = Field(
        default=ByteSize(2 * 10**9),
        ge=0,
        description="Space for the last checkpoints of ended runs, such as 2GB; 0: keep none",
    )
    keep_policies: float | None = Field(
        default=None,
        gt=0,
        description="Days to keep what a run learned after its end; for ever if unset",
    )
    keep_events: float | None = Field(
        default=None, gt=0, description="Days to keep events of the event stream; for ever if unset"
    )
    token: SecretStr | None = Field(
        default=None, description="Access token, instead of the token file's"
    )
    webhook_secret: SecretStr | None = Field(
        default=None, description="Secret that signs webhooks, instead of its file's"
    )
    webhook_hosts: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(),
        description="The only hosts that webhooks may name, separated by commas; any if unset",
    )
    allow_host: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(),
        description="Host names to answer to besides loopback, separated by commas",
    )
    public_url: str = Field(
        default="",
        description="Address at which a proxy makes it reachable, such as https://lab.example/d3pg",
    )
    tls_certificate: Path | None = Field(
        default=None, description="File with the certificate chain (PEM), to serve TLS"
    )
    tls_key: Path | None = Field(default=None, description="File with its private key (PEM)")

    tasks: Annotated[tuple[Path, ...], NoDecode] = Field(
        default=(),
        description="A file of tasks of your own, such as my_tasks.py; may be given again",
    )

    @field_validator("tasks", mode="before")
    @classmethod
    def _split_paths_at_commas(cls, value: object) -> object:
        if isinstance(value, str):
            return tuple(path.strip() for path in value.split(",") if path.strip())
        return value

    @field_validator("allow_host", "webhook_hosts", mode="before")
    @classmethod
    def _split_at_commas(cls, value: object) -> object:
        if isinstance(value, str):
            return tuple(name.strip().lower() for name in value.split(",") if name.strip())
        return value

    @field_validator("checkpoints")
    @classmethod
    def _refuse_what_is_no_place(cls, value: str) -> str:
        place_of(value)
        return value

    @field_validator("database_url")
    @classmethod
    def _refuse_what_is_no_url(cls, value: str) -> str:
        try:
            known = not value or make_url(value).get_backend_name() in {"sqlite", "postgresql"}
        except ArgumentError:
            known = False
        if not known:
            raise ValueError(
                "is not a database URL: write postgresql://user@host/name or sqlite:////folder/file"
            )
        return value

    @field_validator("public_url")
    @classmethod
    def _refuse_what_nobody_finds(cls, value: str) -> str:
        return public_of(value).url if value else ""

    @field_validator("token")
    @classmethod
    def _refuse_short_token(cls, value: SecretStr | None) -> SecretStr | None:
        if value is not None and len(value.get_secret_value()) < MIN_TOKEN_LENGTH:
            raise ValueError(
                f"a token needs at least {MIN_TOKEN_LENGTH} characters, so that nobody guesses it; "
                "leave D3PG_TOKEN unset and the service makes one"
            )
        return value

    @model_validator(mode="after")
    def _refuse_unnamed_exposure(self) -> Self:
        if not self.is_loopback and not self.allow_host and not self.public_url:
            raise ValueError(
                f"D3PG_HOST={self.host} makes the service reachable from other machines: name the "
                "address it is reached by in D3PG_PUBLIC_URL (--public-url), or host names in "
                "D3PG_ALLOW_HOST (--allow-host), separated by commas"
            )
        return self

    @model_validator(mode="after")
    def _refuse_half_of_tls(self) -> Self:
        if (self.tls_certificate is None) != (self.tls_key is None):
            raise ValueError(
                "D3PG_TLS_CERTIFICATE and D3PG_TLS_KEY belong together: set both, or none"
            )
        return self

    @model_validator(mode="after")
    def _refuse_more_than_most(self) -> Self:
        if self.min_workers > self.max_workers:
            raise ValueError(
                f"D3PG_MIN_WORKERS={self.min_workers} is more than "
                f"D3PG_MAX_WORKERS={self.max_workers}: lower the one or raise the other"
            )
        return self

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach the service."""
        return as_url_host(self.host) in LOOPBACK_HOSTS

    @cached_property
    def allowed_hosts(self) -> frozenset[str]:
        """Host names (as in a URL, without port) that a request may be addressed to."""
        own = set() if self.host in WILDCARDS else {as_url_host(self.host)}
        own |= {self.public.host}
        return LOOPBACK_HOSTS | own | {as_url_host(name) for name in self.allow_host}

    @property
    def store_url(self) -> URL:
        """The database: `database_url`, else SQLite in the data directory, whatever its name."""
        if self.database_url:
            return make_url(self.database_url)
        return URL.create("sqlite", database=str((self.data_dir / "d3pg.sqlite").resolve()))

    @property
    def run_memory(self) -> int:
        """Bytes that the runs of one worker may fill together."""
        return self.worker_memory or usual_worker_memory(self.workers)

    @property
    def retention(self) -> Retention:
        """How long policies and events are kept."""
        return Retention(self.keep_policies, self.keep_events)

    @property
    def promised_memory(self) -> int:
        """Bytes that each worker needs of its node; 0 on a local Ray, and if none are set."""
        is_said = self.worker_memory is not None and bool(self.ray_address)
        return self.run_memory + PROCESS_BYTES if is_said else 0

    @property
    def checkpoint_place(self) -> Place:
        """Where the runs' checkpoints and policies lie: `checkpoints`, else in the data folder."""
        return place_of(self.checkpoints or str(self.data_dir / "checkpoints"))

    @property
    def url(self) -> str:
        """Where this machine finds the service."""
        return url_of(self.host, self.port, "http" if self.tls_certificate is None else "https")

    @property
    def public(self) -> Public:
        """Where clients find the service: `public_url`, else `url`."""
        return public_of(self.public_url) if self.public_url else Public(self.url)

    @property
    def is_overheard(self) -> bool:
        """Whether tokens cross a network in the clear, as far as the settings tell."""
        is_encrypted = self.tls_certificate is not None or self.public.is_secure
        return not self.is_loopback and not is_encrypted


def variable_of(name: str) -> str:
    """Return the environment variable of a setting."""
    return f"{ENV_PREFIX}{name.upper()}"
