/** Consent, a page of its own: what is recorded, where, by whom and for what. Without the performer's tick nothing begins. */
import { type DatasetWish, LONGEST } from "../dataset_protocol";
import { canFilm } from "../browser_camera";
import { isCamera } from "../camera_words";
import { h, setHidden, setText } from "../dom";
import type { Hello, Status } from "../protocol";
import type { Memory } from "./memory";
import { phonesOf } from "./roles";
import type { Choice } from "./what_step";

export class ConsentStep {
  readonly element = h("form", { class: "recorder-step", "aria-labelledby": "recorder-consent", novalidate: true });
  private readonly title = h("h2", { id: "recorder-consent", tabindex: -1, text: "Consent" });
  private readonly lead = h("p", { class: "recorder-lead" });
  private readonly phone = h("li");
  private readonly cameras = h("li", { hidden: true, text: "What the headset's cameras see of your face: their pictures are in the take." });
  private readonly place = h("p");
  private readonly removal = h("p");
  private readonly recordedBy = h("input", { type: "text", class: "field", maxlength: LONGEST.recordedBy, autocomplete: "off", dir: "auto", placeholder: "Who records this and keeps it" });
  private readonly purpose = h("textarea", { class: "field", rows: 3, maxlength: LONGEST.purpose, dir: "auto", placeholder: "To what use it may be put" });
  private readonly sound = h("input", { type: "checkbox" });
  private readonly soundWords = h("span", { class: "quiet" });
  private readonly video = h("input", { type: "checkbox" });
  private readonly videoOption = h("label", { class: "recorder-option" }, this.video, h("span", {}, "Record my face on video, beside the take ", h("span", { class: "quiet", text: "By this browser's camera, without sound. It shows who you are; no training uses it." })));
  private readonly agreed = h("input", { type: "checkbox", id: "recorder-agreed" });
  private readonly agreement = h("span");
  private readonly problem = h("p", { class: "recorder-problem", role: "alert", hidden: true });
  private readonly begin = h("button", { type: "submit", class: "button large primary", text: "Begin" });
  private choice: Choice | null = null;
  private busy = false;

  /** `begin` gives what stands against it, or "". */
  constructor(
    private readonly memory: Memory,
    private readonly ask: (wish: DatasetWish) => Promise<string>,
    back: () => void,
  ) {
    this.element.append(
      this.title,
      this.lead,
      h("h3", { text: "What is recorded" }),
      h(
        "ul",
        { class: "consent-list" },
        h("li", { text: "How your face moves: all that the sensors on and about it send." }),
        this.phone,
        this.cameras,
        h("li", { text: "The texts that you read and the faces that you are asked for, with the times at which you were." }),
        h("li", { text: "The sound of your voice and a video of your face, if you choose so below." }),
        h("li", { text: "A take holds everything that the sensors have sent since the session began, and the microphone if you agree to it: also what came before you pressed Begin. Only what comes after it counts as the dataset's." }),
      ),
      h("label", { class: "recorder-option" }, this.sound, h("span", {}, "Record the sound of my voice too ", this.soundWords)),
      this.videoOption,
      h("h3", { text: "Where, by whom, and what for" }),
      this.place,
      h("label", { class: "recorder-field" }, h("span", { class: "recorder-label", text: "Recorded by" }), this.recordedBy),
      h("label", { class: "recorder-field" }, h("span", { class: "recorder-label", text: "What for" }), this.purpose),
      h("h3", { text: "You may stop at any moment" }),
      h("p", { text: "You need give no reason. What was recorded until then stays until it is deleted." }),
      this.removal,
      h("label", { class: "recorder-agree" }, this.agreed, this.agreement),
      this.problem,
      h("div", { class: "recorder-foot" }, h("button", { type: "button", class: "button large", text: "Back", onclick: back }), this.begin),
    );
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.submit();
    });
    this.agreed.addEventListener("change", () => {
      if (this.agreed.checked) this.complain("");
    });
  }

  focus(): void {
    this.title.focus({ preventScroll: true });
  }

  /** Asks anew: whoever agreed before agreed to that recording. */
  show(choice: Choice): void {
    this.choice = choice;
    this.agreed.checked = false;
    this.sound.checked = false;
    this.video.checked = false;
    setHidden(this.videoOption, !canFilm());
    this.recordedBy.value = this.memory.value.recordedBy;
    this.purpose.value = this.memory.value.purpose;
    setText(this.lead, `For ${choice.performer}, before anything is recorded for the dataset “${choice.dataset}”. Please read it, and ask about whatever is not clear.`);
    setText(this.place, `All of it stays in the folder “${choice.dataset}”, beside the other takes on the machine that runs this session. The recording is sent nowhere.`);
    setText(this.removal, `Each recording is one file, a take: deleting its file deletes it, a video beside it is a file of the same name, and deleting the folder deletes the dataset. Whoever is named above can do that. What the session itself keeps meanwhile is gone when it ends.`);
    setText(this.agreement, `I am ${choice.performer}. I have read this, and I agree to be recorded.`);
    this.complain("");
  }

  update(hello: Hello | null, status: Status | null): void {
    const phones = phonesOf(hello, status);
    setText(
      this.phone,
      phones.length > 0
        ? "What a phone says of your face while it looks at you: the weights of its expressions and how your head is turned, never its picture."
        : "No phone looks at your face now. Should one join, what it says of your face is recorded too, never its picture.",
    );
    setHidden(this.cameras, !(hello?.sensors ?? []).some(isCamera));
    const hearing = status?.hearing ?? null;
    const hears = hearing !== null && !hearing.shut;
    this.sound.disabled = !hears;
    if (!hears) this.sound.checked = false;
    setText(this.soundWords, hears ? "" : "This session hears no microphone.");
  }

  private complain(problem: string): void {
    setText(this.problem, problem);
    setHidden(this.problem, problem === "");
    if (problem !== "") this.problem.scrollIntoView({ block: "nearest" });
    this.element.classList.toggle("unticked", problem !== "" && !this.agreed.checked);
  }

  private async submit(): Promise<void> {
    if (!this.choice || this.busy) return;
    const { dataset, script, performer, pace } = this.choice;
    // A consent is of single lines in the take.
    const one = (field: HTMLInputElement | HTMLTextAreaElement) => field.value.replace(/\s+/g, " ").trim();
    const recordedBy = one(this.recordedBy);
    const purpose = one(this.purpose);
    const missing = recordedBy === "" ? "Say who records this and keeps it." : purpose === "" ? "Say what it is recorded for." : "";
    if (missing !== "" || !this.agreed.checked) {
      this.complain(missing || `Nothing is recorded without consent: ${performer} has to tick the box above first.`);
      // The words stay in sight, below the field that they are about.
      (recordedBy === "" ? this.recordedBy : purpose === "" ? this.purpose : this.agreed).focus({ preventScroll: true });
      return;
    }
    this.complain("");
    this.memory.set({ recordedBy, purpose });
    this.busy = true;
    this.begin.disabled = true;
    setText(this.begin, "Beginning …");
    const problem = await this.ask({ name: dataset, script: script.name, performer, recorded_by: recordedBy, purpose, sound: this.sound.checked, video: this.video.checked && canFilm(), agreed: true, pace });
    this.busy = false;
    this.begin.disabled = false;
    setText(this.begin, "Begin");
    this.complain(problem);
  }
}
