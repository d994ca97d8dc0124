// Where the reader looks from: an orbit about a point, perspective, turned by mouse, touch and keys.
"use strict";

const Vec = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  scale: (s, a) => [s * a[0], s * a[1], s * a[2]],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  norm: (a) => Math.hypot(a[0], a[1], a[2]),
  mix: (a, b, s) => [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])],
  /** A body's vector in the world's axes; q is a unit quaternion, scalar first. */
  turn: ([w, x, y, z], a) => {
    const t = Vec.scale(2, Vec.cross([x, y, z], a));
    return Vec.add(Vec.add(a, Vec.scale(w, t)), Vec.cross([x, y, z], t));
  },
};

const Camera = (() => {
  const NEAR = 0.05; // m: nothing is drawn closer to the eye
  const TURN = 0.007; // rad per pixel
  const LEAST_PITCH = -0.1, MOST_PITCH = 1.5607; // rad: from just below the horizon to straight down
  const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

  return class Camera {
    /** box: [[x, y, z] least, greatest] of what is to be seen, m; changed: called after any motion. */
    constructor(canvas, box, changed) {
      this.canvas = canvas;
      this.box = box;
      this.changed = changed;
      this.look("corner");
      this.listen();
    }

    /** One of the views that buttons offer; all of the box is inside. */
    look(name) {
      const [yaw, pitch] = {
        corner: [-1.05, 0.32], side: [-Math.PI / 2, 0.04], end: [0, 0.04], top: [-Math.PI / 2, MOST_PITCH],
      }[name];
      Object.assign(this, { yaw, pitch, named: name });
      this.target = Vec.mix(this.box[0], this.box[1], 0.5);
      this.distance = 2 * Vec.norm(Vec.sub(this.box[1], this.box[0]));
      for (let k = 0; k < 6; ++k) this.fit();
      this.place();
    }

    /** Brings the box nearer to the middle of the picture, and to nearly all of its size. */
    fit() {
      this.place();
      if (!(this.width > 0 && this.height > 0)) return;
      const least = [Infinity, Infinity], most = [-Infinity, -Infinity];
      for (let k = 0; k < 8; ++k) {
        const corner = [0, 1, 2].map((axis) => this.box[(k >> axis) & 1][axis]);
        const place = this.project(corner);
        if (!place) {
          this.distance *= 2;
          return;
        }
        [0, 1].forEach((i) => {
          least[i] = Math.min(least[i], place[i]);
          most[i] = Math.max(most[i], place[i]);
        });
      }
      const k = this.distance / this.focal;
      const [dx, dy] = [(least[0] + most[0] - this.width) / 2, (least[1] + most[1] - this.height) / 2];
      this.target = Vec.add(this.target, Vec.add(Vec.scale(k * dx, this.right), Vec.scale(-k * dy, this.up)));
      this.distance *= Math.max((most[0] - least[0]) / (0.9 * this.width), (most[1] - least[1]) / (0.88 * this.height));
    }

    /** A direction's parts along right, up and towards away from the eye. */
    seen(a) {
      return [Vec.dot(a, this.right), Vec.dot(a, this.up), Vec.dot(a, this.ahead)];
    }

    /** Works out axes and eye after yaw, pitch, distance or target changed. */
    place() {
      const c = Math.cos(this.pitch), s = Math.sin(this.pitch);
      this.ahead = [-c * Math.cos(this.yaw), -c * Math.sin(this.yaw), -s];
      this.right = [-Math.sin(this.yaw), Math.cos(this.yaw), 0];
      this.up = Vec.cross(this.right, this.ahead);
      this.eye = Vec.sub(this.target, Vec.scale(this.distance ?? 1, this.ahead));
      this.width = this.canvas.clientWidth;
      this.height = this.canvas.clientHeight;
      this.focal = 1.05 * this.height; // px: a field of view of 51 degrees from top to bottom
    }

    /** [x px, y px, depth m] of a point; null behind the eye. */
    project(p) {
      const [x, y, z] = this.seen(Vec.sub(p, this.eye));
      if (!(z > NEAR)) return null;
      const k = this.focal / z;
      return [0.5 * this.width + k * x, 0.5 * this.height - k * y, z];
    }

    /** A line's two ends, cut where it passes the eye; null if all of it is behind. */
    projectLine(a, b) {
      const za = Vec.dot(Vec.sub(a, this.eye), this.ahead), zb = Vec.dot(Vec.sub(b, this.eye), this.ahead);
      const near = 2 * NEAR;
      if (za < near && zb < near) return null;
      if (za < near) a = Vec.mix(a, b, (near - za) / (zb - za));
      if (zb < near) b = Vec.mix(b, a, (near - zb) / (za - zb));
      return [this.project(a), this.project(b)];
    }

    orbit(dx, dy) {
      this.named = "";
      this.yaw -= TURN * dx;
      this.pitch = clamp(this.pitch + TURN * dy, LEAST_PITCH, MOST_PITCH);
      this.moved();
    }

    pan(dx, dy) {
      this.named = "";
      const k = this.distance / this.focal;
      this.target = Vec.add(this.target, Vec.add(Vec.scale(-k * dx, this.right), Vec.scale(k * dy, this.up)));
      this.moved();
    }

    zoom(factor) {
      this.named = "";
      this.distance = clamp(this.distance / factor, 0.2, 500);
      this.moved();
    }

    moved() {
      this.place();
      this.changed();
    }

    listen() {
      const pointers = new Map();
      const canvas = this.canvas;
      const spread = () => {
        const [a, b] = [...pointers.values()];
        return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) };
      };
      canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      });
      canvas.addEventListener("pointermove", (event) => {
        const before = pointers.get(event.pointerId);
        if (!before) return;
        const now = { x: event.clientX, y: event.clientY };
        if (pointers.size === 2) {
          const was = spread();
          pointers.set(event.pointerId, now);
          const is = spread();
          this.pan(is.x - was.x, is.y - was.y);
          if (was.apart > 10) this.zoom(is.apart / was.apart);
        } else if (pointers.size === 1) {
          pointers.set(event.pointerId, now);
          const panning = event.shiftKey || event.buttons & 6;
          this[panning ? "pan" : "orbit"](now.x - before.x, now.y - before.y);
        }
      });
      for (const name of ["pointerup", "pointercancel"]) {
        canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
      }
      canvas.addEventListener("contextmenu", (event) => event.preventDefault());
      canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-0.0012 * clamp(event.deltaY * (event.deltaMode ? 30 : 1), -300, 300)));
      }, { passive: false });
      canvas.addEventListener("dblclick", () => {
        this.look("corner");
        this.moved();
      });
    }
  };
})();
