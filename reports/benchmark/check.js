// Correct digits of a trajectory of the heavy top benchmark:  node check.js TOP.csv MINE.csv [AT_LEAST]
//
// TOP.csv is a file of the benchmark; MINE.csv has the columns t, p, q, r, gamma1, gamma2, gamma3 in any
// order, and q0, q1, q2, q3 where the attitude is to be judged.  Decimals are taken exactly, to 10^-70.
// Digits are -log10 of the larger of the error of omega, relative to the largest |omega| of TOP.csv, and
// the error of gamma; of the attitude -log10 of its error, of q or -q.  Errors are the largest of a
// component.  Exit code 0; 1 with fewer digits than AT_LEAST or a missing time; 2 for bad input.
"use strict";
const fs = require("fs");
const PLACES = 70;
const OMEGA = ["p", "q", "r"], GAMMA = ["gamma1", "gamma2", "gamma3"], ATTITUDE = ["q0", "q1", "q2", "q3"];

function number(text) { // a decimal as a whole number of 10^-70
  const found = /^\s*([+-]?)(\d*)\.?(\d*)(?:[eE]([+-]?\d+))?\s*$/.exec(text ?? "");
  if (!found || !(found[2] + found[3])) throw new Error(`expected a number, not ${text}`);
  const power = PLACES + Number(found[4] ?? 0) - found[3].length;
  if (power > 500) throw new Error(`${text} is too large`);
  let whole = BigInt(found[2] + found[3]);
  whole = power >= 0 ? whole * 10n ** BigInt(power) : power < -2000 ? 0n : whole / 10n ** BigInt(-power);
  return found[1] === "-" ? -whole : whole;
}

function read(path) { // rows by the names of their columns
  const lines = fs.readFileSync(path, "utf8").split(/\r?\n/).filter((line) => line.trim());
  const names = (lines[0] ?? "").split(",").map((name) => name.trim());
  for (const name of ["t", ...OMEGA, ...GAMMA])
    if (!names.includes(name)) throw new Error(`${path}: expected a column ${name}`);
  return lines.slice(1).map((line) => {
    const cells = line.split(",");
    return Object.fromEntries(names.map((name, k) => [name, number(cells[k])]));
  });
}

const size = (x) => (x < 0n ? -x : x);
const real = (x) => Number(x) / 10 ** PLACES;
const digits = (off) => (off ? Math.min(50, Math.max(0, -Math.log10(off))) : 50);

function error(mine, row, names, sign = 1n) { // the largest error of some columns
  return Math.max(...names.map((name) => real(size(sign * mine[name] - row[name]))));
}

function main(top, file, least) {
  const tops = read(top), rows = read(file);
  const scale = Math.max(...tops.map((row) => Math.hypot(...OMEGA.map((name) => real(row[name])))));
  let worst = 50;
  console.log("t  state  attitude");
  for (const row of tops) {
    const mine = rows.find((one) => size(one.t - row.t) * 1000000000n <= size(row.t));
    if (!mine && row.t === 0n) continue;
    const here = mine ? [digits(Math.max(error(mine, row, OMEGA) / scale, error(mine, row, GAMMA)))] : [0];
    if (mine && ATTITUDE.every((name) => name in mine))
      here.push(digits(Math.min(error(mine, row, ATTITUDE), error(mine, row, ATTITUDE, -1n))));
    console.log(`${Number(real(row.t).toPrecision(6))}  ${mine ? here.map((x) => x.toFixed(2)).join("  ") : "missing"}`);
    worst = Math.min(worst, ...here);
  }
  console.log(`worst ${worst.toFixed(2)} correct digits`);
  return least !== undefined && worst < Number(least) ? 1 : 0;
}

try {
  process.exitCode = main(...process.argv.slice(2));
} catch (fault) {
  console.error(`check.js TOP.csv MINE.csv [AT_LEAST]: ${fault.message}`);
  process.exitCode = 2;
}
