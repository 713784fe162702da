"use strict";
// The same formulas as in the library, so that the page can be checked against the values that came with it.

const RAD = Math.PI / 180;

/** Base radius and lead parameter of a gear, after ISO 21771. */
function gearData(gear) {
  const beta = gear.helix_angle_deg * RAD;
  const transverseModule = gear.module_mm / Math.cos(beta);
  const tanAlphaT = Math.tan(gear.pressure_angle_deg * RAD) / Math.cos(beta);
  const r = transverseModule * gear.teeth / 2;
  return {
    transverseModule, r, alphaT: Math.atan(tanAlphaT), roll: tanAlphaT,
    rb: r / Math.hypot(1, tanAlphaT), p: r / Math.tan(beta),
    betaB: Math.atan(Math.tan(beta) / Math.hypot(1, tanAlphaT)),
  };
}

/** Surface point F(u, θ), gear's frame. */
function surfacePoint({ rb, p }, u, theta) {
  const sin = Math.sin(u + theta), cos = Math.cos(u + theta);
  return [rb * (cos + u * sin), rb * (sin - u * cos), p * theta];
}

/** Unit normal n(u, θ), gear's frame. */
function surfaceNormal({ rb, p }, u, theta) {
  const length = Math.hypot(p, rb);
  return [p * Math.sin(u + theta) / length, -p * Math.cos(u + theta) / length, rb / length];
}

function aboutZ(angle, [x, y, z]) {
  const sin = Math.sin(angle), cos = Math.cos(angle);
  return [cos * x - sin * y, sin * x + cos * y, z];
}

/** Angles of head (from the vertical pose) and table, rad, without the senses of the axes. */
function stand({ rb, p, branch }, u, theta) {
  const tilt = Math.atan2(p, rb), phi = u + theta;
  return branch === 1 ? { head: tilt, table: -phi } : { head: -tilt, table: Math.PI - phi };
}

/** [X, Y, Z, A, C], mm and degrees. */
function place(setup, u, theta) {
  const { head, table } = stand(setup, u, theta);
  const vertical = setup.form === "vertical";
  const f = surfacePoint(setup, u, theta);
  const [x, y, z] = aboutZ(table, f.map((value, i) => value + setup.w[i]));
  const l = setup.pivot;
  return [
    x,
    y + l * (-Math.sin(head) - (vertical ? 0 : 1)),
    z + l * (Math.cos(head) - (vertical ? 1 : 0)),
    setup.directionA * ((vertical ? 0 : 90) + head / RAD),
    setup.directionC * (table / RAD),
  ];
}

/** What does not go together, or null. */
function refusal(setup) {
  if (setup.gear) {
    const { module_mm: m, teeth, pressure_angle_deg: alpha, helix_angle_deg: beta } = setup.gear;
    if (!(m > 0)) return "The module must be above 0 mm.";
    if (!(Number.isInteger(teeth) && teeth >= 1 && teeth <= 10000)) return "Teeth: a whole number, 1 to 10000.";
    if (!(alpha > 0 && alpha < 90)) return "The pressure angle must be between 0° and 90°.";
    if (!(beta !== 0 && Math.abs(beta) < 90)) return "The helix angle must be between −90° and 90° and not 0: a spur gear's flank has no lead.";
  }
  const numbers = [setup.rb, setup.p, setup.pivot, ...setup.w, ...setup.u, ...setup.theta];
  if (!numbers.every(Number.isFinite)) return "A field is empty or not a number.";
  if (!(setup.rb > 0 && setup.rb <= 1e6)) return "The base radius must be above 0 mm.";
  if (!(setup.p !== 0 && Math.abs(setup.p) <= 1e6)) return "The lead parameter must not be 0 mm/rad.";
  if (!(setup.pivot >= 0 && setup.pivot <= 1e6)) return "The pivot length must not be negative.";
  const sign = setup.flank === "right" ? 1 : -1;
  if (setup.p * sign < 0) return `The ${setup.flank} flank of this helix faces away from the tool: take the other flank, or the other hand.`;
  if (setup.u.some(u => u * sign < 0)) return `u must be ${sign > 0 ? "positive" : "negative"} on the ${setup.flank} flank.`;
  return null;
}

/** Values from start to stop, both included. */
function between([start, stop], count) {
  return Array.from({ length: count }, (_, i) => count === 1 ? start : start + (stop - start) * i / (count - 1));
}

/** Largest differences from the values that came with the page: [mm, degrees]; whole turns of C count nothing. */
function largestDifference(setup, points) {
  const largest = [0, 0];
  for (const point of points) {
    const mine = place(setup, point[0], point[1]);
    mine.forEach((value, i) => {
      let gap = value - point[2 + i];
      if (i === 4) gap -= 360 * Math.round(gap / 360);
      largest[i < 3 ? 0 : 1] = Math.max(largest[i < 3 ? 0 : 1], Math.abs(gap));
    });
  }
  return largest;
}
