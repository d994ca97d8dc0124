// The recorded run as a function of time, and the shape of a cable that hangs loose.
"use strict";

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

/** Every packed column inside a tree of objects and lists, unpacked. */
function unpackAll(node) {
  if (Array.isArray(node)) return node.map(unpackAll);
  if (node === null || typeof node !== "object") return node;
  if ("n" in node || "d" in node || "v" in node) return unpack(node);
  return Object.fromEntries(Object.entries(node).map(([name, inner]) => [name, unpackAll(inner)]));
}

class Track {
  constructor(columns) {
    this.columns = unpackAll(columns);
    this.t = this.columns.t;
    this.end = this.t.at(-1);
    this.seek(this.t[0]);
  }
  /** Sets the time that the values below are for: straight between records. */
  seek(time) {
    this.time = Math.min(this.end, Math.max(this.t[0], time));
    this.k = recordBefore(this.t, this.time);
    const now = this.t[this.k], next = this.t[this.k + 1];
    this.part = next > now ? (this.time - now) / (next - now) : 0;
  }
  number(column) {
    const now = column[this.k];
    return this.part > 0 ? now + this.part * (column[this.k + 1] - now) : now;
  }
  /** Three columns as a place. */
  vector(columns) {
    return columns.map((column) => this.number(column));
  }
  /** Four columns as a unit quaternion. */
  attitude(columns) {
    const now = columns.map((column) => column[this.k]);
    let next = this.part > 0 ? columns.map((column) => column[this.k + 1]) : now;
    if (now.reduce((sum, x, i) => sum + x * next[i], 0) < 0) next = next.map((x) => -x);
    const mixed = now.map((x, i) => x + this.part * (next[i] - x));
    const size = Math.hypot(...mixed) || 1;
    return mixed.map((x) => x / size);
  }
  /** The path up to now, not before a time: places at about `most` records, then the present one. */
  path(columns, since, most) {
    const first = recordBefore(this.t, since);
    const stride = Math.max(1, Math.ceil((this.k - first) / most));
    const places = [];
    // From a whole stride on, so that the drawn records stay the same as time goes on.
    for (let k = Math.ceil(first / stride) * stride; k <= this.k; k += stride) {
      places.push(columns.map((column) => column[k]));
    }
    places.push(this.vector(columns));
    return places;
  }
}

const Cable = (() => {
  /** The u > 0 with sinh(u) / u = wanted > 1. */
  function ratio(wanted) {
    let u = wanted < 3 ? Math.sqrt(6 * (wanted - 1)) : Math.log(2 * wanted) + Math.log(Math.log(2 * wanted));
    u = Math.max(u, 1e-6);
    for (let k = 0; k < 20; ++k) {
      const step = (Math.sinh(u) - wanted * u) / (Math.cosh(u) - wanted);
      u = Math.max(u - step, 0.5 * u);
      if (Math.abs(step) < 1e-13 * u) break;
    }
    return u;
  }

  /** Points from foot to top along the catenary of a length; cables.py has the same in Python. */
  function sagging(foot, top, length, pieces = 16) {
    const apart = top.map((x, i) => x - foot[i]);
    const parts = Array.from({ length: pieces + 1 }, (_, k) => k / pieces);
    if (!(length > Math.hypot(...apart) * (1 + 1e-6))) {
      return parts.map((part) => foot.map((x, i) => x + part * apart[i]));
    }
    const flat = Math.hypot(apart[0], apart[1]);
    const across = Math.max(flat, 1e-3 * length);
    const heading = flat > 1e-9 ? [apart[0] / flat, apart[1] / flat] : [1, 0];
    const wanted = Math.sqrt(Math.max(length ** 2 - apart[2] ** 2, across ** 2)) / across;
    const a = across / (2 * ratio(wanted));
    const lowest = across / 2 - a * Math.asinh(apart[2] / (2 * a * Math.sinh(across / (2 * a))));
    const first = Math.sinh(-lowest / a), last = Math.sinh((across - lowest) / a);
    return parts.map((part) => {
      const x = lowest + a * Math.asinh(first + part * (last - first));
      const along = (x / across) * flat;
      return [
        foot[0] + along * heading[0], foot[1] + along * heading[1],
        foot[2] + a * (Math.cosh((x - lowest) / a) - Math.cosh(lowest / a)),
      ];
    });
  }

  /** A cable that is cut at the payload: down from its vehicle, and along the floor. */
  function hanging(top, length, floor) {
    const low = top[2] - length;
    if (floor === null || low >= floor) return [[top[0], top[1], low], top];
    const corner = [top[0], top[1], Math.min(floor, top[2])];
    return [[top[0] + length - (top[2] - corner[2]), top[1], corner[2]], corner, top];
  }

  return { sagging, hanging };
})();
