"""Behind Debian's nginx, below a path, with TLS and with nginx's default headers, in a browser."""

import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import Browser, Page, expect

from tests.end_to_end.running_service import free_port
from tests.service.certificate import self_signed
from tests.web.conftest import PATIENCE_MILLISECONDS
from tests.web.live_service import LiveService

pytestmark = [
    pytest.mark.browser,
    pytest.mark.slow,  # with a certificate that nobody trusts, Chromium sometimes tries too often
    pytest.mark.skipif(not shutil.which("nginx", path="/usr/sbin:/usr/bin"), reason="needs nginx"),
]

NGINX = "/usr/sbin/nginx"
START_SECONDS = 20.0
HOST = "lab.localhost"
"""A name that browsers look for on this machine, and that the service does not know by itself."""
CONFIGURATION = """
daemon off;
pid {folder}/nginx.pid;
error_log stderr warn;
events {{}}
http {{
    access_log {folder}/access.log;
    client_body_temp_path {folder}/body;
    proxy_temp_path {folder}/proxy;
    fastcgi_temp_path {folder}/fastcgi;
    uwsgi_temp_path {folder}/uwsgi;
    scgi_temp_path {folder}/scgi;
    server {{
        listen 127.0.0.1:{port} ssl;
        ssl_certificate {folder}/chain.pem;
        ssl_certificate_key {folder}/key.pem;
        location /d3pg/ {{
            proxy_pass http://127.0.0.1:{upstream}{path};
        }}
    }}
}}
"""


@contextmanager
def nginx(folder: Path, port: int, upstream: int, path: str) -> Iterator[None]:
    """A proxy that is up."""
    self_signed(folder, f"DNS:{HOST}")
    configuration = folder / "nginx.conf"
    configuration.write_text(
        CONFIGURATION.format(folder=folder, port=port, upstream=upstream, path=path)
    )
    process = subprocess.Popen([NGINX, "-p", folder, "-c", configuration])
    try:
        deadline = time.monotonic() + START_SECONDS
        while not answers(port):
            assert process.poll() is None, "nginx ended"
            assert time.monotonic() < deadline, "nginx does not answer"
            time.sleep(0.05)
        yield
    finally:
        process.terminate()
        process.wait()


def answers(port: int) -> bool:
    try:
        httpx2.get(f"https://127.0.0.1:{port}/d3pg/healthz", verify=False)
    except httpx2.TransportError:
        return False
    return True


@pytest.fixture(params=["", "/"], ids=["path kept", "path taken away"])
def proxied(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[LiveService]:
    """A service that people find at https://lab.localhost:PORT/d3pg."""
    port = free_port()
    for name in ("nginx", "data"):
        (tmp_path / name).mkdir()
    service = LiveService(tmp_path / "data", f"https://{HOST}:{port}/d3pg")
    try:
        with nginx(tmp_path / "nginx", port, service.settings.port, request.param):
            yield service
    finally:
        service.close()


@pytest.fixture
def complaints() -> list[str]:
    """What the browser complained of, and what it asked of anything but the public address."""
    return []


@pytest.fixture
def outside(browser: Browser, proxied: LiveService, complaints: list[str]) -> Iterator[Page]:
    """A page of a browser that trusts the proxy's certificate."""
    context = browser.new_context(ignore_https_errors=True)
    page = context.new_page()
    page.set_default_timeout(PATIENCE_MILLISECONDS)
    expect.set_options(timeout=PATIENCE_MILLISECONDS)

    def note(text: str) -> None:
        complaints.append(text)

    page.on("console", lambda each: note(each.text) if each.type in {"error", "warning"} else None)
    page.on("pageerror", lambda error: note(str(error)))
    within = (f"{proxied.url}/", "blob:", "data:")
    page.on("request", lambda each: None if each.url.startswith(within) else note(each.url))
    yield page
    context.close()


def test_everything_is_found_below_the_path(
    outside: Page, proxied: LiveService, complaints: list[str], tmp_path: Path
) -> None:
    sweep = proxied.add_sweep()
    proxied.train(0, 4000)
    outside.goto(proxied.signin_link)
    [cookie] = outside.context.cookies()
    assert cookie["path"] == "/d3pg"
    assert cookie["secure"]
    assert cookie["domain"] == HOST

    outside.get_by_role("link", name="first look").click()
    expect(outside.locator("figure canvas")).to_have_count(2)
    expect(outside.locator("#connection")).to_have_text("Live")
    proxied.train(4000, 8000)
    expect(outside.locator("#counts")).to_have_text("16 running")
    outside.goto(f"{proxied.url}/sweeps/{sweep.id}?table=Pendulum")
    rows = outside.get_by_role("figure", name="Pendulum").locator("tbody tr")
    expect(rows).to_have_count(10)
    proxied.train(8000, 12_000)
    expect(rows).to_have_count(15)

    outside.get_by_role("link", name="Runs", exact=False).first.click()
    outside.locator(".runs tbody th a").first.click()
    expect(outside.locator("#name")).to_contain_text("seed")
    outside.get_by_role("link", name="first look").click()
    outside.get_by_role("link", name="Compare").last.click()
    expect(outside.locator("#legend li")).to_have_count(2)
    outside.get_by_role("link", name="Workers").click()
    expect(outside.get_by_role("heading", level=1)).to_have_text("Workers and the queue")
    outside.get_by_role("link", name="API").click()
    expect(outside.get_by_role("heading", name="d3pg").first).to_be_visible()
    outside.get_by_role("link", name="Back to the dashboard").click()
    outside.get_by_role("button", name="Cancel first look").click()
    outside.get_by_role("button", name="Cancel the sweep").click()
    expect(outside.get_by_role("button", name="Cancel first look")).to_be_visible()
    assert complaints == []

    outside.get_by_role("button", name="Sign out").click()
    expect(outside.get_by_role("heading", level=1)).to_have_text("Not signed in")
    assert outside.url == f"{proxied.url}/signin"
    assert outside.context.cookies() == []
    log = (tmp_path / "nginx" / "access.log").read_text()
    assert "/signin?code=" in log, "a code stands there, which is used up"


def test_answers_name_the_public_address(proxied: LiveService) -> None:
    sweep = proxied.add_sweep()
    token = proxied.settings.token
    assert token is not None
    client = httpx2.Client(
        verify=False,
        headers={"Authorization": f"Bearer {token.get_secret_value()}"},
        base_url=proxied.url.replace(HOST, "127.0.0.1"),
    )
    with client:
        answer = client.get(f"/api/v1/sweeps/{sweep.id}")
        assert answer.json()["links"]["page"] == f"/d3pg/sweeps/{sweep.id}"
        assert client.get("/healthz").headers["strict-transport-security"].startswith("max-age=")
        more = client.get(f"/api/v1/sweeps/{sweep.id}/runs?limit=1").headers["link"]
        assert more.startswith(f"</d3pg/api/v1/sweeps/{sweep.id}/runs?")
        link = client.post("/api/v1/sign-in-links", json={}).json()["link"]
        assert link.startswith(f"{proxied.url}/signin?code=")
        shared = client.post("/api/v1/shares", json={"sweeps": [sweep.id]}).json()
        assert shared["link"].startswith(f"{proxied.url}/signin#share=")
        assert shared["page"] == f"/d3pg/sweeps/{sweep.id}"
        foreign = {"Origin": "https://evil.example"}
        assert client.post("/api/v1/moves", json={}, headers=foreign).status_code == 403
        ours = {"Origin": proxied.url.removesuffix("/d3pg")}
        assert client.post("/api/v1/moves", json={}, headers=ours).status_code == 422


def test_a_shared_link_opens_its_page_to_a_stranger(
    outside: Page, proxied: LiveService, complaints: list[str], tmp_path: Path
) -> None:
    sweep = proxied.add_sweep()
    proxied.train(0, 4000)
    page = f"/sweeps/{sweep.id}?table=Pendulum"
    _, token = proxied.register.add_share((sweep.id,), page, 1, "admin")
    outside.goto(f"{proxied.url}/signin#share={token}")
    expect(outside.locator("figure canvas")).to_have_count(2)
    assert outside.url == f"{proxied.url}{page}"
    expect(outside.locator("#connection")).to_have_text("Live")
    assert token not in (tmp_path / "nginx" / "access.log").read_text()
    assert all("401" in complaint for complaint in complaints), "of the page that asks for a token"
