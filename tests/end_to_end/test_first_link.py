"""What a service prints as it starts: a link for one browser, and no token; with TLS of its own."""

import os
import re
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest

from tests.end_to_end.running_service import ROOT
from tests.service.certificate import self_signed

pytestmark = pytest.mark.cluster


@contextmanager
def running(data_dir: Path, **settings: object) -> Iterator["subprocess.Popen[str]"]:
    """A service on a free port, whose output is read; ended with the block."""
    own = {"D3PG_DATA_DIR": data_dir, "D3PG_PORT": 0, "D3PG_WORKERS": 1, "PYTHONPATH": ROOT}
    given = {name: str(value) for name, value in {**own, **settings}.items()}
    service = subprocess.Popen(
        [sys.executable, "-m", "service"],
        env=os.environ | given,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield service
    finally:
        service.terminate()
        service.communicate()


def test_what_it_prints_signs_one_browser_in_and_holds_no_token(tmp_path: Path) -> None:
    token = "a-token-of-the-tests-0000"  # noqa: S105
    with running(tmp_path / "data", D3PG_TOKEN=token) as service:
        assert service.stdout is not None
        link = service.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/signin\?code=[\w-]{43}", link)
        with httpx2.Client() as browser:
            assert browser.get(link).status_code == 303
            assert browser.get(link.partition("/signin")[0]).status_code == 200
        assert httpx2.get(link).status_code == 401
        arguments = Path(f"/proc/{service.pid}/cmdline").read_text()
    assert token not in arguments + link


def test_it_speaks_tls_with_a_certificate_of_one_s_own(tmp_path: Path) -> None:
    chain, key = self_signed(tmp_path, "IP:127.0.0.1")
    with running(tmp_path / "data", D3PG_TLS_CERTIFICATE=chain, D3PG_TLS_KEY=key) as service:
        assert service.stdout is not None
        link = service.stdout.readline().strip()
        assert link.startswith("https://127.0.0.1:")
        trust = ssl.create_default_context(cafile=chain)
        with httpx2.Client(verify=trust) as browser:
            signed_in = browser.get(link)
        assert "Secure" in signed_in.headers["set-cookie"]
        assert "strict-transport-security" not in signed_in.headers, "nobody named its address"
