"""Figures over REST: files with the same bytes each time, and those of the paper."""

import csv
import io
import re
import xml.dom.minidom
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from algorithms.early_end import Divergence
from service.analysis.figures.die_figure import bounces
from service.api.load.side_process import BusyError
from service.settings import Settings
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, measured, random_return, rising, train
from tests.workers.policies.test_rollout import write_policy
from workers.messages.progress import Progress


def test_figures_are_files_with_the_same_bytes_each_time(reader: TestClient, trained: str) -> None:
    png = reader.get(f"{trained}/plot.png")
    assert png.headers["content-type"] == "image/png"
    assert png.content.startswith(b"\x89PNG")
    assert reader.get(f"{trained}/plot.png").content == png.content
    svg = reader.get(f"{trained}/plot.svg")
    assert svg.headers["content-type"] == "image/svg+xml"
    assert reader.get(f"{trained}/plot.svg").content == svg.content
    xml.dom.minidom.parseString(svg.content)  # noqa: S318 - our own
    pdf = reader.get(f"{trained}/plot.pdf")
    assert pdf.headers["content-type"] == "application/pdf"
    assert pdf.content.startswith(b"%PDF-")
    assert b"CreationDate" not in pdf.content
    assert reader.get(f"{trained}/plot.pdf").content == pdf.content


def test_a_figure_in_another_form_is_refused(reader: TestClient, trained: str) -> None:
    refusal = reader.get(f"{trained}/plot.gif")
    assert refusal.status_code == 422
    assert refusal.json()["errors"][0] == {
        "field": "form",
        "message": "Input should be 'png', 'svg' or 'pdf'",
        "limit": "'png', 'svg' or 'pdf'",
    }


def test_a_figure_of_nothing_yet(client: TestClient) -> None:
    link = client.post("/api/v1/sweeps", json=SWEEP).json()["links"]["self"]
    assert client.get(f"{link}/plot.png").status_code == 200


@pytest.mark.parametrize("name", ["$\\frac{ --><script>", "a\x01b\x1f \u202ex 😀 日本", "x" * 200])
def test_any_name_can_stand_on_a_figure(client: TestClient, name: str) -> None:
    body = changed(name=name, seeds=1, environments=["Pendulum"])
    link = client.post("/api/v1/sweeps", json=body).json()["links"]["self"]
    svg = client.get(f"{link}/plot.svg")
    assert svg.status_code == 200
    xml.dom.minidom.parseString(svg.content)  # noqa: S318 - our own


def test_a_figure_of_too_many_curves_is_refused(client: TestClient) -> None:
    weights = [{"w1": k / 10, "w2": j / 10} for k in range(10) for j in range(10)]
    algorithms = [
        {"name": "hybrid-ddpg", "weights": weights, "config": {"batch_size": size}}
        for size in (32, 64, 128)
    ]
    body = changed(algorithms=algorithms, seeds=1)
    link = client.post("/api/v1/sweeps", json=body).json()["links"]["self"]
    refusal = client.get(f"{link}/plot.png")
    assert refusal.status_code == 422
    assert "600" in refusal.json()["detail"]
    assert client.get(f"{link}/curves").status_code == 200


def texts(svg: bytes) -> str:
    """What an SVG of ours says."""
    document = xml.dom.minidom.parseString(svg)  # noqa: S318 - our own
    return " ".join(
        "".join(node.data for node in element.childNodes if node.nodeType == node.TEXT_NODE)
        for element in document.getElementsByTagName("text")
    )


def test_a_figure_of_the_paper_shows_its_algorithms_and_its_definition(
    client: TestClient, store: Store
) -> None:
    store.record_random_return(random_return("Pendulum", RANDOM))
    names = ("ddpg", "hybrid-ddpg", "hybrid-ddpg-cosine")
    body = changed(algorithms=[{"name": name} for name in names], environments=["Pendulum"])
    link = client.post("/api/v1/sweeps", json=body).json()["links"]["self"]
    train(store, 3, rising)
    cosine = client.get(f"{link}/figures/5.svg")
    assert cosine.status_code == 200
    said = texts(cosine.content)
    assert "Figure 5, the cosine loss: small" in said
    assert "hybrid-ddpg-cosine" in said
    assert "n = 3." in said
    assert "Normalised: 0 is the mean return" in said
    rows = list(csv.DictReader(io.StringIO(client.get(f"{link}/figures/5.csv").text)))
    assert {row["entry"] for row in rows} == {"ddpg", "hybrid-ddpg-cosine"}
    assert len(rows) == 2 * 2 * 3
    fourth = texts(client.get(f"{link}/figures/4.svg").content)
    assert "hybrid-ddpg" in fourth
    assert "hybrid-ddpg-cosine" not in fourth


@pytest.mark.parametrize(
    ("number", "environment", "told"),
    [
        ("2", "MassPoint", ("the critic of the mass point", "epoch 0: off by", "n = 3.")),
        ("3", "RollingDie", ("the die's way to the target", "best run: seed 2", "start 0: ")),
    ],
)
def test_a_figure_of_what_was_learned(
    client: TestClient,
    store: Store,
    settings: Settings,
    number: str,
    environment: str,
    told: tuple[str, ...],
) -> None:
    store.record_random_return(random_return(environment, RANDOM))
    body = changed(environments=[environment], algorithms=[{"name": "hybrid-ddpg"}])
    sweep = client.post("/api/v1/sweeps", json=body).json()
    link = f"{sweep['links']['self']}/figures/{number}"
    assert sweep["links"][f"figure_{number}"] == f"{link}.png"
    assert "figure_5" not in sweep["links"]
    nothing = client.get(f"{link}.svg")
    assert nothing.status_code == 200, nothing.text
    train(store, 3, rising)
    for run in range(3):
        write_policy(settings.checkpoint_place, f"{sweep['id']}-{run}", environment)
    figure = client.get(f"{link}.svg")
    assert figure.status_code == 200, figure.text
    assert client.get(f"{link}.svg").content == figure.content
    said = texts(figure.content)
    for text in told:
        assert text in said
    rows = list(csv.DictReader(io.StringIO(client.get(f"{link}.csv").text)))
    if number == "2":
        assert Counter(row["quantity"] for row in rows)["Q*"] == 41 * 21
        epochs = {row["epoch"] for row in rows if row["quantity"] == "Q"}
        assert len([row for row in rows if row["quantity"] == "policy"]) == 41 * len(epochs) > 0
    else:
        assert {row["start"] for row in rows} == {"0", "1", "2"}
        assert {row["seed"] for row in rows} == {"2"}
        counted = re.findall(r"start 0: (\d+) bounce", said)[0]
        begun = [row for row in rows if row["start"] == "0" and row["bounce_begins"] == "True"]
        assert len(begun) == int(counted)
    shown = "*-2" if number == "3" else "*-0"
    (file,) = Path(settings.checkpoint_place).glob(f"{shown}/policy")
    file.write_bytes(file.read_bytes()[:-1])
    refusal = client.get(f"{link}.svg")
    assert refusal.status_code == 409
    assert "cannot be read" in refusal.json()["detail"]


def test_the_best_run_is_one_that_reached_its_end(
    client: TestClient, store: Store, settings: Settings
) -> None:
    """Seed 2 earned the most, and diverged."""
    body = changed(environments=["RollingDie"], algorithms=[{"name": "hybrid-ddpg"}])
    sweep = client.post("/api/v1/sweeps", json=body).json()
    link = f"{sweep['links']['self']}/figures/3.svg"
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    measurements = tuple(measured(spec, 4000, rising(spec, 4000)) for spec in claim.specs)
    store.record(claim, Progress(4000, measurements=measurements))
    assert "no run has ended" in texts(client.get(link).content)
    diverged = (Divergence(2, 4000, 2000, "critic_loss"),)
    store.record(claim, Progress(4000, diverged=diverged, finished=(0, 1)))
    for run in range(3):
        write_policy(settings.checkpoint_place, f"{sweep['id']}-{run}", "RollingDie")
    assert "best run: seed 1" in texts(client.get(link).content)


def test_a_bounce_is_contacts_that_follow_one_another_at_once() -> None:
    assert bounces([]) == []
    assert bounces([36, 38, 40, 77, 107, 112, 118]) == [36, 77, 107, 118]


def test_a_figure_without_runs_is_not_there(reader: TestClient, trained: str) -> None:
    refusal = reader.get(f"{trained}/figures/6.png")
    assert refusal.status_code == 404
    assert "shows hybrid-sac, sac" in refusal.json()["detail"]


@pytest.mark.parametrize("path", ["figures/1.png", "figures/four.png", "figures/4.bmp"])
def test_other_figures_are_refused(reader: TestClient, trained: str, path: str) -> None:
    assert reader.get(f"{trained}/{path}").status_code == 422


def test_when_too_many_wait_it_says_so(
    app: FastAPI, client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def busy(*_: object, **__: object) -> bytes:
        raise BusyError("16 others wait already")

    link = client.post("/api/v1/sweeps", json=SWEEP).json()["links"]["self"]
    monkeypatch.setattr(app.state.side, "call", busy)
    refusal = client.get(f"{link}/plot.png")
    assert refusal.status_code == 503
    assert refusal.headers["retry-after"] == "5"
    assert "16 others wait" in refusal.json()["detail"]


def test_a_figure_shows_what_is_asked_in_that_order_and_under_those_names(
    reader: TestClient, trained: str
) -> None:
    labels = [curve["label"] for curve in curves_of(reader, trained)]
    query: dict[str, Any] = {
        "metric": "return_mean",
        "environment": ["Pendulum", "MassPoint"],
        "entry": [labels[1], labels[0]],
        "name": f"{labels[1]}=ours",
        "colour": f"{labels[1]}=#123456",
        "title": False,
        "caption": False,
    }
    svg = reader.get(f"{trained}/plot.svg", params=query)
    assert svg.status_code == 200, svg.text
    said = texts(svg.content)
    assert said.index("Pendulum") < said.index("MassPoint")
    assert said.index("ours") < said.index(labels[0])
    assert labels[1] not in said.split()
    assert "return_history" not in said
    assert "Normalised: 0 is" not in said
    assert "#123456" in svg.text


def test_a_figure_s_data_are_what_it_draws(reader: TestClient, trained: str) -> None:
    query = {"metric": "return_mean", "environment": "Pendulum", "band": "ci95"}
    answer = reader.get(f"{trained}/plot.csv", params=query)
    assert answer.headers["content-type"].startswith("text/csv")
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    curve = curves_of(reader, trained, band="ci95")[0]
    own = [row for row in rows if row["entry"] == curve["label"]]
    assert [float(row["mean"]) for row in own] == pytest.approx(curve["mean"], rel=1e-8)
    assert [float(row["low"]) for row in own] == pytest.approx(curve["low"], rel=1e-8)
    assert {row["environment"] for row in rows} == {"Pendulum"}


def test_a_pdf_has_the_fonts_that_journals_take(reader: TestClient, trained: str) -> None:
    """TrueType outlines (Type 42), never Type 3."""
    pdf = reader.get(f"{trained}/plot.pdf").content
    assert b"/Type0" in pdf
    assert b"/Type3" not in pdf


def test_a_figure_is_as_wide_as_a_column(reader: TestClient, trained: str) -> None:
    query: dict[str, Any] = {"metric": "return_mean", "columns": 1, "height": 2, "font_size": 6}
    svg = xml.dom.minidom.parseString(  # noqa: S318 - our own
        reader.get(f"{trained}/plot.svg", params=query).content
    ).documentElement
    assert svg is not None
    assert svg.getAttribute("width") == "234pt"  # 3.25 inches
    assert svg.getAttribute("height") == "144pt"


@pytest.mark.parametrize(
    "query",
    [
        {"smoothing": 0.9, "logy": True, "seeds": True},
        {"metric": "critic_loss", "logy": True, "smoothing": 0.5, "robust": True},
        {"band": "none", "logx": True, "align": True, "legend": False},
        {"xmin": 1000, "xmax": 3000, "ymin": 0, "ymax": 1, "per_row": 1, "metric": "return_mean"},
        {"normalized": False, "logy": True},
    ],
)
def test_a_figure_in_every_look(reader: TestClient, trained: str, query: dict[str, Any]) -> None:
    answer = reader.get(f"{trained}/plot.svg", params=query)
    assert answer.status_code == 200, answer.text
    assert texts(answer.content)


@pytest.mark.parametrize(
    ("query", "field", "told"),
    [
        ({"entry": "nobody"}, "entry[0]", "it has: "),
        ({"environment": ["Pendulum", "Mars"]}, "environment[1]", "MassPoint, Pendulum"),
        ({"colour": "ddpg=blue"}, "colour[0]", "pattern"),
        ({"ymin": 1, "ymax": 0}, "ymax", "must be above ymin"),
        ({"columns": 1, "width": 3}, "width", "leave out width or columns"),
        ({"smoothing": 1}, "smoothing", "less than 1"),
        ({"colours": "x"}, "colours", "did you mean 'colour'"),
    ],
)
def test_a_figure_that_cannot_be_drawn_is_refused_by_field(
    reader: TestClient, trained: str, query: dict[str, Any], field: str, told: str
) -> None:
    refusal = reader.get(f"{trained}/plot.pdf", params=query)
    assert refusal.status_code == 422
    faults = {fault["field"]: fault["message"] for fault in refusal.json()["errors"]}
    assert told in faults[field]


def curves_of(reader: TestClient, sweep: str, **query: str) -> list[dict[str, Any]]:
    """The curves of Pendulum, as JSON."""
    panels = reader.get(f"{sweep}/curves", params=query).json()["panels"]
    [panel] = [panel for panel in panels if panel["environment"] == "Pendulum"]
    return list(panel["curves"])
