// Small curves over time under the picture, with a cursor at the present time.
"use strict";

class Plot {
  /** spec: {title, unit, lines: [{name, colour, values}], band?, digits, zero}; seek: of the page. */
  constructor(spec, track, events, seek) {
    Object.assign(this, { spec, track, events });
    this.value = document.createElement("span");
    this.value.className = "value";
    const head = document.createElement("div");
    head.className = "plot-head";
    const title = document.createElement("b");
    title.textContent = `${spec.title} `;
    const unit = document.createElement("span");
    unit.className = "unit";
    unit.textContent = spec.unit;
    title.append(unit);
    head.append(title, this.value);
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${spec.title} in ${spec.unit} over time`);
    this.cursor = document.createElement("i");
    this.cursor.className = "cursor";
    const box = document.createElement("div");
    box.className = "plot-box";
    box.append(this.canvas, this.cursor);
    this.element = document.createElement("div");
    this.element.className = "plot";
    this.element.append(head, box);
    this.left = 38;
    const scrub = (event) => {
      const x = event.clientX - this.canvas.getBoundingClientRect().left;
      seek(((x - this.left) / (this.canvas.clientWidth - this.left - 6)) * track.end);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      scrub(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && scrub(event));
    this.range = this.findRange();
  }

  /** Of all but rare jerks, which leave the picture. */
  findRange() {
    const all = [];
    for (const { values } of this.spec.lines) for (const x of values) if (Number.isFinite(x)) all.push(x);
    if (!all.length) return [0, 1];
    all.sort((a, b) => a - b);
    const at = (part) => all[Math.round(part * (all.length - 1))];
    let [low, high] = [at(0.002), at(0.998)];
    if (all.at(-1) - all[0] < 2 * (high - low)) [low, high] = [all[0], all.at(-1)];
    if (this.spec.zero) low = 0;
    const span = Math.max(high - low, this.spec.least);
    return this.spec.zero ? [0, 1.08 * span] : [(low + high) / 2 - 0.56 * span, (low + high) / 2 + 0.56 * span];
  }

  x(time) {
    return this.left + (time / this.track.end) * (this.width - this.left - 6);
  }
  y(value) {
    const [low, high] = this.range;
    return this.height - 18 - ((value - low) / (high - low)) * (this.height - 24);
  }

  draw() {
    const ratio = window.devicePixelRatio || 1;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    const c = this.canvas.getContext("2d"), style = getComputedStyle(this.canvas);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.font = `11px ${Drawing.FONT}`;
    c.lineWidth = 1;
    const line = (x0, y0, x1, y1) => {
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x1, y1);
      c.stroke();
    };
    if (this.spec.band) {
      c.fillStyle = colour("band");
      c.fillRect(this.left, this.y(this.spec.band), this.width - this.left - 6, this.y(0) - this.y(this.spec.band));
    }
    c.strokeStyle = colour("line");
    c.fillStyle = colour("muted");
    c.textAlign = "right";
    c.textBaseline = "middle";
    const step = Plot.step(this.range[1] - this.range[0], 3);
    for (let v = Math.ceil(this.range[0] / step) * step; v <= this.range[1]; v += step) {
      line(this.left, this.y(v), this.width - 6, this.y(v));
      c.fillText(v.toFixed(Plot.decimals(step)).replace("-", "−"), this.left - 5, this.y(v));
    }
    c.textAlign = "center";
    c.textBaseline = "top";
    const tick = Plot.step(this.track.end, Math.max(2, this.width / 90));
    for (let t = 0; t <= this.track.end + 1e-9; t += tick) {
      const last = t + tick > this.track.end + 1e-9;
      c.fillText(t.toFixed(Plot.decimals(tick)) + (last ? " s" : ""), Math.min(this.x(t), this.width - 14), this.height - 13);
    }
    for (const event of this.events) {
      c.strokeStyle = colour(event.kind === "push" ? "muted" : "alarm");
      line(this.x(event.time), 4, this.x(event.time), this.height - 18);
    }
    c.save();
    c.beginPath();
    c.rect(this.left, 2, this.width - this.left, this.height - 19);
    c.clip();
    for (const { colour: ink, values } of this.spec.lines) {
      c.strokeStyle = ink || colour("ink");
      c.lineWidth = 1.5;
      c.beginPath();
      let gap = true;
      values.forEach((value, k) => {
        if (Number.isFinite(value)) c[gap ? "moveTo" : "lineTo"](this.x(this.track.t[k]), this.y(value));
        gap = !Number.isFinite(value);
      });
      c.stroke();
    }
    c.restore();
    this.move();
  }

  /** To the track's time. */
  move() {
    this.cursor.style.left = `${this.x(this.track.time)}px`;
    const { digits } = this.spec;
    const lines = this.spec.lines.length > 5 ? [this.greatest()] : this.spec.lines;
    this.value.replaceChildren(...lines.map(({ name, colour, values }) => {
      const now = values[this.track.k];
      const value = document.createElement("span"), key = document.createElement("b");
      if (colour) key.style.background = colour;
      key.textContent = name;
      value.append(...(name ? [key, " "] : []), Number.isFinite(now) ? now.toFixed(digits) : "–");
      return value;
    }));
  }

  /** Of many lines the one that is highest now. */
  greatest() {
    const now = ({ values }) => values[this.track.k] ?? NaN;
    return this.spec.lines.reduce((best, line) => (now(line) > now(best) || !(now(best) > -Infinity) ? line : best));
  }

  static step(span, wanted) {
    const power = 10 ** Math.floor(Math.log10(span / wanted));
    return [1, 2, 5, 10].map((m) => m * power).find((step) => span / step <= wanted + 1e-9) ?? 10 * power;
  }
  static decimals(step) {
    return Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  }
}
