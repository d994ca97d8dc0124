// Columns as packed.py packs them.
"use strict";

function unpack(packed) {
  if ("c" in packed) return new Float64Array(packed.n).fill(packed.c);
  if ("v" in packed) return Float64Array.from(packed.v, (x) => (x === null ? NaN : x));
  const unit = 10 ** packed.p;
  let sum = 0;
  return Float64Array.from(packed.d, (step) => (sum += step) / unit);
}
