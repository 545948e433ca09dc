/** A name: one of those that there are, or a new one. */
import { h, setHidden } from "../dom";

export class NameField {
  readonly element: HTMLElement;
  private readonly select = h("select");
  private readonly input: HTMLInputElement;
  private names: readonly string[] = [];

  /** `another`: the choice of a new name; `hint`: what is to be typed then. */
  constructor(
    label: string,
    private readonly another: string,
    hint: string,
    longest: number,
  ) {
    this.input = h("input", { type: "text", class: "field", maxlength: longest, placeholder: hint, "aria-label": hint, spellcheck: "false", autocomplete: "off", autocapitalize: "none", dir: "auto" });
    this.select.setAttribute("aria-label", label);
    // Before the form hears of it, who looks at `value` there.
    this.select.addEventListener("input", () => {
      this.draw();
      if (this.select.value === "") this.input.focus();
    });
    this.element = h("div", { class: "recorder-field" }, h("span", { class: "recorder-label", "aria-hidden": "true", text: label }), this.select, this.input);
    this.draw();
  }

  get value(): string {
    return this.select.value || this.input.value.trim();
  }

  /** `preferred` is chosen, or typed where it is none of the names. */
  setNames(names: readonly string[], preferred: string): void {
    if (names.length === this.names.length && names.every((name, i) => name === this.names[i]) && preferred === this.value) return;
    this.names = names;
    this.select.replaceChildren(...names.map((name) => h("option", { value: name, text: name })), h("option", { value: "", text: this.another }));
    const known = names.includes(preferred);
    this.select.value = known ? preferred : preferred === "" ? (names[0] ?? "") : "";
    if (!known) this.input.value = preferred;
    this.draw();
  }

  focus(): void {
    (this.input.hidden ? this.select : this.input).focus();
  }

  private draw(): void {
    setHidden(this.select, this.names.length === 0);
    setHidden(this.input, this.select.value !== "");
  }
}
