// The animation: every run of a test side by side, drawn to the same scale from its own records.
"use strict";

const Player = (() => {
  const { data, column, endOf, make, swatch } = report;
  const INK = "#1c2126", MUTED = "#5b6570", GHOST = "#7d8790", GRID = "#e6eaed";
  const FONT = '"Liberation Sans", system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif';
  const RAMP = ["#e0a030", "#cf5a3c", "#8c2d69", "#2b1055"].map((hex) =>
    [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16)),
  ); // from low tension to high; lightness falls all the way
  const TRAIL = 3; // s of the strong part of the trail
  const AFTERGLOW = 0.6; // s for which a push that is over fades
  const SWING_BAND = 1; // degree, marked in the strips
  const DEGREE = 180 / Math.PI;

  const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

  /** A number with its sign, none for zero. */
  function signed(x, digits) {
    if (!Number.isFinite(x)) return "–";
    const size = Math.abs(x).toFixed(digits);
    return (Number(size) === 0 ? "" : x < 0 ? "−" : "+") + size;
  }

  /** 1, 2 or 5 times a power of ten, at least x. */
  function niceStep(x) {
    const power = 10 ** Math.floor(Math.log10(x));
    return [1, 2, 5, 10].map((m) => m * power).find((step) => step >= x * (1 - 1e-9));
  }

  /** 1, 2 or 5 times a power of ten, at most x. */
  function niceBelow(x) {
    const power = 10 ** Math.floor(Math.log10(x));
    return [5, 2, 1].map((m) => m * power).find((step) => step <= x * (1 + 1e-9));
  }

  function ticks(low, high, step) {
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(k * step);
    return found;
  }

  const decimals = (step) => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const tickText = (x, step) => x.toFixed(decimals(step)).replace("-", "−");

  function rampColor(x) {
    const at = clamp(x, 0, 1) * (RAMP.length - 1);
    const k = Math.min(RAMP.length - 2, Math.floor(at));
    const mix = RAMP[k].map((c, i) => Math.round(c + (RAMP[k + 1][i] - c) * (at - k)));
    return `rgb(${mix.join(" ")})`;
  }

  /** The last record at or before a time. */
  function recordBefore(t, time) {
    let low = 0, high = t.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (t[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** A run as a function of time: `at(time, name)` interpolates between records. */
  class Track {
    constructor(run) {
      this.run = run;
      this.t = column(run, "t");
      this.end = this.t.at(-1);
    }
    column(name) {
      return column(this.run, name);
    }
    seek(time) {
      this.k = recordBefore(this.t, time);
      const next = this.t[this.k + 1];
      this.part = next > this.t[this.k] ? clamp((time - this.t[this.k]) / (next - this.t[this.k]), 0, 1) : 0;
    }
    at(name) {
      const values = this.column(name);
      if (!values) return undefined;
      const now = values[this.k];
      return this.part > 0 ? now + this.part * (values[this.k + 1] - now) : now;
    }
  }

  /** Where everything is, m, for vehicle positions and cable angles. */
  function layout(geometry, [y1, z1, y2, z2], theta1, theta2) {
    const a = [y1 + geometry.l1 * Math.sin(theta1), z1 - geometry.l1 * Math.cos(theta1)];
    const b = [y2 - geometry.l2 * Math.sin(theta2), z2 - geometry.l2 * Math.cos(theta2)];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const down = [along[1], -along[0]]; // normal to the bar, downwards
    const center = [0, 1].map((i) => 0.5 * (a[i] + b[i]) + geometry.l3 * down[i]);
    return { vehicles: [[y1, z1], [y2, z2]], ends: [a, b], down, center };
  }

  /** The part of the world that all runs of a test stay in, [y low, y high, z low, z high], m. */
  function worldOf(test, tracks, half) {
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    const include = ([y, z]) => {
      if (!Number.isFinite(y) || !Number.isFinite(z)) return;
      box[0] = Math.min(box[0], y);
      box[1] = Math.max(box[1], y);
      box[2] = Math.min(box[2], z);
      box[3] = Math.max(box[3], z);
    };
    const includeAll = (scene) => [...scene.vehicles, ...scene.ends, scene.center].forEach(include);
    includeAll(layout(test.geometry, test.start, 0, 0));
    includeAll(layout(test.geometry, test.goal, 0, 0));
    const size = Math.max(box[1] - box[0], box[3] - box[2]);
    const limits = [box[0] - size, box[1] + size, box[2] - size, box[3] + size];
    for (const track of tracks) {
      const [y1, z1, y2, z2, theta1, theta2] =
        ["y1", "z1", "y2", "z2", "theta1", "theta2"].map((name) => track.column(name));
      for (let k = 0; k < track.t.length; k += 4) {
        includeAll(layout(test.geometry, [y1[k], z1[k], y2[k], z2[k]], theta1[k], theta2[k]));
      }
    }
    box[0] = Math.max(box[0], limits[0]) - 1.7 * half; // a run that diverged leaves the picture
    box[1] = Math.min(box[1], limits[1]) + 1.7 * half;
    box[2] = Math.max(box[2], limits[2]) - 0.35;
    box[3] = Math.min(box[3], limits[3]) + 3 * half;
    if (box[2] > 0 && box[2] < box[3] - box[2]) box[2] = -0.12; // the ground, where not far below
    return box;
  }

  function pushScale(push, time) {
    const t = time - push.start;
    if (t < 0 || t >= push.duration) return 0;
    if (push.shape === "half_sine") return Math.sin((Math.PI * t) / push.duration);
    if (push.shape === "sine") return Math.sin(2 * Math.PI * push.frequency * t);
    return 1;
  }

  /** Fits a canvas to its element and the screen's pixels; returns [context, width, height]. */
  function prepare(canvas) {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return [context, width, height];
  }

  function path(c, points) {
    c.beginPath();
    points.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
  }

  function arrow(c, [x0, y0], [x1, y1], width, color) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length < 2) return;
    const ux = (x1 - x0) / length, uy = (y1 - y0) / length;
    const head = Math.min(length, 4 + 2.2 * width), half = 0.42 * head;
    c.strokeStyle = c.fillStyle = color;
    c.lineWidth = width;
    c.lineCap = "butt";
    path(c, [[x0, y0], [x1 - 0.8 * head * ux, y1 - 0.8 * head * uy]]);
    c.stroke();
    path(c, [
      [x1, y1],
      [x1 - head * ux - half * uy, y1 - head * uy + half * ux],
      [x1 - head * ux + half * uy, y1 - head * uy - half * ux],
    ]);
    c.fill();
  }

  /** Text with a white rim, readable on whatever is behind it. */
  function label(c, text, x, y, color = INK) {
    c.lineWidth = 3.5;
    c.lineJoin = "round";
    c.strokeStyle = "rgb(255 255 255 / 85%)";
    c.strokeText(text, x, y);
    c.fillStyle = color;
    c.fillText(text, x, y);
  }

  /** A quadrotor from the side. a: half its width, px; spin: rotor angle. */
  function quadrotor(c, [x, y], tilt, a, spin, number) {
    c.save();
    c.translate(x, y);
    c.rotate(tilt);
    c.lineCap = "round";
    c.lineJoin = "round";
    c.strokeStyle = INK;
    c.lineWidth = Math.max(1, 0.045 * a);
    for (const side of [-1, 1]) {
      path(c, [[side * 0.2 * a, 0.1 * a], [side * 0.38 * a, 0.36 * a], [side * 0.5 * a, 0.36 * a]]);
      c.stroke(); // skid
    }
    c.lineWidth = Math.max(1.5, 0.08 * a);
    path(c, [[-a, -0.08 * a], [-0.3 * a, 0], [0.3 * a, 0], [a, -0.08 * a]]);
    c.stroke();
    for (const side of [-1, 1]) {
      c.fillStyle = INK;
      c.fillRect((side - 0.07) * a, -0.22 * a, 0.14 * a, 0.18 * a);
      c.fillStyle = "rgb(91 101 112 / 20%)";
      c.strokeStyle = "rgb(91 101 112 / 55%)";
      c.lineWidth = 0.8;
      c.beginPath();
      c.ellipse(side * a, -0.25 * a, 0.6 * a, 0.07 * a, 0, 0, 2 * Math.PI);
      c.fill();
      c.stroke();
      const reach = 0.58 * a * Math.cos(spin + side);
      c.strokeStyle = INK;
      c.lineWidth = Math.max(1, 0.05 * a);
      path(c, [[side * a - reach, -0.25 * a], [side * a + reach, -0.25 * a]]);
      c.stroke();
    }
    c.fillStyle = INK;
    c.beginPath();
    c.roundRect(-0.36 * a, -0.22 * a, 0.72 * a, 0.38 * a, [0.17 * a, 0.17 * a, 0.08 * a, 0.08 * a]);
    c.fill();
    if (a > 22) {
      c.fillStyle = "#fff";
      c.font = `600 ${Math.min(11, 0.3 * a)}px ${FONT}`;
      c.textAlign = "center";
      c.textBaseline = "middle";
      c.fillText(number, 0, -0.02 * a);
    }
    c.restore();
  }

  return class Player {
    constructor(root) {
      this.root = root;
      this.speed = 1;
      this.playing = false;
      root.player = this;
      root.tabIndex = 0;
      root.setAttribute("role", "group");
      root.addEventListener("keydown", (event) => this.onKey(event));
      if ("picker" in root.dataset && data.tests.length > 1) this.makePicker();
      this.body = make("div");
      root.append(this.body);
      this.load(Number(root.dataset.test));
      new ResizeObserver(() => this.resize()).observe(this.body);
      new IntersectionObserver(([entry]) => {
        if (!entry.isIntersecting) this.pause();
        else if ("autoplay" in root.dataset) {
          delete root.dataset.autoplay;
          if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
        }
      }, { threshold: 0.25 }).observe(root);
    }

    makePicker() {
      this.picker = make("div", { class: "picker", role: "group", "aria-label": "Test" });
      data.tests.forEach((test, k) => {
        const button = make("button", { type: "button" }, test.short);
        button.addEventListener("click", () => {
          const wasPlaying = this.playing;
          this.load(k);
          if (wasPlaying) this.play();
        });
        this.picker.append(button);
      });
      this.root.append(this.picker);
    }

    /** Shows a test from its start. */
    load(index) {
      this.pause();
      this.time = 0;
      this.test = data.tests[index];
      this.end = endOf(this.test);
      this.tracks = this.test.runs.map((run) => new Track(run));
      const { l0 } = this.test.geometry;
      this.half = clamp(0.13 * l0, 0.08, 0.3);
      this.world = worldOf(this.test, this.tracks, this.half);
      this.strongest = Math.max(...this.test.pushes.map((push) => Math.hypot(...push.force)), 0);
      let swing = 1.2 * SWING_BAND;
      for (const track of this.tracks) {
        for (const name of ["theta1", "theta2"]) {
          for (const x of track.column(name)) if (Math.abs(x) * DEGREE > swing) swing = Math.abs(x) * DEGREE;
        }
      }
      this.swing = Math.min(95, 1.1 * swing);
      if (this.picker) {
        [...this.picker.children].forEach((button, k) => button.setAttribute("aria-pressed", String(k === index)));
      }
      this.root.setAttribute("aria-label", `Animation: ${this.test.title}`);
      this.build();
      this.resize();
    }

    build() {
      const stage = make("div", { class: "stage" });
      this.panes = this.tracks.map((track) => {
        const scene = make("canvas", { class: "scene", role: "img",
          "aria-label": `${track.run.title}: vehicles, cables and bar from the side` });
        const strip = make("canvas", { class: "strip", role: "img",
          "aria-label": `${track.run.title}: cable angles over time` });
        const values = [make("b"), make("b")];
        const readout = make("span", { class: "readout" },
          make("span", {}, "θ₁"), values[0], make("span", {}, "θ₂"), values[1]);
        const head = make("div", { class: "pane-head" },
          make("strong", {}, swatch(data.styles[track.run.law]), track.run.title), readout);
        stage.append(make("div", { class: "pane" }, head, scene, strip));
        scene.addEventListener("pointerdown", () => this.root.focus({ preventScroll: true }));
        strip.addEventListener("pointerdown", (event) => this.scrubOn(strip, event));
        return { track, scene, strip, values };
      });
      this.button = make("button", { type: "button", class: "play" });
      this.button.addEventListener("click", () => this.toggle());
      this.slider = make("input", { type: "range", min: 0, max: this.end, step: "any", value: 0,
        "aria-label": "Time" });
      this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
      const track = make("div", { class: "track" }, this.slider);
      for (const push of this.test.pushes) {
        const mark = make("i");
        const part = push.start / this.end;
        mark.style.left = `calc(${100 * part}% + ${8 - 16 * part}px)`;
        track.append(mark);
      }
      this.clock = make("span", { class: "clock" });
      const speed = make("select", { "aria-label": "Speed" });
      for (const [value, text] of [[0.25, "¼×"], [0.5, "½×"], [1, "1×"], [2, "2×"], [4, "4×"]]) {
        const option = make("option", { value }, text);
        option.selected = value === this.speed;
        speed.append(option);
      }
      speed.addEventListener("change", () => (this.speed = Number(speed.value)));
      this.body.replaceChildren(stage,
        make("div", { class: "controls" }, this.button, track, this.clock, speed));
      if (this.test.pushes.length) this.body.append(this.pushButtons());
      this.body.append(this.legend());
      this.body.append(make("p", { class: "note keys" },
        "Once clicked: ", make("kbd", {}, "space"), " plays and pauses, ", make("kbd", {}, "←"), " ",
        make("kbd", {}, "→"), " move by 0.1 s, with ", make("kbd", {}, "shift"), " by 1 s."));
      this.showState();
    }

    pushButtons() {
      const list = make("div", { class: "pushes" }, "Go to the push at");
      for (const push of this.test.pushes) {
        const button = make("button", { type: "button" }, `${Number(push.start.toFixed(3))} s`);
        button.addEventListener("click", () => {
          this.seek(Math.max(0, push.start - 0.5));
          this.play();
        });
        list.append(button);
      }
      return list;
    }

    legend() {
      const list = make("ul", { class: "legend" });
      const [low, high] = this.test.tension;
      if (low !== undefined) {
        const ramp = make("span", { class: "ramp" });
        ramp.style.background = `linear-gradient(to right, ${[0, 1 / 3, 2 / 3, 1].map(rampColor)})`;
        list.append(make("li", {}, `cable tension ${low.toFixed(1)}`, ramp, `${high.toFixed(1)} N`));
      }
      if (this.test.thrust.length) {
        list.append(make("li", {}, `↑ thrust, at most ${this.test.thrust[1].toFixed(1)} N`));
      }
      list.append(
        make("li", {}, "dashed: goal"),
        make("li", {}, "wedge: angle of the cable from the vertical"),
        make("li", {}, `line of dots: path of the bar's centre`),
        make("li", {}, `lower graph: θ₁ strong, θ₂ thin; band ±${SWING_BAND}°`),
        make("li", {}, "positions, lengths and angles to scale, vehicles symbolic"),
      );
      return list;
    }

    // Time.

    play() {
      for (const other of document.querySelectorAll(".player")) {
        if (other !== this.root) other.player?.pause();
      }
      if (this.time >= this.end) this.time = 0;
      this.playing = true;
      this.last = undefined;
      this.showState();
      cancelAnimationFrame(this.frame);
      const tick = (now) => {
        if (!this.playing) return;
        const passed = this.last === undefined ? 0 : Math.min(0.1, (now - this.last) / 1000);
        this.last = now;
        this.time = Math.min(this.end, this.time + passed * this.speed);
        if (this.time >= this.end) this.pause();
        this.draw();
        this.frame = requestAnimationFrame(tick);
      };
      this.frame = requestAnimationFrame(tick);
    }

    pause() {
      if (!this.playing) return;
      this.playing = false;
      this.showState();
    }

    toggle() {
      if (this.playing) this.pause();
      else this.play();
    }

    seek(time) {
      this.time = clamp(time, 0, this.end);
      this.draw();
    }

    onKey(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const onSelect = event.target.matches("select");
      const step = event.shiftKey ? 1 : 0.1;
      if (event.key === " " && !event.target.matches("button, select")) this.toggle();
      else if (event.key === "ArrowLeft" && !onSelect) this.seek(this.time - step);
      else if (event.key === "ArrowRight" && !onSelect) this.seek(this.time + step);
      else if (event.key === "Home" && !onSelect) this.seek(0);
      else if (event.key === "End" && !onSelect) this.seek(this.end);
      else return;
      event.preventDefault();
    }

    scrubOn(strip, event) {
      const move = (e) => {
        const [left, right] = this.stripSpan(strip.clientWidth);
        const x = e.clientX - strip.getBoundingClientRect().left;
        this.seek(((x - left) / (right - left)) * this.end);
      };
      this.root.focus({ preventScroll: true });
      strip.setPointerCapture(event.pointerId);
      strip.addEventListener("pointermove", move);
      strip.addEventListener("lostpointercapture", () => strip.removeEventListener("pointermove", move),
        { once: true });
      move(event);
    }

    showState() {
      const icon = this.playing ? "M2 1h4v12H2zM8 1h4v12H8z" : "M2 1l11 6-11 6z";
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      svg.setAttribute("viewBox", "0 0 14 14");
      svg.setAttribute("width", "12");
      svg.setAttribute("height", "12");
      svg.setAttribute("aria-hidden", "true");
      const shape = document.createElementNS(svg.namespaceURI, "path");
      shape.setAttribute("d", icon);
      shape.setAttribute("fill", "currentColor");
      svg.append(shape);
      this.button.replaceChildren(svg, this.playing ? "Pause" : "Play");
    }

    // Drawing.

    resize() {
      const width = this.panes[0].scene.clientWidth;
      if (!width) return;
      const [y0, y1, z0, z1] = this.world;
      const height = clamp(((width - 34) * (z1 - z0)) / (y1 - y0) + 22, 150, Math.min(500, 0.62 * innerHeight));
      for (const { scene, strip } of this.panes) {
        scene.style.height = `${Math.round(height)}px`;
        strip.style.height = width < 300 ? "64px" : "92px";
      }
      this.draw();
    }

    draw() {
      for (const pane of this.panes) {
        pane.track.seek(this.time);
        this.drawScene(pane);
        this.drawStrip(pane);
        ["theta1", "theta2"].forEach((name, k) => {
          pane.values[k].textContent = `${signed(pane.track.at(name) * DEGREE, 2)}°`;
        });
      }
      this.slider.value = this.time;
      this.slider.setAttribute("aria-valuetext", `${this.time.toFixed(2)} seconds`);
      this.clock.textContent = `${this.time.toFixed(2)} / ${Number(this.end.toFixed(2))} s`;
      this.root.dispatchEvent(new CustomEvent("timechange", { detail: this.time }));
    }

    drawScene({ track, scene: canvas }) {
      const [c, width, height] = prepare(canvas);
      const [y0, y1, z0, z1] = this.world;
      const compact = width < 300;
      c.font = `${compact ? 10 : 11}px ${FONT}`;
      const left = Math.ceil(c.measureText(compact ? "2.5 m" : "−2.5 m").width) + 5, bottom = 20;
      const scale = Math.min((width - left - 4) / (y1 - y0), (height - bottom - 2) / (z1 - z0));
      const originX = left + 0.5 * (width - left - (y1 - y0) * scale) - y0 * scale;
      const originY = height - bottom - 0.5 * (height - bottom - (z1 - z0) * scale) + z0 * scale;
      const at = ([y, z]) => [originX + y * scale, originY - z * scale];

      this.drawGrid(c, { width, height, left, bottom, scale, originX, originY });

      const test = this.test;
      const goal = layout(test.geometry, test.goal, 0, 0);
      const now = layout(test.geometry, ["y1", "z1", "y2", "z2"].map((name) => track.at(name)),
        track.at("theta1"), track.at("theta2"));
      if (track.at("bar_y") !== undefined && track.at("bar_z") !== undefined) {
        now.center = [track.at("bar_y"), track.at("bar_z")];
      }
      const color = data.styles[track.run.law].color;

      c.save();
      c.beginPath();
      c.rect(left, 0, width - left, height - bottom);
      c.clip();
      this.drawGoal(c, at, scale, goal);
      this.drawTrail(c, at, track, color);
      now.vehicles.forEach((vehicle, k) => this.drawSwing(c, at, scale, vehicle, now.ends[k], k, color));
      now.vehicles.forEach((vehicle, k) => {
        const [low, high] = test.tension;
        const tension = track.at(`tension${k + 1}`);
        const part = tension === undefined || !(high > low) ? 0.5 : (tension - low) / (high - low);
        c.strokeStyle = tension === undefined ? MUTED : rampColor(part);
        c.lineWidth = (compact ? 1.6 : 2.2) + 1.4 * clamp(part, 0, 1);
        c.lineCap = "round";
        path(c, [at(vehicle), at(now.ends[k])]);
        c.stroke();
      });
      this.drawBar(c, at, scale, now);
      now.vehicles.forEach((vehicle, k) => this.drawVehicle(c, at, scale, vehicle, track, k));
      this.drawPushes(c, at, scale, now);
      c.restore();

      if (!track.run.finished && this.time >= track.end) {
        c.font = `600 12px ${FONT}`;
        c.textAlign = "left";
        c.textBaseline = "top";
        label(c, `Ended at ${Number(track.end.toFixed(2))} s`, left + 10, 10, "#8f2d00");
      }
    }

    drawGrid(c, { width, height, left, bottom, scale, originX, originY }) {
      const step = niceStep(Math.max((width < 300 ? 36 : 58) / scale, 0.1));
      c.fillStyle = MUTED;
      c.strokeStyle = GRID;
      c.lineWidth = 1;
      c.textAlign = "center";
      c.textBaseline = "alphabetic";
      const right = ticks((left - originX) / scale, (width - originX) / scale, step);
      right.forEach((y, k) => {
        const x = Math.round(originX + y * scale) + 0.5;
        path(c, [[x, 0], [x, height - bottom]]);
        c.stroke();
        const text = tickText(y, step);
        if (x < width - 12) c.fillText(k === right.length - 1 || x > width - 12 - step * scale ? `${text} m` : text, x, height - 6);
      });
      c.textAlign = "right";
      const up = ticks((originY - (height - bottom)) / scale, originY / scale, step);
      up.forEach((z, k) => {
        const y = Math.round(originY - z * scale) + 0.5;
        path(c, [[left, y], [width, y]]);
        c.stroke();
        if (y > 8) c.fillText(tickText(z, step) + (k === up.length - 1 ? " m" : ""), left - 4, y + 3.5);
      });
      const ground = originY;
      if (ground > height - bottom + 1) return;
      c.save();
      c.beginPath();
      c.rect(left, ground, width - left, Math.min(8, height - bottom - ground));
      c.clip();
      c.strokeStyle = "#b4bcc3";
      for (let x = left - 12; x < width; x += 7) {
        path(c, [[x, ground + 9], [x + 10, ground - 1]]);
        c.stroke();
      }
      c.restore();
      c.strokeStyle = MUTED;
      c.lineWidth = 1.4;
      path(c, [[left, ground], [width, ground]]);
      c.stroke();
    }

    drawGoal(c, at, scale, goal) {
      c.strokeStyle = GHOST;
      c.lineWidth = 1.2;
      c.setLineDash([4, 3.5]);
      const a = this.half * scale;
      goal.vehicles.forEach((vehicle, k) => {
        path(c, [at(vehicle), at(goal.ends[k])]);
        c.stroke();
        const [x, y] = at(vehicle);
        c.beginPath();
        c.roundRect(x - 1.6 * a, y - 0.36 * a, 3.2 * a, 0.74 * a, 0.1 * a);
        c.stroke();
      });
      path(c, this.barOutline(at, scale, goal));
      c.closePath();
      c.stroke();
      c.setLineDash([]);
    }

    /** Corners of the bar: from the line through the cables' ends to twice l3 below it. */
    barOutline(at, scale, scene) {
      const thickness = Math.max(2 * this.test.geometry.l3, 3.5 / scale);
      const below = (end) => [end[0] + thickness * scene.down[0], end[1] + thickness * scene.down[1]];
      const [a, b] = scene.ends;
      return [at(a), at(b), at(below(b)), at(below(a))];
    }

    drawTrail(c, at, track, color) {
      const y = track.column("bar_y"), z = track.column("bar_z");
      const center = (k) => {
        if (y && z) return at([y[k], z[k]]);
        const q = ["y1", "z1", "y2", "z2"].map((name) => track.column(name)[k]);
        return at(layout(this.test.geometry, q, track.column("theta1")[k], track.column("theta2")[k]).center);
      };
      const visible = (p) => Number.isFinite(p[0]) && Number.isFinite(p[1]);
      c.strokeStyle = color;
      c.lineCap = "round";
      c.lineJoin = "round";
      const stride = Math.max(1, Math.floor(track.k / 700));
      const far = [];
      for (let k = 0; k <= track.k; k += stride) far.push(center(k));
      c.globalAlpha = 0.3;
      c.lineWidth = 1;
      path(c, far.filter(visible));
      c.stroke();
      const first = recordBefore(track.t, Math.max(0, this.time - TRAIL));
      c.fillStyle = color;
      let last = [Infinity, Infinity];
      for (let k = track.k; k >= first; --k) {
        const p = center(k);
        if (!visible(p) || Math.hypot(p[0] - last[0], p[1] - last[1]) < 4) continue;
        last = p;
        c.globalAlpha = clamp(1 - (this.time - track.t[k]) / TRAIL, 0, 1) * 0.8;
        c.beginPath();
        c.arc(p[0], p[1], 1.6, 0, 2 * Math.PI);
        c.fill();
      }
      c.globalAlpha = 1;
    }

    /** The plumb line under a vehicle and the angle to its cable. */
    drawSwing(c, at, scale, vehicle, end, k, color) {
      const length = k ? this.test.geometry.l2 : this.test.geometry.l1;
      const [x, y] = at(vehicle), [ex, ey] = at(end);
      const angle = Math.atan2(ey - y, ex - x);
      c.fillStyle = color;
      c.globalAlpha = 0.2;
      c.beginPath();
      c.moveTo(x, y);
      c.arc(x, y, 0.92 * length * scale, Math.PI / 2, angle, angle < Math.PI / 2);
      c.closePath();
      c.fill();
      c.globalAlpha = 1;
      c.strokeStyle = MUTED;
      c.lineWidth = 1;
      c.setLineDash([1.5, 3]);
      path(c, [[x, y], [x, y + length * scale]]);
      c.stroke();
      c.setLineDash([]);
    }

    drawBar(c, at, scale, scene) {
      path(c, this.barOutline(at, scale, scene));
      c.closePath();
      c.fillStyle = "#a9b2ba";
      c.strokeStyle = INK;
      c.lineWidth = 1.2;
      c.lineJoin = "round";
      c.fill();
      c.stroke();
      c.fillStyle = INK;
      for (const end of scene.ends) {
        c.beginPath();
        c.arc(...at(end), 2.4, 0, 2 * Math.PI);
        c.fill();
      }
      c.fillStyle = "#fff";
      c.lineWidth = 1.4;
      c.beginPath();
      c.arc(...at(scene.center), 3.2, 0, 2 * Math.PI);
      c.fill();
      c.stroke();
    }

    drawVehicle(c, at, scale, vehicle, track, k) {
      const p = at(vehicle);
      const tilt = track.at(`attitude${k + 1}`) ?? 0;
      const a = this.half * scale;
      const thrust = track.at(`thrust${k + 1}`);
      if (thrust !== undefined && this.test.thrust[1] > 0) {
        const length = (thrust / this.test.thrust[1]) * 1.9 * a;
        const up = [Math.sin(tilt), -Math.cos(tilt)];
        const from = p.map((x, i) => x + 0.25 * a * up[i]);
        arrow(c, from, from.map((x, i) => x + length * up[i]), 1.8, MUTED);
      }
      quadrotor(c, p, tilt, a, 23 * this.time, String(k + 1));
    }

    drawPushes(c, at, scale, scene) {
      for (const push of this.test.pushes) {
        const after = this.time - push.start - push.duration;
        const factor = pushScale(push, this.time);
        const acts = factor !== 0;
        if (!acts && !(after >= 0 && after < AFTERGLOW)) continue;
        const size = Math.hypot(...push.force);
        if (!(size > 0)) continue;
        const length = ((acts ? factor : 1) * 62 * Math.min(1, scale / 90)) / this.strongest;
        const onBar = push.body === "bar";
        const from = at(onBar ? scene.center : scene.vehicles[push.body === "vehicle_2" ? 1 : 0]);
        from[1] += onBar ? 15 : 0;
        const to = [from[0] + length * push.force[0], from[1] - length * push.force[1]];
        c.globalAlpha = acts ? 1 : 0.55 * (1 - after / AFTERGLOW);
        arrow(c, from, to, 4.5, INK);
        c.font = `600 12px ${FONT}`;
        c.textAlign = "center";
        c.textBaseline = "top";
        if (acts) label(c, `push ${Math.abs(factor * size).toFixed(1)} N`, 0.5 * (from[0] + to[0]), from[1] + 9);
        c.globalAlpha = 1;
      }
    }

    stripSpan(width) {
      return [30, width - 10];
    }

    drawStrip({ track, strip: canvas }) {
      const [c, width, height] = prepare(canvas);
      const [left, right] = this.stripSpan(width);
      const top = 8, bottom = height - 17;
      const x = (t) => left + ((right - left) * t) / this.end;
      const y = (degrees) => 0.5 * (top + bottom) - (degrees / this.swing) * 0.5 * (bottom - top);
      const compact = width < 300;
      c.font = `${compact ? 10 : 11}px ${FONT}`;
      c.fillStyle = "#eef1f3";
      c.fillRect(left, y(SWING_BAND), right - left, y(-SWING_BAND) - y(SWING_BAND));
      const stepT = niceStep(this.end / (compact ? 3 : 6));
      c.strokeStyle = GRID;
      c.fillStyle = MUTED;
      c.lineWidth = 1;
      c.textAlign = "center";
      c.textBaseline = "alphabetic";
      for (const t of ticks(0, this.end, stepT)) {
        path(c, [[x(t), top], [x(t), bottom]]);
        c.stroke();
        if (x(t) < right - 4 || t === 0) c.fillText(t === 0 ? "0 s" : tickText(t, stepT), x(t), height - 4);
      }
      const stepA = compact ? niceBelow(0.95 * this.swing) : niceStep(this.swing / 2.3);
      c.textAlign = "right";
      const angles = ticks(-this.swing, this.swing, stepA);
      for (const angle of angles) {
        path(c, [[left, y(angle)], [right, y(angle)]]);
        c.stroke();
        if (!compact || angle === 0 || Math.abs(angle) === angles.at(-1)) c.fillText(`${tickText(angle, stepA)}°`, left - 4, y(angle) + 3.5);
      }
      for (const push of this.test.pushes) {
        c.fillStyle = "rgb(28 33 38 / 18%)";
        c.fillRect(x(push.start), top, Math.max(1.5, x(push.start + push.duration) - x(push.start)), bottom - top);
      }
      c.save();
      c.beginPath();
      c.rect(left, top - 2, right - left, bottom - top + 4);
      c.clip();
      c.strokeStyle = data.styles[track.run.law].color;
      c.lineJoin = "round";
      const stride = Math.max(1, Math.floor(track.t.length / (right - left) / 2));
      for (const [name, thick] of [["theta2", 0.9], ["theta1", 1.9]]) {
        const values = track.column(name);
        const draw = (from, to) => {
          c.beginPath();
          for (let k = from; k <= to; k += stride) c.lineTo(x(track.t[k]), y(values[k] * DEGREE));
          c.stroke();
        };
        c.lineWidth = thick;
        c.globalAlpha = 0.28;
        draw(0, track.t.length - 1);
        c.globalAlpha = 1;
        draw(0, track.k);
      }
      c.restore();
      c.strokeStyle = INK;
      c.lineWidth = 1.2;
      const now = x(Math.min(this.time, this.end));
      path(c, [[now, top - 4], [now, bottom]]);
      c.stroke();
    }
  };
})();

for (const root of document.querySelectorAll(".player")) report.whenNear(root, () => new Player(root));
