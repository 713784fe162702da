// Temperature of the displayed curves and field. It is not a setting of the machine.

type Listener = (temperature_c: number) => void;

class Display {
  private listeners = new Set<Listener>();
  /** Temperature of all axes, °C; undefined: the machine's reference. */
  temperature_c: number | undefined;

  set(temperature_c: number | undefined): void {
    this.temperature_c = temperature_c;
    for (const listener of this.listeners) listener(temperature_c ?? Number.NaN);
  }

  subscribe(listener: Listener): void {
    this.listeners.add(listener);
  }
}

export const display = new Display();
