/** Colours of theme.css for what is drawn on a canvas, which knows no custom properties. */

const known = new Map<string, string>();
let probe: HTMLElement | null = null;

/** The colour that a custom property has under the present theme, as a canvas takes it. */
export function ink(name: string): string {
  const before = known.get(name);
  if (before !== undefined) return before;
  if (!probe) {
    probe = document.createElement("span");
    probe.hidden = true;
    document.body.append(probe);
  }
  probe.style.color = `var(${name}, gray)`;
  const colour = getComputedStyle(probe).color;
  known.set(name, colour);
  return colour;
}

/** After the theme has changed. */
export function forgetInks(): void {
  known.clear();
}
