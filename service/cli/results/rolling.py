"""`d3pg rollout`: a run's policy acting, as an animated GIF or as a PNG a frame."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from PIL import Image

from physics.drawing import Capsule, Drawing, Polygon
from service.api.schemas.rollout_answer import RolloutAnswer
from service.cli.identifiers import RunId
from service.cli.terminal import AsJson, print_json, say
from service.client import Client

FRAME_SECONDS = 0.04  # browsers slow faster GIFs down


def rollout(
    run_id: RunId,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="A .gif file, or a folder for PNGs.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the start that the task draws.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Play the policy of a run: as a GIF, as frames, or only its return."""
    if output is not None and output.suffix.lower() not in ("", ".gif"):
        raise typer.BadParameter(
            f"{output} must end in .gif, or be a folder without a suffix", param_hint="--output"
        )
    with Client() as client:
        episode = client.rollout(run_id, seed)
    if as_json:
        print_json(episode)
    else:
        say(
            f"{run_id} at timestep {episode.timestep:,} in {episode.environment}: "
            f"return {sum(episode.rewards):.5g} in {len(episode.rewards)} steps"
        )
    if output is not None:
        save(episode, output)
        if not as_json:
            say(f"Wrote {output}")


def save(episode: RolloutAnswer, output: Path) -> None:
    """Write a GIF in the task's own time, or every frame as a PNG into a folder."""
    drawings = drawings_of(episode)
    if output.suffix.lower() == ".gif":
        every = max(1, round(FRAME_SECONDS / episode.dt))
        first, *others = (Image.fromarray(d.rgb_array()) for d in list(drawings)[::every])
        milliseconds = round(1000 * every * episode.dt)
        first.save(output, save_all=True, append_images=others, duration=milliseconds, loop=0)
        return
    output.mkdir(parents=True, exist_ok=True)
    for number, drawing in enumerate(drawings):
        Image.fromarray(drawing.rgb_array()).save(output / f"{number:05}.png")


def drawings_of(episode: RolloutAnswer) -> Iterator[Drawing]:
    """The film's frames as drawings."""
    for number, frame in enumerate(episode.frames):
        left, bottom, right, top = episode.views[number if len(episode.views) > 1 else 0]
        shapes = tuple(shape_of(episode, int(style), points) for style, *points in frame)
        yield Drawing((left, bottom, right, top), shapes)


def shape_of(episode: RolloutAnswer, number: int, coordinates: list[float]) -> Capsule | Polygon:
    """A shape of the film, of the style of that number."""
    style = episode.styles[number]
    points = tuple(zip(coordinates[::2], coordinates[1::2], strict=True))
    if style.shape == "polygon":
        return Polygon(points, style.role)
    return Capsule(points[0], points[1], style.radius, style.role)
