// The page: one run, its time, and the controls.
"use strict";

class Replay {
  constructor(root) {
    this.root = root;
    this.scene = JSON.parse(document.getElementById("replay-data").textContent);
    this.track = new Track(this.scene.columns);
    this.scene.columns = null;
    this.playing = false;
    this.speed = 1;
    this.find = (name) => root.querySelector(`[data-${name}]`);
    const canvas = this.find("stage");
    this.camera = new Camera(canvas, this.scene.box, () => {
      this.showView();
      this.later();
    });
    this.camera.look(this.scene.view);
    this.picture = new Picture(canvas, this.scene, this.track, this.camera);
    this.makePlots();
    this.makeControls();
    this.makeLegend();
    new ResizeObserver(() => this.resize()).observe(root);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.resize());
    this.seek(Number(new URLSearchParams(location.hash.slice(1)).get("t")) || 0);
    this.resize();
  }

  makePlots() {
    const { track, scene } = this, all = track.columns;
    const perCable = (name, factor) => all.cables.map((cable, k) => ({
      name: String(k + 1), colour: scene.vehicles[k].colour, values: Array.from(cable[name], (x) => factor * x),
    }));
    const specs = [
      { title: "Swing", unit: "deg", lines: perCable("swing", 180 / Math.PI), band: 1, least: 1.5,
        digits: 1, zero: true },
      { title: "Tensions", unit: "N", lines: perCable("tension", 1), least: 1, digits: 1, zero: false },
      { title: "Payload off its target", unit: "m", lines: [{ name: "", values: Array.from(all.error) }],
        least: 0.05, digits: 3, zero: true },
    ];
    const seek = (time) => {
      this.pause();
      this.seek(time);
    };
    this.plots = specs.map((spec) => new Plot(spec, track, scene.events, seek));
    this.find("plots").append(...this.plots.map((plot) => plot.element));
  }

  makeControls() {
    this.find("play").addEventListener("click", () => this.toggle());
    this.slider = this.find("time");
    this.slider.max = this.track.end;
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.find("speed").addEventListener("change", (event) => (this.speed = Number(event.target.value)));
    for (const button of this.root.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => {
        this.camera.look(button.dataset.view);
        this.camera.moved();
      });
    }
    for (const box of this.root.querySelectorAll("[data-show]")) {
      box.addEventListener("change", () => {
        this.picture.show[box.dataset.show] = box.checked;
        this.later();
      });
    }
    for (const event of this.scene.events) {
      const mark = document.createElement("i");
      mark.className = event.kind;
      const part = event.time / this.track.end;
      mark.style.left = `calc(${100 * part}% + ${8 - 16 * part}px)`;
      this.find("track").append(mark);
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = `${event.text}, ${Number(event.time.toFixed(2))} s`;
      button.addEventListener("click", () => {
        this.seek(Math.max(0, event.time - 0.5));
        this.play();
      });
      this.find("events").append(button);
    }
    this.find("events").hidden = !this.scene.events.length;
    this.root.addEventListener("keydown", (event) => this.onKey(event));
    document.addEventListener("keydown", (event) => {
      if (event.target === document.body) this.onKey(event);
    });
  }

  makeLegend() {
    const { ramp, tension: [low, high] } = this.scene;
    this.find("ramp").style.background = `linear-gradient(to right, ${ramp})`;
    this.find("low").textContent = low.toFixed(1);
    this.find("high").textContent = high.toFixed(1);
  }

  showView() {
    for (const button of this.root.querySelectorAll("[data-view]")) {
      button.setAttribute("aria-pressed", String(button.dataset.view === this.camera.named));
    }
  }

  // Time.

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.track.time >= this.track.end) this.seek(0);
    this.playing = true;
    this.showState();
    let last;
    const tick = (now) => {
      if (!this.playing) return;
      const passed = last === undefined ? 0 : Math.min(0.1, (now - last) / 1000);
      last = now;
      this.seek(this.track.time + passed * this.speed);
      if (this.track.time >= this.track.end) this.pause();
      else this.frame = requestAnimationFrame(tick);
    };
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.showState();
  }

  seek(time) {
    this.track.seek(time);
    this.showState();
    this.later();
  }

  showState() {
    const { time, end } = this.track;
    const button = this.find("play");
    button.textContent = this.playing ? "❚❚" : "▶";
    button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.slider.value = time;
    this.slider.setAttribute("aria-valuetext", `${time.toFixed(2)} s`);
    this.find("clock").textContent = `${time.toFixed(2)} / ${end.toFixed(2)} s`;
  }

  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select")) return;
    const step = event.shiftKey ? 1 : 0.1, { camera, track } = this;
    const answers = {
      " ": () => this.toggle(), ArrowLeft: () => this.seek(track.time - step), ArrowRight: () => this.seek(track.time + step),
      Home: () => this.seek(0), End: () => this.seek(track.end), "+": () => camera.zoom(1.15), "-": () => camera.zoom(1 / 1.15),
      a: () => camera.orbit(30, 0), d: () => camera.orbit(-30, 0), w: () => camera.orbit(0, 30), s: () => camera.orbit(0, -30),
    };
    const answer = answers[event.key];
    if (!answer || (event.key === " " && event.target.matches("button, input[type=checkbox]"))) return;
    answer();
    event.preventDefault();
  }

  /** Draws once before the screen is next shown, however often it is called. */
  later() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    this.picture.draw();
    for (const plot of this.plots) plot.move();
  }

  resize() {
    this.picture.readColours();
    if (this.camera.named) this.camera.look(this.camera.named);
    this.showView();
    for (const plot of this.plots) plot.draw();
    this.draw();
  }
}

for (const root of document.querySelectorAll(".replay")) root.replay = new Replay(root);
