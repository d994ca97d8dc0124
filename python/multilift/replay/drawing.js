// Lines, faces, arrows and texts in space on a canvas; what hides each other is drawn far to near.
"use strict";

class Drawing {
  static FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", Arial, sans-serif';

  constructor(canvas, camera) {
    Object.assign(this, { canvas, camera });
    this.readColours();
  }

  /** From the style sheet, which knows light from dark. */
  readColours() {
    const style = getComputedStyle(this.canvas);
    this.colour = {};
    for (const name of ["ink", "muted", "line", "paper", "floor", "thrust", "alarm", "body"]) {
      this.colour[name] = style.getPropertyValue(`--${name}`).trim();
    }
  }

  /** Clears the canvas, which fills its element on any screen. */
  begin() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const c = (this.c = this.canvas.getContext("2d"));
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    c.lineJoin = "round";
    c.lineCap = "round";
    this.camera.place();
    this.items = []; // what hides each other: [depth, draw]
    this.labels = [];
  }

  /** Draws what waits for its turn. */
  finish() {
    this.items.sort((a, b) => b[0] - a[0]).forEach(([, draw]) => draw());
    this.labels.forEach((draw) => draw());
  }

  stroke(points, colour, width, dash = [], cap = "round") {
    const { c } = this;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.lineCap = cap;
    c.setLineDash(dash);
    c.beginPath();
    let last = null;
    for (let k = 1; k < points.length; ++k) {
      const line = this.camera.projectLine(points[k - 1], points[k]);
      if (!line) continue;
      if (k === 1 || last === null) c.moveTo(line[0][0], line[0][1]);
      c.lineTo(line[1][0], line[1][1]);
      last = line[1];
    }
    c.stroke();
    c.setLineDash([]);
  }

  fill(points, colour, edge, width = 1) {
    const corners = points.map((p) => this.camera.project(p));
    if (corners.some((p) => !p)) return;
    const { c } = this;
    c.beginPath();
    corners.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
    c.closePath();
    if (colour) {
      c.fillStyle = colour;
      c.fill();
    }
    if (edge) {
      c.strokeStyle = edge;
      c.lineWidth = width;
      c.stroke();
    }
  }

  /** Pixels that a length takes at a place. */
  pixels(length, place) {
    const p = this.camera.project(place);
    return p ? (length * this.camera.focal) / p[2] : 0;
  }

  later(place, draw) {
    const depth = Vec.dot(Vec.sub(place, this.camera.eye), this.camera.ahead);
    this.items.push([depth, draw]);
  }

  label(place, text, colour, dx = 0, dy = 0, size = 12) {
    this.labels.push(() => {
      const p = this.camera.project(place);
      if (!p) return;
      const { c } = this;
      c.font = `600 ${size}px ${Drawing.FONT}`;
      c.textAlign = dx > 0 ? "left" : "center";
      c.textBaseline = "middle";
      c.lineWidth = 3;
      c.strokeStyle = this.colour.paper;
      c.strokeText(text, p[0] + dx, p[1] + dy);
      c.fillStyle = colour;
      c.fillText(text, p[0] + dx, p[1] + dy);
    });
  }

  /** From a to b with a head at b; lengths of world, width of screen. */
  arrow(a, b, colour, width) {
    this.later(Vec.mix(a, b, 0.6), () => {
      const line = this.camera.projectLine(a, b);
      if (!line) return;
      const { c } = this;
      const [[x0, y0], [x1, y1]] = line;
      const length = Math.hypot(x1 - x0, y1 - y0);
      if (length < 2) return;
      const ux = (x1 - x0) / length, uy = (y1 - y0) / length, head = Math.min(length, 4 + 2.4 * width);
      c.strokeStyle = c.fillStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x1 - 0.8 * head * ux, y1 - 0.8 * head * uy);
      c.stroke();
      c.beginPath();
      c.moveTo(x1, y1);
      for (const side of [-0.45, 0.45]) c.lineTo(x1 - head * (ux + side * uy), y1 - head * (uy - side * ux));
      c.fill();
    });
  }
}
