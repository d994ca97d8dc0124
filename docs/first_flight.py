"""Draws docs/_static/first-flight.svg: where everything stands and which way its axes point."""

from __future__ import annotations

from pathlib import Path

WIDTH, HEIGHT = 960, 500
INK, MUTED, PAPER = "#1f2933", "#66727e", "#ffffff"
LEFT, RIGHT, BAR = "#0072B2", "#D55E00", "#b79f6b"
AXES = {"x": "#c92a2a", "y": "#2b8a3e", "z": "#1864ab"}

#: Places of the markers on a vehicle, m: no two vehicles alike, and none symmetric.
MARKERS = {
    "left": ((0.16, 0.1, 0.1), (-0.12, 0.14, 0.06), (-0.05, -0.15, 0.13), (0.04, 0.0, 0.17)),
    "right": ((0.1, 0.16, 0.15), (-0.16, 0.02, 0.08), (0.08, -0.14, 0.06), (-0.02, 0.04, 0.18)),
}

#: Pixels a metre, and where the world's origin is drawn.
SCALE, ORIGIN = 118.0, (262.0, 452.0)


def seen(x, y, z):
    """A point of the world on the page: x to the right, y into it, z up."""
    return ORIGIN[0] + SCALE * (x + 0.42 * y), ORIGIN[1] - SCALE * (z + 0.30 * y)


class Drawing:
    """SVG elements, one after the other."""

    def __init__(self):
        self.parts = []

    def line(self, a, b, colour=INK, width=1.6, dash="", arrow=False):
        (x1, y1), (x2, y2) = a, b
        extra = f' stroke-dasharray="{dash}"' if dash else ""
        extra += f' marker-end="url(#tip{colour[1:]})"' if arrow else ""
        self.parts.append(
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
            f'stroke-width="{width}"{extra}/>'
        )

    def shape(self, points, fill="none", colour=INK, width=1.2, dash=""):
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        extra = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<polygon points="{text}" fill="{fill}" stroke="{colour}" '
            f'stroke-width="{width}"{extra}/>'
        )

    def dot(self, at, radius, fill):
        self.parts.append(f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius}" fill="{fill}"/>')

    def text(self, at, words, colour=INK, size=13, anchor="start", weight="normal"):
        self.parts.append(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{colour}" font-size="{size}" '
            f'text-anchor="{anchor}" font-weight="{weight}">{words}</text>'
        )

    def box(self, x, y, width, height, lines, fill):
        self.parts.append(
            f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="6" fill="{fill}" '
            f'stroke="{INK}" stroke-width="1.2"/>'
        )
        for k, words in enumerate(lines):
            self.text((x + width / 2, y + 21 + 18 * k), words, size=13 if k else 14,
                      anchor="middle", weight="normal" if k else "bold")  # fmt: skip

    def axes(self, at, names, length=0.42):
        """x, y, z arrows at a point of the world, with their names."""
        x, y, z = at
        for axis, (dx, dy, dz) in zip("xyz", ((1, 0, 0), (0, 1, 0), (0, 0, 1)), strict=True):
            end = seen(x + length * dx, y + length * dy, z + length * dz)
            self.line(seen(*at), end, AXES[axis], 2.0, arrow=True)
            shift = {"x": (5, -6), "y": (7, -2), "z": (6, -5)}[axis]
            self.text((end[0] + shift[0], end[1] + shift[1]), names[axis], AXES[axis], 12)


def craft(drawing, at, colour, name):
    """A quadrotor with its markers, no two alike."""
    x, y, z = at
    for dx, dy in ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)):
        drawing.line(seen(*at), seen(x + dx, y + dy, z), colour, 3.0)
        ring = [(0.11, 0.0), (0.0, 0.11), (-0.11, 0.0), (0.0, -0.11)]
        drawing.shape([seen(x + dx + a, y + dy + b, z + 0.05) for a, b in ring], colour=colour)
    for dx, dy, dz in MARKERS[name]:
        drawing.dot(seen(x + dx, y + dy, z + dz), 3.6, MUTED)


def room(drawing):
    """The fence, the load and the two vehicles at their places."""
    low, high = (-1.75, -0.75), (1.75, 0.95)
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    drawing.shape([seen(x, y, 0.0) for x, y in corners], "#f3f5f7", MUTED, 1.2, "5 4")
    top = [seen(x, y, 3.15) for x, y in corners]
    drawing.shape(top, "none", MUTED, 1.0, "5 4")
    for x, y in corners:
        drawing.line(seen(x, y, 0.0), seen(x, y, 3.15), MUTED, 1.0, "5 4")
    drawing.text((top[3][0] + 8, top[3][1] + 18), "limits.fence_low to fence_high", MUTED, 12)
    drawing.axes((-1.5, -0.55, 0.0), {"x": "x east", "y": "y north", "z": "z up"}, 0.5)
    ends = [(-0.75, 0.2, 0.95), (0.75, 0.2, 0.95)]
    crafts = [(-0.75, 0.2, 2.16), (0.75, 0.2, 2.16)]
    for end, top_of, colour in zip(ends, crafts, (LEFT, RIGHT), strict=True):
        drawing.line(seen(*end), seen(*top_of), colour, 1.8)
    drawing.line(seen(*ends[0]), seen(*ends[1]), BAR, 8.0)
    for dx, dz in ((-0.55, 0.09), (-0.1, 0.16), (0.3, 0.07), (0.62, 0.12)):
        drawing.dot(seen(dx, 0.2, 0.95 + dz), 3.6, MUTED)
    craft(drawing, crafts[0], LEFT, "left")
    craft(drawing, crafts[1], RIGHT, "right")
    drawing.axes((*crafts[0][:2], 2.16), {"x": "x forward", "y": "y left", "z": "z up"})
    drawing.axes((0.0, 0.2, 0.95), {"x": "x", "y": "y", "z": "z"}, 0.36)
    place = seen(0.75, 0.2, 1.82)
    drawing.text((place[0] - 10, place[1] - 4), "plant.cable_length:", MUTED, 12, "end")
    drawing.text((place[0] - 10, place[1] + 11), "centre of mass to", MUTED, 12, "end")
    drawing.text((place[0] - 10, place[1] + 26), "plant.attachment", MUTED, 12, "end")
    drawing.text((seen(-0.75, 0.2, 2.16)[0] - 34, seen(0, 0, 2.75)[1] - 40), "vehicle_1: body left",
                 LEFT, 13, "middle", "bold")  # fmt: skip
    drawing.text((seen(0.75, 0.2, 2.16)[0] + 6, seen(0, 0, 2.75)[1] - 40), "vehicle_2: body right",
                 RIGHT, 13, "middle", "bold")  # fmt: skip


def wires(drawing):
    """What is connected to what."""
    left, width = 668, 270
    capture = ("QTM", "6DOF bodies left, right, bar", "poses, 100 Hz or more")
    station = ("ground station: multilift fly", "one LAB.toml, one scenario",
               "estimate, law, supervisor, log")  # fmt: skip
    drawing.box(left, 34, width, 66, capture, "#eef3f8")
    drawing.box(left, 178, width, 68, station, "#e9f5ee")
    drawing.box(left, 368, 126, 66, ("Pixhawk 1", "PX4 or", "ArduPilot"), "#eaf2fa")
    drawing.box(left + 144, 368, 126, 66, ("Pixhawk 2", "another", "system id"), "#fbeee6")
    middle = left + width / 2
    drawing.line((middle, 100), (middle, 172), INK, 1.8, arrow=True)
    drawing.text((middle + 12, 141), "RT protocol, port 22223", MUTED, 12)
    for x, colour in ((left + 63, LEFT), (left + 207, RIGHT)):
        drawing.line((x, 246), (x, 362), colour, 1.8, arrow=True)
        drawing.line((x + 14, 368), (x + 14, 252), colour, 1.2, "4 3", arrow=True)
    drawing.text((left + 84, 296), "attitude and thrust,", MUTED, 12)
    drawing.text((left + 84, 312), "pose, heartbeat", MUTED, 12)
    drawing.text((left + 84, 342), "state, answers", MUTED, 12)
    drawing.text((middle, 462), "MAVLink 2 on UDP, an address for each", MUTED, 12, "middle")


def svg():
    """The drawing."""
    drawing = Drawing()
    room(drawing)
    wires(drawing)
    colours = sorted({INK, LEFT, RIGHT, *AXES.values()})
    tips = "".join(
        f'<marker id="tip{c[1:]}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" '
        f'markerHeight="6" orient="auto-start-reverse"><path d="M0,0.6 L8,4 L0,7.4 z" fill="{c}"/>'
        "</marker>"
        for c in colours
    )
    body = "\n".join(drawing.parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        'aria-label="Two vehicles, a bar, a capture system and a ground station" '
        f'font-family="sans-serif"><defs>{tips}</defs>\n'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="{PAPER}"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    target = Path(__file__).with_name("_static") / "first-flight.svg"
    target.write_text(svg(), encoding="utf-8")
