// One picture of the scene at the track's time.
"use strict";

const Picture = (() => {
  const TRAIL = 3; // s of the strong part of the trails
  const AFTERGLOW = 1.2; // s for which a push or an event stays named
  const DISC = Array.from({ length: 20 }, (_, k) => [Math.cos((k * Math.PI) / 10), Math.sin((k * Math.PI) / 10)]);

  return class Picture extends Drawing {
    constructor(canvas, scene, track, camera) {
      super(canvas, camera);
      Object.assign(this, { scene, track, show: { targets: true, trails: true, arrows: true } });
    }

    draw() {
      this.begin();
      this.pose();
      this.floor();
      if (this.show.trails) this.trails();
      if (this.show.targets) this.targets();
      this.payload(this.at.payload, this.at.attitude, false);
      this.scene.vehicles.forEach((vehicle, k) => this.vehicle(vehicle, k));
      this.scene.cables.forEach((cable, k) => this.cable(cable, k));
      this.pushes();
      this.finish();
      this.compass();
      this.captions();
    }

    /** Where everything is now. */
    pose() {
      const { track } = this, all = track.columns;
      this.at = {
        payload: track.vector(all.payload), attitude: track.attitude(all.attitude),
        target: track.vector(all.target), yaw: track.number(all.yaw),
        vehicles: all.vehicles.map((v) => ({
          place: track.vector(v.position), target: track.vector(v.target), thrust: track.vector(v.thrust),
          attitude: v.attitude ? track.attitude(v.attitude) : [1, 0, 0, 0],
        })),
        cables: all.cables.map((one) => ({
          foot: track.vector(one.foot),
          // A tension is not mixed with a slack neighbour's: the cable pulls or it does not.
          tension: one.tension[track.k] > this.scene.slack ? track.number(one.tension) : 0,
        })),
      };
    }

    // What is drawn.

    floor() {
      const { grid } = this.scene, z = grid.height;
      const [[x0, y0], [x1, y1]] = grid.corners;
      if (grid.solid) this.fill([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]], this.colour.floor);
      for (let x = x0; x <= x1 + 1e-6; x += grid.step) this.stroke([[x, y0, z], [x, y1, z]], this.colour.line, 1);
      for (let y = y0; y <= y1 + 1e-6; y += grid.step) this.stroke([[x0, y, z], [x1, y, z]], this.colour.line, 1);
      const shade = `color-mix(in srgb, ${this.colour.ink} 18%, transparent)`;
      const flat = (p) => [p[0], p[1], z];
      this.at.vehicles.forEach(({ place }, k) => {
        if (place[2] < z) return;
        const r = 1.6 * this.scene.vehicles[k].radius;
        this.fill(DISC.map(([a, b]) => [place[0] + r * a, place[1] + r * b, z]), shade);
      });
      const body = this.scene.payload;
      const points = body.points.map((p) => Vec.add(this.at.payload, Vec.turn(this.at.attitude, p)));
      if (body.kind === "plate") this.fill(points.map(flat), shade);
      else if (body.kind === "bar") this.stroke(points.map(flat), shade, Math.max(3, this.pixels(2 * body.radius, points[0])));
      else this.fill(DISC.map(([a, b]) => flat(Vec.add(points[0], [body.radius * a, body.radius * b, 0]))), shade);
    }

    trails() {
      const { track } = this, all = track.columns;
      const strong = track.time - TRAIL;
      all.vehicles.forEach((v, k) =>
        this.stroke(track.path(v.position, strong, 90), this.scene.vehicles[k].colour + "90", 1.3));
      this.stroke(track.path(all.payload, 0, 400), this.colour.muted, 1, [1.5, 4]);
      // The payload's ends show how it turned and swung.
      for (const { foot } of all.cables.length <= 8 ? all.cables : []) {
        this.stroke(track.path(foot, strong, 90), this.colour.muted + "a0", 1);
      }
      this.stroke(track.path(all.payload, strong, 120), this.colour.ink, 2);
    }

    targets() {
      const half = this.at.yaw / 2;
      this.payload(this.at.target, [Math.cos(half), 0, 0, Math.sin(half)], true);
      this.scene.vehicles.forEach((vehicle, k) => {
        const { target } = this.at.vehicles[k], r = 1.4 * vehicle.radius;
        const ring = [...DISC, DISC[0]].map(([a, b]) => [target[0] + r * a, target[1] + r * b, target[2]]);
        this.stroke(ring, vehicle.colour, 1.2, [3, 3]);
      });
    }

    payload(place, attitude, ghost) {
      const { kind, points, radius } = this.scene.payload;
      const world = (p) => Vec.add(place, Vec.turn(attitude, p));
      const { ink, body } = this.colour;
      if (kind === "bar") {
        const ends = points.map(world);
        if (ghost) return this.stroke(ends, this.colour.muted, 1.5, [5, 4]);
        for (let k = 0; k < 8; ++k) {
          const a = Vec.mix(...ends, k / 8), b = Vec.mix(...ends, (k + 1) / 8);
          const width = Math.max(5, this.pixels(2 * radius, a));
          this.later(Vec.mix(a, b, 0.5), () => {
            this.stroke([a, b], ink, width + 1.5, [], "butt");
            this.stroke([a, b], body, width - 1, [], "butt");
          });
        }
        return undefined;
      }
      if (kind === "point") {
        const p = this.camera.project(place);
        if (!p) return undefined;
        const ball = () => {
          const { c } = this;
          c.beginPath();
          c.arc(p[0], p[1], Math.max(4, this.pixels(radius, place)), 0, 2 * Math.PI);
          c.setLineDash(ghost ? [4, 3] : []);
          c.fillStyle = body;
          if (!ghost) c.fill();
          c.strokeStyle = ghost ? this.colour.muted : ink;
          c.lineWidth = 1.3;
          c.stroke();
          c.setLineDash([]);
        };
        return ghost ? ball() : this.later(place, ball);
      }
      const lift = (p, up) => world([p[0], p[1], p[2] + up * radius]);
      const top = points.map((p) => lift(p, 1)), bottom = points.map((p) => lift(p, -1));
      if (ghost) return this.stroke([...top, top[0]], this.colour.muted, 1.4, [5, 4]);
      const faces = [top, bottom];
      top.forEach((p, k) => {
        const next = (k + 1) % top.length;
        faces.push([p, top[next], bottom[next], bottom[k]]);
      });
      // Only faces towards the eye, as one item, so that the plate is never torn apart.
      this.later(place, () => {
        for (const face of faces) {
          let normal = Vec.cross(Vec.sub(face[1], face[0]), Vec.sub(face[2], face[1]));
          if (Vec.dot(normal, Vec.sub(face[0], place)) < 0) normal = Vec.scale(-1, normal);
          if (Vec.dot(normal, Vec.sub(this.camera.eye, face[0])) <= 0) continue;
          const light = 0.5 + (0.5 * Vec.dot(normal, [0.3, -0.4, 0.87])) / (Vec.norm(normal) || 1);
          this.fill(face, `color-mix(in srgb, ${body} ${Math.round(55 + 45 * light)}%, ${ink})`, ink, 1);
        }
      });
      return undefined;
    }

    vehicle(vehicle, k) {
      const { place, attitude, thrust } = this.at.vehicles[k];
      const world = (p) => Vec.add(place, Vec.turn(attitude, p));
      const lost = this.track.time >= vehicle.lost;
      const { ink, alarm } = this.colour;
      const r = vehicle.radius;
      for (const rotor of vehicle.rotors) {
        const hub = world(rotor);
        const lifted = Vec.add(rotor, [0, 0, 0.25 * r]);
        this.later(Vec.mix(place, hub, 0.5), () => this.stroke([place, hub], ink, Math.max(1.5, this.pixels(0.16 * r, hub))));
        this.later(world(lifted), () =>
          this.fill(DISC.map(([a, b]) => world(Vec.add(lifted, [r * a, r * b, 0]))),
            lost ? null : vehicle.colour + "38", lost ? alarm : vehicle.colour, 1.1));
      }
      const ball = vehicle.rotors.length ? 0.42 * r : r;
      this.later(place, () => {
        const p = this.camera.project(place);
        if (!p) return;
        const { c } = this;
        c.beginPath();
        c.arc(p[0], p[1], Math.max(3, this.pixels(ball, place)), 0, 2 * Math.PI);
        c.fillStyle = vehicle.colour;
        c.fill();
        c.strokeStyle = ink;
        c.lineWidth = 1;
        c.stroke();
      });
      if (vehicle.rotors.length) {
        const nose = Math.hypot(...vehicle.rotors[0]);
        const tip = world([0.75 * nose, 0, 0]);
        this.later(tip, () => this.stroke([place, tip], vehicle.colour, Math.max(1.5, this.pixels(0.12 * r, tip))));
      }
      if (this.show.arrows && !lost && Vec.norm(thrust) > 1e-9) {
        this.arrow(place, Vec.add(place, Vec.scale(this.scene.thrustScale, thrust)), this.colour.thrust, 2.2);
      }
      this.label(place, lost ? `${k + 1} lost` : String(k + 1), lost ? alarm : ink, 6 + this.pixels(0.5 * r, place), -8);
    }

    cable(cable, k) {
      const { foot, tension } = this.at.cables[k], top = this.at.vehicles[k].place;
      const { floor } = this.scene, keep = (p) => (floor === null ? p : [p[0], p[1], Math.max(p[2], floor)]);
      const cut = this.track.time >= cable.cut;
      const loose = cut || !(tension > this.scene.slack);
      const points = cut ? Cable.hanging(top, cable.length, floor)
        : loose ? Cable.sagging(foot, top, cable.length).map(keep) : Cable.sagging(foot, top, 0, 8);
      const colour = loose ? this.scene.slackColour : this.tensionColour(tension);
      for (let k = 1; k < points.length; ++k) {
        const piece = [points[k - 1], points[k]];
        this.later(Vec.mix(...piece, 0.5), () => {
          if (!loose) this.stroke(piece, this.colour.ink, 4.2, [], "butt");
          this.stroke(piece, colour, loose ? 1.8 : 3, cut ? [4, 4] : [], loose ? "round" : "butt");
        });
      }
    }

    tensionColour(tension) {
      const { ramp, tension: [low, high] } = this.scene;
      const part = Math.min(1, Math.max(0, (tension - low) / (high - low)));
      return ramp[Math.round(part * (ramp.length - 1))];
    }

    pushes() {
      for (const push of this.scene.pushes) {
        const since = this.track.time - push.start;
        if (since < 0 || since > push.duration + AFTERGLOW) continue;
        const force = this.track.vector(this.track.columns.pushes[push.index]);
        const place = push.body < 0 ? this.at.payload : this.at.vehicles[push.body].place;
        const size = Vec.norm(force);
        if (size > 0) {
          // Up to the body's surface, where a hand would push.
          const along = Vec.scale(1 / size, force);
          const reach = push.body < 0 ? Math.max(...this.scene.payload.points.map((p) =>
            -Vec.dot(Vec.turn(this.at.attitude, p), along)), this.scene.payload.radius) : 0;
          const tip = Vec.sub(place, Vec.scale(reach, along));
          this.arrow(Vec.sub(tip, Vec.scale(this.scene.pushScale, force)), tip, this.colour.alarm, 3.5);
        }
        this.label(place, size > 0 ? `push ${size.toFixed(1)} N` : "push over", this.colour.alarm, 0, 22);
      }
    }

    /** The world's axes, bottom left. */
    compass() {
      const { c } = this, x0 = 44, y0 = this.camera.height - 44, size = 28;
      c.font = `600 12px ${Drawing.FONT}`;
      c.textAlign = "center";
      c.textBaseline = "middle";
      [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
        const [x, y] = this.camera.seen(axis);
        c.strokeStyle = c.fillStyle = this.colour.muted;
        c.lineWidth = 1.6;
        c.beginPath();
        c.moveTo(x0, y0);
        c.lineTo(x0 + size * x, y0 - size * y);
        c.stroke();
        if (Math.hypot(x, y) > 0.25) c.fillText(name, x0 + (size + 9) * x, y0 - (size + 9) * y);
      });
    }

    /** What just happened, top left. */
    captions() {
      const { c } = this;
      const recent = this.scene.events.filter((e) => e.kind !== "push" && this.track.time >= e.time);
      c.font = `600 14px ${Drawing.FONT}`;
      c.textAlign = "left";
      c.textBaseline = "top";
      recent.forEach((event, k) => {
        const fresh = this.track.time - event.time < 2;
        c.fillStyle = fresh ? this.colour.alarm : this.colour.muted;
        c.fillText(`${event.text} at ${event.time.toFixed(2)} s`, 14, 12 + 20 * k);
      });
    }
  };
})();
