// How much of each pixel a shape covers, exactly for straight-sided ones: signed areas right of each edge, summed along the rows.

import type { Ring } from "./outline";

// Where a shape goes: x' = x + cos * u - sin * v, y' = y + sin * u + cos * v, px.
export interface Pose {
  x: number;
  y: number;
  cos: number; // times the scale
  sin: number;
}

export class Coverage {
  width = 0;
  height = 0;
  left = 0;
  top = 0;
  private sums = new Float32Array(4096);

  // Begins anew over a window of whole px; all that is added is cut to it.
  over(left: number, top: number, width: number, height: number): void {
    this.left = left;
    this.top = top;
    this.width = width;
    this.height = height;
    const size = (width + 2) * height;
    if (size > this.sums.length) this.sums = new Float32Array(2 * size);
    else this.sums.fill(0, 0, size);
  }

  fill(rings: Ring[], pose: Pose): void {
    const ox = pose.x - this.left;
    const oy = pose.y - this.top;
    for (const { xy } of rings) {
      const n = xy.length;
      let px = ox + pose.cos * xy[n - 2]! - pose.sin * xy[n - 1]!;
      let py = oy + pose.sin * xy[n - 2]! + pose.cos * xy[n - 1]!;
      for (let i = 0; i < n; i += 2) {
        const qx = ox + pose.cos * xy[i]! - pose.sin * xy[i + 1]!;
        const qy = oy + pose.sin * xy[i]! + pose.cos * xy[i + 1]!;
        this.edge(px, py, qx, qy);
        px = qx;
        py = qy;
      }
    }
  }

  // The lines of a pen of a width in px along the rings, with round ends.
  stroke(rings: Ring[], pose: Pose, width: number): void {
    const r = Math.max(width, 0.05) / 2;
    const at = (xy: Float64Array, i: number): [number, number] => [
      pose.x - this.left + pose.cos * xy[i]! - pose.sin * xy[i + 1]!,
      pose.y - this.top + pose.sin * xy[i]! + pose.cos * xy[i + 1]!,
    ];
    for (const { xy, closed } of rings) {
      const n = xy.length;
      for (let i = closed ? 0 : 2; i < n; i += 2) {
        const [px, py] = at(xy, (i + n - 2) % n);
        const [qx, qy] = at(xy, i);
        this.capsule(px, py, qx, qy, r);
      }
      if (n === 2) this.capsule(...at(xy, 0), ...at(xy, 0), r);
    }
  }

  private capsule(px: number, py: number, qx: number, qy: number, r: number): void {
    const steps = r < 0.6 ? 1 : r < 2 ? 4 : 8; // of each round end; a pen under a pixel needs none
    const along = Math.atan2(qy - py, qx - px);
    const corners: number[] = [];
    for (const [cx, cy, from] of [[qx, qy, along - Math.PI / 2], [px, py, along + Math.PI / 2]] as const) {
      for (let k = 0; k <= steps; k++) {
        const angle = from + (Math.PI * k) / steps;
        corners.push(cx + r * Math.cos(angle), cy + r * Math.sin(angle));
      }
    }
    for (let i = 0, j = corners.length - 2; i < corners.length; j = i, i += 2) this.edge(corners[j]!, corners[j + 1]!, corners[i]!, corners[i + 1]!);
  }

  // One edge, from p to q in px of the window.
  private edge(px: number, py: number, qx: number, qy: number): void {
    if (py === qy) return;
    let sign = 1;
    if (py > qy) {
      [px, py, qx, qy] = [qx, qy, px, py];
      sign = -1;
    }
    if (qy <= 0 || py >= this.height) return;
    const slope = (qx - px) / (qy - py);
    if (py < 0) {
      px -= py * slope;
      py = 0;
    }
    if (qy > this.height) {
      qx -= (qy - this.height) * slope;
      qy = this.height;
    }
    const w = this.width;
    // what lies left of the window covers all of a row, what lies right of it nothing: parts beyond are laid upright on its sides
    const cut = (side: number): boolean => (px - side) * (qx - side) < 0;
    if (cut(0)) return this.twice(px, py, qx, qy, 0, slope, sign);
    if (cut(w)) return this.twice(px, py, qx, qy, w, slope, sign);
    if (px >= w && qx >= w) return;
    if (px <= 0 && qx <= 0) this.rows(0, py, qy, 0, sign);
    else this.rows(px, py, qy, slope, sign);
  }

  private twice(px: number, py: number, qx: number, qy: number, side: number, slope: number, sign: number): void {
    const y = py + (side - px) / slope;
    if (sign > 0) {
      this.edge(px, py, side, y);
      this.edge(side, y, qx, qy);
    } else {
      this.edge(qx, qy, side, y);
      this.edge(side, y, px, py);
    }
  }

  private rows(px: number, py: number, qy: number, slope: number, sign: number): void {
    const stride = this.width + 2;
    const sums = this.sums;
    let x = px;
    for (let row = Math.floor(py); row < qy; row++) {
      const high = Math.max(py, row);
      const low = Math.min(qy, row + 1);
      const dy = low - high;
      if (dy <= 0) continue;
      const to = x + slope * dy;
      const d = sign * dy;
      const [x0, x1] = x < to ? [x, to] : [to, x];
      const first = Math.floor(x0);
      const last = Math.ceil(x1);
      const base = row * stride + first;
      if (last <= first + 1) {
        const mid = (x0 + x1) / 2 - first; // the mean of how far into the pixel the edge lies
        sums[base]! += d * (1 - mid);
        sums[base + 1]! += d * mid;
      } else {
        const per = 1 / (x1 - x0);
        const a = 1 - (x0 - first);
        const first0 = 0.5 * per * a * a;
        const b = x1 - last + 1;
        const end = 0.5 * per * b * b;
        sums[base]! += d * first0;
        if (last === first + 2) sums[base + 1]! += d * (1 - first0 - end);
        else {
          const second = per * (1.5 - (x0 - first));
          sums[base + 1]! += d * (second - first0);
          for (let k = first + 2; k < last - 1; k++) sums[row * stride + k]! += d * per;
          const before = second + (last - first - 3) * per;
          sums[row * stride + last - 1]! += d * (1 - before - end);
        }
        sums[row * stride + last]! += d * end;
      }
      x = to;
    }
  }

  // The window's pixels, 0 to 255, row by row; in `into` where that is long enough.
  bytes(into?: Uint8Array<ArrayBuffer>): Uint8Array<ArrayBuffer> {
    const size = this.width * this.height;
    const values = into && into.length >= size ? into : new Uint8Array(size);
    let k = 0;
    for (let row = 0; row < this.height; row++) {
      let sum = 0;
      const base = row * (this.width + 2);
      for (let column = 0; column < this.width; column++) {
        sum += this.sums[base + column]!;
        values[k++] = (Math.min(1, Math.abs(sum)) * 255 + 0.5) | 0;
      }
    }
    return values;
  }
}
