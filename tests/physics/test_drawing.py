"""Shapes, and the pixels they cover."""

import json

import numpy as np
import pytest

from physics.drawing import Capsule, Drawing, Polygon, box, disc

VIEW = (-1.0, -1.0, 1.0, 1.0)


def area(shape: Capsule | Polygon) -> float:
    """The area that a shape's pixels cover, by how far they moved from white to the colour."""
    image = Drawing(VIEW, (shape,)).rgb_array(width=200).astype(float)
    full = image.min()
    return float(((255.0 - image[..., 0]) / (255.0 - full)).sum() / 100**2)


def test_areas() -> None:
    assert area(disc((0.1, 0.2), 0.5, "body")) == pytest.approx(np.pi / 4, rel=2e-2)
    capsule = Capsule((-0.4, 0.0), (0.3, 0.2), 0.1, "body")
    assert area(capsule) == pytest.approx(0.2 * np.hypot(0.7, 0.2) + np.pi * 0.01, rel=2e-2)
    assert area(box((0.0, 0.1), 0.6, 0.4, "body", angle=0.7)) == pytest.approx(0.24, rel=2e-2)


def test_a_polygon_may_be_concave() -> None:
    notch = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (0.0, 0.0), (-0.5, 0.5))
    assert area(Polygon(notch, "body")) == pytest.approx(0.75, rel=2e-2)


def test_up_is_up_and_later_shapes_lie_on_top() -> None:
    drawing = Drawing(VIEW, (disc((0.0, 0.8), 0.1, "body"), disc((0.0, 0.8), 0.1, "target")))
    image = drawing.rgb_array(width=100)
    assert image[10, 50].tolist() == [60, 150, 90]
    assert image[90, 50].tolist() == [255, 255, 255]


def test_the_data_survive_json() -> None:
    drawing = Drawing(VIEW, (disc((0.0, 0.8), 0.1, "body"), box((0, 0), 1, 1, "link")))
    data = json.loads(json.dumps(drawing.as_data()))
    assert data["view"] == list(VIEW)
    assert [shape["shape"] for shape in data["shapes"]] == ["capsule", "polygon"]
    assert data["shapes"][0]["radius"] == 0.1


def test_an_unknown_role_is_refused_where_the_shape_is_made() -> None:
    for make in (lambda: disc((0.0, 0.0), 0.1, "goal"), lambda: Polygon((), "goal")):  # type: ignore[arg-type]
        with pytest.raises(ValueError, match=r"one of ground, body, .*, target, not 'goal'"):
            make()
