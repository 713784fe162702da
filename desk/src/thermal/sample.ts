// A warm-up made by a formula: four cycles of a growing spindle head and an X axis, read by three sensors.

/** Time between two readings, s, and readings of a cycle. */
const STEP_S = 300;
const READINGS = 40;
const CYCLES = 4;

/**
 * The record: X works for three quarters of every cycle and warms its scale, T1, with a time constant of 90 min; the spindle turns in
 * every other hour and warms its head, T2, with one of 20 min. X grows by 12 µm/(m K) from position 0, Z by 3 µm/K; T3, the room, has no effect. Noise ±0.1 µm, the same in every record.
 */
export function warmUp(): string {
  const lines = ["t_s,cycle,x_mm,ex_um,ez_um,T1_c,T2_c,T3_c"];
  let state = 5;
  const noise = () => ((state = (state * 48271) % 2147483647) / 2147483647 - 0.5) * 0.2;
  let [scale, head] = [0, 0];
  for (let i = 0; i < CYCLES * READINGS; i++) {
    const cycle = Math.floor(i / READINGS);
    const toward = (level: number, now: number, constant_s: number) => (level - now) * (1 - Math.exp(-STEP_S / constant_s));
    scale += toward(i % READINGS < 0.75 * READINGS ? 5 + 2 * Math.cos(2.1 * cycle) : 0, scale, 5400);
    head += toward(Math.floor((i * STEP_S) / 3600) % 2 === 0 ? 6 + Math.sin(1.7 * cycle) : 0, head, 1200);
    const room = 0.5 * Math.sin((i * STEP_S) / 13_000);
    for (const x of [0, 250]) {
      const [ex, ez] = [0.012 * scale * x + noise(), 3 * head + noise()];
      lines.push([i * STEP_S, cycle, x, ex.toFixed(3), ez.toFixed(3), (20 + scale).toFixed(3), (20 + head).toFixed(3), (20 + room).toFixed(3)].join(","));
    }
  }
  return `${lines.join("\n")}\n`;
}
