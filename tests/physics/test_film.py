"""Films: every frame can be drawn again from the data as it was drawn from the state."""

import json

import pytest

import physics
from physics.drawing import Capsule, Drawing, Polygon, disc
from physics.film import film


def test_styles_are_said_once_and_shapes_keep_their_order() -> None:
    ball, line = disc((0.0, 1.0), 0.5, "body"), Polygon(((0.0, 0.0), (1.0, 0.0)), "ground")
    moved = disc((0.123456, 2.0), 0.5, "body")
    view = (-1.0, -1.0, 1.0, 3.0)
    data = film([Drawing(view, (line, ball)), Drawing(view, (line, moved, moved))])
    assert data["styles"] == [
        {"shape": "polygon", "role": "ground", "radius": 0.0},
        {"shape": "capsule", "role": "body", "radius": 0.5},
    ]
    ground = [0, 0.0, 0.0, 1.0, 0.0]
    there = [1, 0.1235, 2.0, 0.1235, 2.0]
    assert data["frames"] == [[ground, [1, 0.0, 1.0, 0.0, 1.0]], [ground, there, there]]
    assert data["views"] == [list(view)]


def test_a_view_that_moves_is_said_for_each_frame() -> None:
    shapes = (Capsule((0.0, 0.0), (1.0, 0.0), 0.1, "link"),)
    drawings = [Drawing((float(x), 0.0, x + 1.0, 1.0), shapes) for x in range(3)]
    assert film(drawings)["views"] == [
        [0.0, 0.0, 1.0, 1.0],
        [1.0, 0.0, 2.0, 1.0],
        [2.0, 0.0, 3.0, 1.0],
    ]


@pytest.mark.parametrize("name", physics.names())
def test_every_task_can_be_filmed(name: str) -> None:
    task = physics.make(name)
    drawings = [task.draw(state) for state in task.initial_states([0, 1, 2])]
    data = json.loads(json.dumps(film(drawings), allow_nan=False))
    for drawing, frame in zip(drawings, data["frames"], strict=True):
        again = [data["styles"][style] for style, *_ in frame]
        assert [each["role"] for each in again] == [shape.role for shape in drawing.shapes]
        for shape, (_, *numbers) in zip(drawing.shapes, frame, strict=True):
            points = shape.points if isinstance(shape, Polygon) else (shape.start, shape.end)
            flat = [number for point in points for number in point]
            assert numbers == pytest.approx(flat, abs=1e-4)
