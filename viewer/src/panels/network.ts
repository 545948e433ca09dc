/** Who can send to the session: where it listens, narrowed by a choice; and the key that admits paired boards alone. */
import type { Actions } from "../actions";
import { h, setHidden, setText } from "../dom";
import type { NetworkStatus, Pairing } from "../network_protocol";

export class NetworkSection {
  readonly element = h("section", { class: "network", hidden: true });
  private readonly reach = h("p");
  private readonly only = h("select", { "aria-label": "Listen on" });
  private readonly choice = h("label", { class: "network-choice" }, h("span", { text: "Listen on" }), this.only);
  private readonly pair = h("button", { type: "button", class: "button", text: "Pair" });
  private readonly pairing: PairingCard;

  constructor(private readonly actions: Actions) {
    this.pairing = new PairingCard();
    this.only.addEventListener("change", () => void actions.listenOnly(this.only.value));
    this.pair.addEventListener("click", () => void this.showPairing());
    this.element.append(h("h3", { text: "Who can send" }), this.reach, h("div", { class: "button-row" }, this.choice, this.pair), this.pairing.element);
  }

  /** `listening`: the addresses that the session opened. */
  update(network: NetworkStatus | null, listening: readonly string[]): void {
    setHidden(this.element, network === null);
    if (!network) return;
    setText(this.reach, reachText(network, listening));
    setHidden(this.choice, network.open.length === 0);
    this.fill(network);
  }

  private fill(network: NetworkStatus): void {
    const choices = entrances(network);
    const key = [network.only, ...choices.map(([name, label]) => `${name} ${label}`)].join("\n");
    // Nothing changes under the hand of who is choosing.
    if (this.only.dataset["key"] === key || document.activeElement === this.only && this.only.value !== network.only) return;
    this.only.dataset["key"] = key;
    this.only.replaceChildren(...choices.map(([value, label]) => h("option", { value, text: label, selected: value === network.only })));
    this.only.value = network.only;
  }

  private async showPairing(): Promise<void> {
    const pairing = await this.actions.pair();
    if (pairing) this.pairing.show(pairing);
  }
}

/** The key, in the one line of a board's firmware and the command that puts it in force; shown until it is hidden. */
class PairingCard {
  readonly element = h("div", { class: "pairing", hidden: true, "aria-live": "polite" });
  private readonly firmware = new CopyLine("The line of firmware");
  private readonly command = new CopyLine("The command");
  private readonly then = h("p");
  private readonly file = h("p", { class: "quiet" });

  constructor() {
    this.element.append(
      h(
        "div",
        { class: "detail-head" },
        h("strong", { text: "Pair boards of Mien's own protocol" }),
        h("button", { type: "button", class: "text-button", text: "Hide the key", onclick: () => this.hide() }),
      ),
      h("p", { text: "Put this line into each board's firmware, which seals its packets with it:" }),
      this.firmware.element,
      this.then,
      this.command.element,
      this.file,
    );
  }

  show(pairing: Pairing): void {
    this.firmware.set(pairing.firmware);
    this.command.set(pairing.command);
    setText(
      this.then,
      pairing.inForce
        ? "The key is in force in this session. The next one has it by:"
        : "The key is in force from the next start, by this command. Nobody without it is received then:",
    );
    setText(this.file, `The key's file is ${pairing.file}. SlimeVR's boards and lines of text have no key.`);
    setHidden(this.element, false);
    this.element.scrollIntoView({ block: "nearest" });
  }

  private hide(): void {
    this.firmware.set("");
    setHidden(this.element, true);
  }
}

class CopyLine {
  readonly element: HTMLDivElement;
  private readonly text = h("code", { class: "mono", tabindex: 0 });
  private readonly copy = h("button", { type: "button", class: "button small", text: "Copy" });

  constructor(what: string) {
    this.copy.setAttribute("aria-label", `Copy: ${what}`);
    this.text.setAttribute("aria-label", what);
    this.copy.addEventListener("click", () => void this.toClipboard());
    this.element = h("div", { class: "copy-line" }, this.text, this.copy);
  }

  set(text: string): void {
    setText(this.text, text);
    setText(this.copy, "Copy");
  }

  private async toClipboard(): Promise<void> {
    setText(this.copy, (await copied(this.text)) ? "Copied" : "Select it and copy");
  }
}

/** Browsers give the clipboard to pages of this machine and to encrypted ones; elsewhere a selection is copied. */
async function copied(element: HTMLElement): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(element.textContent ?? "");
    return true;
  } catch {
    const selection = window.getSelection();
    selection?.selectAllChildren(element);
    return document.execCommand("copy");
  }
}

/** What can be chosen: every interface, then each with its addresses. */
export function entrances(network: NetworkStatus): [name: string, label: string][] {
  const addresses = new Map<string, string[]>();
  for (const one of network.interfaces) addresses.set(one.name, [...(addresses.get(one.name) ?? []), one.address]);
  const choices: [string, string][] = [["", "every interface"], ...[...addresses].map(([name, its]): [string, string] => [name, `${name} ${its.join(", ")}`])];
  // An address that was asked for otherwise, or an interface that is away.
  if (!choices.some(([name]) => name === network.only)) choices.push([network.only, network.only]);
  return choices;
}

/** Who can send, in a sentence or two. */
export function reachText(network: NetworkStatus, listening: readonly string[]): string {
  const who = network.sealed ? "only boards with the key are received" : "anybody there can send";
  const refused = network.sealed && network.refused > 0 ? ` ${count(network.refused)} packets without it were refused.` : "";
  if (network.open.length === 0) {
    if (network.sealed) return `Only boards with the key are received.${refused}`;
    return listening.length > 0 && listening.every(onThisMachine) ? "Only what is on this machine, or plugged into it, can send." : "Whoever reaches an address that it listens on can send.";
  }
  const elsewhere = network.elsewhere > 0 ? ` ${count(network.elsewhere)} packets from elsewhere were refused.` : "";
  if (network.only !== "") return `Listening on ${network.only} only; ${who}.${elsewhere}${refused}`;
  const names = network.interfaces.map((one) => `${one.name} ${one.address}`).join(", ");
  return `Listening on every interface: ${names}; ${who}.${elsewhere}${refused}`;
}

/** A serial line, or a port of the loopback interface. */
function onThisMachine(address: string): boolean {
  return !address.startsWith("udp://") || /^udp:\/\/(127\.\d+\.\d+\.\d+|\[::1\]|localhost):/.test(address);
}

function count(number: number): string {
  return number.toLocaleString("en");
}
