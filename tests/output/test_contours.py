"""Contours of functions whose levels are known."""

import numpy as np
import pytest
from drawn_styles import areas, marks, strokes

from gimcli.output.contours import contour_picture
from gimcli.output.graph import Axis

X, Y = np.linspace(-1.0, 1.0, 201), np.linspace(-1.0, 1.0, 161)


def picture(values):
    return contour_picture(Axis("a", "mm"), Axis("b"), Axis("f"), X, Y, values)


def area(outline):
    z = np.append(outline, outline[0])
    return 0.5 * abs(float(np.sum((z[:-1].conj() * z[1:]).imag)))


def bands(found):
    return [sum(area(z) for z in outlines) for outlines in areas(found).values()]


def test_levels_of_a_plane_are_straight_lines():
    found = picture(np.tile(X, (len(Y), 1)))
    (lines,) = strokes(found).values()
    levels = sorted(float(line.real.mean()) for line in lines)
    assert levels == pytest.approx([-0.8, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.8], abs=1e-12)
    assert all(np.ptp(line.real) < 1e-12 for line in lines)
    assert sorted(text.text for text in found.texts)[-1] == "0.8"
    assert bands(found) == pytest.approx([0.4] * 10)
    assert found.labels == ("a [mm]", "b")


def test_bands_around_a_minimum_are_rings():
    """Areas with holes: the band between r1 and r2 has the area pi (r2^2 - r1^2)."""
    x, y = np.meshgrid(X, Y)
    found = picture(x**2 + y**2)
    assert bands(found)[:5] == pytest.approx([0.2 * np.pi] * 5, rel=2e-3)
    assert sum(bands(found)) == pytest.approx(4.0)


def test_designs_without_a_value_are_blank():
    x, y = np.meshgrid(X, Y)
    found = picture(np.where(x + y > 0.0, np.nan, x))
    assert sum(bands(found)) == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("value", [2.0, np.nan])
def test_constants_have_no_lines(value):
    found = picture(np.full((len(Y), len(X)), value))
    assert not any(strokes(found).values())
    assert sum(bands(found)) == pytest.approx(0.0 if np.isnan(value) else 4.0)


def test_values_without_neighbours_are_marked_and_written():
    values = np.full((len(Y), len(X)), np.nan)
    values[40, 50], values[120, 150], values[120, 151] = 2.5, 7.0, 8.0  # one alone, two side by side
    found = picture(values)
    (places,) = marks(found).values()
    assert places == pytest.approx([-0.5 - 0.5j, 0.5 + 0.5j, 0.51 + 0.5j])
    assert [text.text for text in found.texts] == ["2.5", "7", "8"]


def test_values_beside_an_area_are_marked_only():
    values = np.full((len(Y), len(X)), np.nan)
    values[40, 50], values[80:82, 100:102] = 2.5, 1.0
    found = picture(values)
    assert [place for places in marks(found).values() for place in places] == pytest.approx([-0.5 - 0.5j])
    assert "2.5" not in [text.text for text in found.texts]


def test_areas_have_no_marks():
    x, _ = np.meshgrid(X, Y)
    assert not any(marks(picture(np.where(x > 0.0, np.nan, x))).values())
