// Inks as shares of cyan, magenta, yellow and black, and roughly how they look on a screen.

export type Cmyk = [number, number, number, number];

export const COMMON: [string, Cmyk][] = [
  ["Black", [0, 0, 0, 1]],
  ["Cyan", [1, 0, 0, 0]],
  ["Magenta", [0, 1, 0, 0]],
  ["Yellow", [0, 0, 1, 0]],
  ["Sepia", [0.3, 0.55, 0.75, 0.45]],
  ["Red chalk", [0.1, 0.8, 0.8, 0.1]],
  ["Blue ink", [1, 0.7, 0, 0.3]],
];
