/** The keyboard: which key does what, for the listener and for the page that explains it. */

export interface Key {
  /** As in `KeyboardEvent.key`, lower case. */
  keys: readonly string[];
  /** As printed in the help. */
  shown: string;
  does: string;
  act(): void;
}

/**
 * Listens on the whole page. Keys with a modifier, and keys typed into a field, are left alone; the space bar and the arrows
 * also where a button, a tab or a slider has the focus, which has its own use for them.
 */
export function listenKeys(keys: readonly Key[]): void {
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented || event.repeat) return;
    const pressed = event.key.toLowerCase();
    if (document.querySelector("dialog[open]") && pressed !== "escape" && pressed !== "?") return;
    const target = event.target instanceof Element ? event.target : null;
    if (pressed !== "escape" && target?.closest("input, select, textarea, [contenteditable]")) {
      if (!(target instanceof HTMLInputElement && target.type === "range") || /^(arrow|home|end|page)/.test(pressed)) return;
    }
    if (pressed === " " && target?.closest("button, a, summary, [role=tab], [role=button]")) return;
    const key = keys.find((one) => one.keys.includes(pressed));
    if (!key) return;
    event.preventDefault();
    key.act();
  });
  // A button pressed by mouse or finger gives the focus back, or the next press of the space bar would press it again.
  window.addEventListener("click", (event) => {
    if (event.detail === 0 || !(event.target instanceof Element)) return;
    const button = event.target.closest("button");
    if (button && button === document.activeElement) button.blur();
  });
}
