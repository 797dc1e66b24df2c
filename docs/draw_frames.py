"""Draw the frames of docs/concepts/frames.md as small SVG files.

python docs/draw_frames.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

PICTURES = Path(__file__).parent / "pictures"
INERTIAL, ORBIT, BODY, GREY = "#0072b2", "#009e73", "#d55e00", "#777777"

Point = np.ndarray


class Drawing:
    """Lines in space, seen from above and the side; y of the picture points down."""

    def __init__(self, width: int, height: int, centre: tuple[float, float], scale: float) -> None:
        self.size, self.centre, self.scale = (width, height), centre, scale
        self.parts: list[str] = []

    def at(self, point: Point) -> tuple[float, float]:
        """Where a point in space is in the picture."""
        east, up = math.radians(-35.0), math.radians(22.0)
        x, y, z = np.asarray(point, float)
        across = -x * math.sin(east) + y * math.cos(east)
        away = x * math.cos(east) + y * math.sin(east)
        height = z * math.cos(up) - away * math.sin(up)
        return self.centre[0] + self.scale * across, self.centre[1] - self.scale * height

    def path(self, points: list[Point], colour: str, width: float = 1.5, more: str = "") -> None:
        """Draw a line through points."""
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, points))
        self.parts.append(
            f'<polyline points="{places}" fill="none" stroke="{colour}" '
            f'stroke-width="{width}" {more}/>'
        )

    def arrow(self, start: Point, along: Point, label: str, colour: str) -> None:
        """Draw an arrow with a label beyond its tip."""
        tip = np.asarray(start) + along
        self.path([start, tip], colour, 2.5, f'marker-end="url(#{colour[1:]})"')
        (x0, y0), (x, y) = self.at(start), self.at(tip)
        right, down = np.array([x - x0, y - y0]) / math.hypot(x - x0, y - y0)
        anchor = "middle" if abs(right) < 0.4 else "start" if right > 0.0 else "end"
        self.write(x + 9.0 * right, y + 5.0 + 15.0 * down, label, colour, anchor)

    def write(self, x: float, y: float, text: str, colour: str, anchor: str = "start") -> None:
        """Write a few words at a place of the picture."""
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">{text}</text>'
        )

    def turn(self, centre: Point, axis: Point, radius: float, colour: str) -> None:
        """Draw the arc of a positive turn about an axis."""
        axis = np.asarray(axis, float) / np.linalg.norm(axis)
        first = np.cross(axis, [0.3, -0.5, 0.81])
        first /= np.linalg.norm(first)
        second = np.cross(axis, first)
        angles = np.radians(np.linspace(0.0, 270.0, 46))
        points = [centre + radius * (math.cos(a) * first + math.sin(a) * second) for a in angles]
        self.path(points, colour, 2.0, f'marker-end="url(#{colour[1:]})"')

    def save(self, name: str) -> None:
        """Write the drawing, on white, so that it shows on dark pages too."""
        heads = "".join(
            f'<marker id="{c[1:]}" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="5" '
            f'markerHeight="5" orient="auto"><path d="M0 0 8 4 0 8z" fill="{c}"/></marker>'
            for c in (INERTIAL, ORBIT, BODY, GREY)
        )
        width, height = self.size
        text = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" font-family="sans-serif" font-size="15">\n'
            f'<defs>{heads}</defs>\n<rect width="{width}" height="{height}" fill="white"/>\n'
        )
        (PICTURES / name).write_text(text + "\n".join(self.parts) + "\n</svg>\n", encoding="utf-8")


def circle(radius: float, first: Point, second: Point) -> list[Point]:
    """Points around the origin, from one direction towards another."""
    angles = np.radians(np.linspace(0.0, 360.0, 73))
    return [radius * (math.cos(a) * first + math.sin(a) * second) for a in angles]


def orbit_and_inertial() -> None:
    """The Earth, the inertial axes, and a satellite with its orbit axes."""
    drawing = Drawing(640, 460, (300.0, 235.0), 100.0)
    x, y, z = np.eye(3)
    drawing.path(circle(0.75, x, y), GREY, 1.0)
    for colour, axis, name in zip(
        3 * [INERTIAL], (x, y, z), ("x: equinox", "y", "z: north"), strict=True
    ):
        drawing.arrow(np.zeros(3), 1.25 * axis, name, colour)
    node, up = np.array([math.cos(0.5), math.sin(0.5), 0.0]), np.array([0.0, 0.0, 1.0])
    slope = math.radians(60.0)
    across = math.cos(slope) * np.cross(up, node) + math.sin(slope) * up
    drawing.path(circle(1.75, node, across), GREY, 1.5, 'stroke-dasharray="5 4"')
    place = math.radians(55.0)
    r = math.cos(place) * node + math.sin(place) * across
    v = -math.sin(place) * node + math.cos(place) * across
    satellite = 1.75 * r
    down, side = -r, -np.cross(r, v)
    for axis, name in ((np.cross(side, down), "x"), (side, "y"), (down, "z: nadir")):
        drawing.arrow(satellite, 0.62 * axis, name, ORBIT)
    drawing.write(14.0, 24.0, "inertial axes: EME2000", INERTIAL)
    drawing.write(14.0, 46.0, "orbit axes, at the satellite", ORBIT)
    drawing.write(14.0, 448.0, "z = -r/|r|,  y = -(r x v)/|r x v|,  x = y x z: forward", "#333333")
    drawing.save("frames-orbit.svg")


def body_in_orbit() -> None:
    """Body axes after a turn by psi, theta and phi, and the sense of positive turns."""
    drawing = Drawing(640, 300, (185.0, 110.0), 115.0)
    flip = np.diag([1.0, -1.0, -1.0])  # orbit z points down in the picture
    phi, theta, psi = np.radians([20.0, 30.0, -20.0])
    rx = np.array(
        [[1, 0, 0], [0, math.cos(phi), -math.sin(phi)], [0, math.sin(phi), math.cos(phi)]]
    )
    ry = np.array(
        [[math.cos(theta), 0, math.sin(theta)], [0, 1, 0], [-math.sin(theta), 0, math.cos(theta)]]
    )
    rz = np.array(
        [[math.cos(psi), -math.sin(psi), 0], [math.sin(psi), math.cos(psi), 0], [0, 0, 1]]
    )
    turned = rz @ ry @ rx
    for k, name in enumerate("xyz"):
        drawing.arrow(np.zeros(3), 1.25 * flip @ np.eye(3)[k], f"{name}, orbit", ORBIT)
        drawing.arrow(np.zeros(3), 1.1 * flip @ turned[:, k], f"{name}, body", BODY)
    lines = (
        ("attitude_deg = [phi, theta, psi]", "#333333"),
        ("1. psi about z", BODY),
        ("2. theta about the new y", BODY),
        ("3. phi about the new x", BODY),
        ("All turns are right-handed: thumb along", "#333333"),
        ("the axis, fingers the way it turns.", "#333333"),
    )
    for row, (text, colour) in enumerate(lines):
        drawing.write(370.0, 60.0 + 26.0 * row, text, colour)
    drawing.save("frames-body.svg")


def wheel_and_body() -> None:
    """A wheel's torque and what the body receives."""
    drawing = Drawing(640, 300, (170.0, 190.0), 95.0)
    corners = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)], float) * 0.7
    for i, one in enumerate(corners):
        for other in corners[i + 1 :]:
            if np.isclose(np.linalg.norm(one - other), 1.4):
                drawing.path([one, other], GREY, 1.0)
    z = np.array([0.0, 0.0, 1.0])
    drawing.path(circle(0.4, np.eye(3)[0], np.eye(3)[1]), INERTIAL, 3.0)
    drawing.arrow(np.zeros(3), 1.45 * z, "spin axis of the wheel", INERTIAL)
    drawing.turn(np.zeros(3), z, 0.55, INERTIAL)
    drawing.turn(1.15 * z, -z, 0.3, BODY)
    lines = (
        ("A positive wheel torque speeds the wheel up", INERTIAL),
        ("about its axis, right-handed.", INERTIAL),
        ("The body receives the opposite torque,", BODY),
        ("-A tau_w for all wheels together.", BODY),
        ("torque_body in results is A tau_w: on the wheels.", "#333333"),
    )
    for row, (text, colour) in enumerate(lines):
        drawing.write(300.0, 120.0 + 26.0 * row, text, colour)
    drawing.save("frames-wheel.svg")


if __name__ == "__main__":
    orbit_and_inertial()
    body_in_orbit()
    wheel_and_body()
