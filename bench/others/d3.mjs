// Weighted Voronoi stippling with d3-delaunay's find(): every pixel goes to its nearest site, sites go to their pixels' centroids.
//
// node d3.mjs D3-FOLDER FIGURES.json DARKNESS.f64 WIDTH DOTS PASSES STEP JITTER OUT.f64
// STEP times the way to the centroid each pass, and JITTER pixels at random at first, falling as pass^-0.8.

import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, figures, picture, ...rest] = process.argv.slice(2);
const [width, dots, passes, step, jitter] = rest.slice(0, 5).map(Number);
const { Delaunay } = await import(pathToFileURL(`${folder}/node_modules/d3-delaunay/src/index.js`));
const bytes = readFileSync(picture);
const dark = new Float64Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 8);
const height = dark.length / width;
const began = process.hrtime.bigint(), spent = process.cpuUsage();

let state = 1; // of a small generator, so that runs are alike (Numerical Recipes' constants)
const chance = () => (state = (Math.imul(1664525, state) + 1013904223) >>> 0) / 2 ** 32;

const sites = new Float64Array(2 * dots);
for (let i = 0; i < dots; ) {
  const x = width * chance(), y = height * chance();
  if (chance() < dark[Math.floor(y) * width + Math.floor(x)]) {
    sites[2 * i] = x;
    sites[2 * i++ + 1] = y;
  }
}
const delaunay = new Delaunay(sites);
for (let pass = 0; pass < passes; pass++) {
  const mass = new Float64Array(dots), sums = new Float64Array(2 * dots);
  for (let row = 0, at = 0, near = 0; row < height; row++) {
    for (let column = 0; column < width; column++, at++) {
      near = delaunay.find(column + 0.5, row + 0.5, near);
      mass[near] += dark[at];
      sums[2 * near] += dark[at] * (column + 0.5);
      sums[2 * near + 1] += dark[at] * (row + 0.5);
    }
  }
  const shake = jitter * (pass + 1) ** -0.8;
  for (let i = 0; i < dots; i++) {
    for (let axis = 0, k = 2 * i; axis < 2; axis++, k++) {
      const middle = mass[i] > 0 ? sums[k] / mass[i] : sites[k];
      const place = sites[k] + step * (middle - sites[k]) + shake * (chance() - 0.5);
      sites[k] = Math.min(Math.max(place, 0), axis ? height : width);
    }
  }
  delaunay.update();
}
const used = process.cpuUsage(spent);
const seconds = Number(process.hrtime.bigint() - began) / 1e9;
writeFileSync(rest[5], new Uint8Array(sites.buffer));
writeFileSync(figures, JSON.stringify({ seconds, cpu: (used.user + used.system) / 1e6 }));
